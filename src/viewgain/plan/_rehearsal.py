"""A scan before it is taken: a box that may stand there, seen by the simulated camera and measured as a real scan is (ours).

The expected error of a view is a formula with something learned in it. A rehearsal is one run of the whole chain, as costly as a
scan and its measurement, and knows what the formula cannot: what the estimator makes of this very box from there.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from viewgain.arrays import Pose, Poses
from viewgain.box import Box
from viewgain.camera import Sensor
from viewgain.errors import ScanError
from viewgain.gain import MISS, VolumeEstimator, costs
from viewgain.geometry import inverse, pose, rotation_from_rotvec
from viewgain.measure import POSE_SIGMA, measure
from viewgain.plan._belief import Belief
from viewgain.rays import SceneCaster
from viewgain.scans import Scan
from viewgain.scenes import Scene
from viewgain.simulate import RangeError, capture, draw_range_error

AS_NOISY = 0.1
"""Two scans of a box in which measuring finds noise that differs by no more than this share are as noisy."""
SCANS_FOR_NOISE = 6
"""Most scans that are taken to find out how noisy a camera is."""

Arrivals: TypeAlias = Callable[[np.random.Generator], Poses]
"""Draws (V, 4, 4) where cameras that are sent to V candidates arrive, each in the frame of its candidate."""


def arriving_within(count: int, pose_sigma: tuple[float, float] = POSE_SIGMA) -> Arrivals:
    """Return arrivals at ``count`` candidates that are normal about them.

    Args:
        count: Number of candidates, V.
        pose_sigma: Standard deviation per axis, metres and radians.
    """
    metres, radians = pose_sigma

    def drawn(rng: np.random.Generator) -> Poses:
        moves = rng.normal(0.0, (radians,) * 3 + (metres,) * 3, (count, 6))
        return np.stack([pose(rotation_from_rotvec(move[:3]), move[3:]) for move in moves])

    return drawn


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """What all candidates are tried on alike, so that they differ by nothing but their places (common random numbers)."""

    of: int
    """Which of the believed boxes."""
    box: Box
    """That box, present camera's frame."""
    caster: SceneCaster
    """It alone on its floor, in its own frame, ready for rays."""
    sensor: Sensor
    """The camera."""
    error: RangeError
    """Its systematic error."""
    arrived: Poses
    """(V, 4, 4) where it arrives, each in the frame of its candidate."""
    seed: int
    """Source of the noise."""

    def outcome(self, index: int, camera_to_current: Pose, estimator: VolumeEstimator) -> float:
        """Return what one scan from candidate ``index`` costs (:func:`viewgain.gain.costs`).

        Args:
            index: Which candidate.
            camera_to_current: (4, 4) its pose.
            estimator: Who measures.
        """
        scan = self.scan(camera_to_current @ self.arrived[index], np.random.default_rng(self.seed))
        return MISS if scan is None else self.cost(lambda: estimator(scan))

    def scan(self, camera_to_current: Pose, rng: np.random.Generator) -> Scan | None:
        """Return a scan of the box from a pose, in the world of the box's own frame; None where next to nothing comes back.

        Args:
            camera_to_current: (4, 4) where the camera is.
            rng: Source of its noise.
        """
        camera_to_box = inverse(self.box.box_to_camera) @ camera_to_current
        try:
            return capture(self.caster, camera_to_box, self.sensor, rng=rng, error=self.error)
        except ScanError:
            return None

    def cost(self, volume: Callable[[], float]) -> float:
        """Return what it costs, 0 to 1, to have the volume that somebody works out; all of it where nothing comes of that.

        Args:
            volume: Gives cubic metres; NaN for none.
        """
        try:
            return float(costs(volume() / self.box.volume - 1))
        except (ScanError, np.linalg.LinAlgError):
            return MISS


def trials(belief: Belief, arrivals: Arrivals, rng: np.random.Generator) -> Iterator[Trial]:
    """Yield trials without end: the believed boxes in a drawn order, every one once before any comes again.

    The scene is the box alone. The camera is one of its model, as noisy as the present scan (:func:`as_noisy`), with a systematic
    error as calibration leaves it.

    Args:
        belief: What is believed about the box.
        arrivals: Where cameras arrive.
        rng: Source of all randomness.
    """
    casters, camera = [_alone(box) for box in belief.boxes], as_noisy(belief, rng)
    while True:
        for of in rng.permutation(len(casters)).tolist():
            error = draw_range_error(belief.sensor, rng=rng)
            arrived = arrivals(rng)
            yield Trial(of, belief.boxes[of], casters[of], camera, error, arrived, int(rng.integers(2**63)))


def as_noisy(belief: Belief, rng: np.random.Generator) -> Sensor:
    """Return the camera with so much more noise than its data sheet has that a simulated scan is as noisy as the one so far.

    What a data sheet leaves out makes simulated scans noisier than it says, and of much noise measuring finds too little. So the
    middle box is scanned from where it was first seen, and measured, until the two are as noisy (:data:`AS_NOISY`). Less noise
    than there is on the data sheet is never claimed, nor, as far as one scan tells, so much that no box is found.
    """
    camera_to_box, caster = inverse(belief.mean.box_to_camera) @ belief.cameras[0], _alone(belief.mean)
    showing, factor = 1.0, 1.0
    for _ in range(SCANS_FOR_NOISE):
        found = _noise_of(caster, camera_to_box, belief.sensor.noisier(factor), belief.sensor, rng)
        if found is None:
            if factor == 1.0:
                break
            factor = float(np.sqrt(showing * factor))  # half way back
            continue
        showing, louder = factor, belief.noise / found
        factor = max(factor * louder, 1.0)
        if factor == showing or abs(louder - 1) < AS_NOISY:
            return belief.sensor.noisier(factor)
    return belief.sensor.noisier(showing)


def _noise_of(caster: SceneCaster, camera_to_box: Pose, camera: Sensor, known: Sensor, rng: np.random.Generator) -> float | None:
    """Return the noise that measuring finds in one scan, by the data sheet that is ``known``; None where it finds no box."""
    try:
        shown = measure(capture(caster, camera_to_box, camera, rng=rng), camera=known).boxes
    except (ScanError, np.linalg.LinAlgError):
        return None
    return shown[0].views[0].noise if shown else None


def _alone(box: Box) -> SceneCaster:
    """Return a box on its floor, in its own frame."""
    return SceneCaster(Scene((Box(np.eye(4), box.extents),)))

"""The relative volume error to expect of a view, before it is taken: a surrogate of many scans and measurements (ours).

The predicted covariance says how far off a measurement will be; what a measurement needs (bounded dimensions, enough returns)
says whether there will be one. Where there is none the error is 1. This physical guess is then moved by what was learned from
real runs. Under a millisecond a view, of many at once, where a simulated scan and its measurement take a hundred. How well it
agrees with the real estimator: ``python -m benchmarks error-model`` (with and without the learned part) and ``surrogate`` (on
boxes of other seeds).
"""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Pose, Poses, Vector
from viewgain.box import Box
from viewgain.camera import Sensor
from viewgain.geometry import inverse
from viewgain.measure import MAX_SLENDER, OPEN_SHARE, POSE_SIGMA, Knowledge
from viewgain.plan._belief import Belief, extent_sigmas, relative_sigma
from viewgain.plan._circumstances import circumstances
from viewgain.plan._error_model import ErrorModel, Outcome, shipped_error_model
from viewgain.plan._policy import Assessment
from viewgain.plan._predict import on_arrival, paired
from viewgain.plan._showing import Showing, showing, showings

MEAN_OF_NORMAL = float(np.sqrt(2 / np.pi))
"""Mean of |x| over the standard deviation of a normal x."""
CUT, CUT_AND_LONG = 0.03, 0.99
"""Chance that a scan of a box that leaves the image gives no volume: where it shows every dimension from end to end, and where
it does not. Like the other chances here read off simulated scans by a pico flexx, seeds of their own: the first off 636 scans of
168 boxes, the others off 1,148 of 150."""
FEW = 100.0
"""Returns at which every second measurement fails; the odds are 100 / returns."""
SLENDER = 0.8
"""Chance that a tower is taken for no box: one higher than measuring believes of a box (``viewgain.measure.MAX_SLENDER``)."""
OPEN_POWER = 3.0
"""Power of the odds that a dimension stays open: of its relative standard deviation over the share that counts as open."""


def expected_error(
    box: Box, camera_to_current: Pose, sensor: Sensor, noise: float = 1.0, learned: ErrorModel | None = None
) -> float:
    """Return the expected |relative volume error| of one scan of a box, 0 to 1; a scan without an estimate counts as 1.

    Args:
        box: The true box, or one believed in, in the present camera's frame.
        camera_to_current: (4, 4) pose of the scan in that frame.
        sensor: The camera.
        noise: Its noise on this scene as a multiple of the data sheet's.
        learned: The learned part; None for the one that comes with the package.
    """
    seen = showing(box, camera_to_current, sensor, noise)
    return float(of_shown(box, seen.knowledge, (seen,), sensor, learned))


def fused_expected_error(
    box: Box,
    first: Showing,
    camera_to_current: Pose,
    sensor: Sensor,
    noise: float = 1.0,
    pose_sigma: tuple[float, float] = POSE_SIGMA,
) -> float:
    """Return the same of a scan from a pose fused with the present one, of which ``first`` says what it shows.

    Args:
        box: The box, in the present camera's frame.
        first: What is known of it from the present camera.
        camera_to_current: (4, 4) pose of the further scan.
        sensor: The camera.
        noise: Its noise.
        pose_sigma: How exactly the camera arrives, standard deviation per axis, metres and radians.
    """
    known, seen = fused_showing(box, first, camera_to_current, sensor, noise, pose_sigma)
    return float(of_shown(box, known, seen, sensor))


def fused_showing(
    box: Box,
    first: Showing,
    camera_to_current: Pose,
    sensor: Sensor,
    noise: float = 1.0,
    pose_sigma: tuple[float, float] = POSE_SIGMA,
) -> tuple[Knowledge, tuple[Showing, Showing]]:
    """Return what the present scan and one from a pose say together, and what each shows; arguments as there."""
    second = showing(box, camera_to_current, sensor, noise)
    added = on_arrival(second.knowledge, box, box.in_frame(inverse(camera_to_current)), pose_sigma)
    return first.knowledge.plus(added), (first, second)


def of_shown(box: Box, known: Knowledge, seen: tuple[Showing, ...], sensor: Sensor, learned: ErrorModel | None = None) -> Array:
    """Return the expected |relative volume error| where ``known`` is what the views ``seen`` say together.

    Exactly 1 where nothing of the box comes back. ``learned`` as :func:`expected_error`. Of a stack of n boxes (n,).
    """
    guess = physical_outcome(box, known, seen, sensor)
    expected = (learned or shipped_error_model()).corrected(guess, circumstances(box, known, seen, sensor)).expected
    return np.where(np.any([view.returns.any(axis=-1) for view in seen], axis=0), expected, 1.0)


def physical_outcome(box: Box, known: Knowledge, seen: tuple[Showing, ...], sensor: Sensor) -> Outcome:
    """Return what comes of it without anything learned from runs: the chance of no volume, else the mean of a normal error."""
    off = np.minimum(MEAN_OF_NORMAL * relative_sigma(known, box, sensor), 1.0)
    return Outcome(chance_of_no_volume(box, known, seen, sensor), off)


def chance_of_no_volume(box: Box, known: Knowledge, seen: tuple[Showing, ...], sensor: Sensor) -> Array:
    """Return how likely there is no volume: a dimension stays open, the box is cut, too little comes back, it looks like a post.

    The four count as independent; arguments as :func:`of_shown`.
    """
    looseness = np.max(extent_sigmas(known, sensor) / (OPEN_SHARE * box.extents), axis=-1)
    still_open = 1 - 1 / (1 + looseness**OPEN_POWER)
    few = 1 - 1 / (1 + FEW / np.maximum(np.max([view.returns.sum(axis=-1) for view in seen], axis=0), 1.0))
    slender = SLENDER * (box.extents[..., 2] > MAX_SLENDER * box.extents[..., :2].max(axis=-1))
    spanned = np.any([view.spanned for view in seen], axis=0).all(axis=-1)
    cut = np.all([view.cut for view in seen], axis=0) * np.where(spanned, CUT, CUT_AND_LONG)
    return np.asarray(1 - (1 - still_open) * (1 - cut) * (1 - few) * (1 - slender))


@dataclass(frozen=True, slots=True)
class ExpectedErrorPolicy:
    """Model-based: the least expected volume error after the view, over all boxes still possible.

    Where :class:`CovariancePolicy` asks how certain the volume would be, this one also asks whether there would be one, and it
    can ask about the candidate's scan alone.
    """

    fused: bool = True
    """Whether the candidate is fused with what is known, or has to measure the box alone, as it must where nothing is known."""
    pose_sigma: tuple[float, float] = POSE_SIGMA
    """Standard deviation of a camera pose, metres and radians per axis."""
    name: str = "expected"

    def assess(self, belief: Belief, candidates: Poses, tolerance: float) -> tuple[Assessment, ...]:
        """Return one assessment per candidate; the score is 1 minus the expected error."""
        del tolerance
        errors = self.errors(belief, candidates).mean(axis=0)
        return tuple(Assessment(1 - error, None, None) for error in errors.tolist())

    def errors(self, belief: Belief, candidates: Poses) -> Array:
        """Return (b, v) the expected error after each candidate, were it the one or the other of the boxes believed in."""
        alone = not self.fused or belief.glimpsed
        errors = self._alone(belief, candidates) if alone else self._with_present(belief, candidates)
        return errors.reshape(len(belief.boxes), len(candidates))

    def _alone(self, belief: Belief, candidates: Poses) -> Vector:
        boxes, seen_from = paired(belief.boxes, candidates)
        seen = showings(seen_from, belief.sensor, belief.noise)
        return of_shown(boxes, seen.knowledge, (seen,), belief.sensor)

    def _with_present(self, belief: Belief, candidates: Poses) -> Vector:
        # One batch for the present pose, which comes first, and the candidates: most of a small one's time is its own.
        boxes, seen_from = paired(belief.boxes, np.concatenate([np.eye(4)[None], candidates]))
        views = np.arange(len(boxes.extents)).reshape(len(belief.boxes), -1)
        first, second = np.repeat(views[:, 0], len(candidates)), views[:, 1:].ravel()
        seen = showings(seen_from, belief.sensor, belief.noise)
        added = on_arrival(seen.knowledge, boxes, seen_from, self.pose_sigma).take(second)
        both = seen.take(first), seen.take(second)
        return of_shown(boxes.take(second), belief.knowledge.plus(added), both, belief.sensor)

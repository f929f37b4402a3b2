"""Many jittered scans of one box from every station of a rig, and the volume error of each: what a histogram is filled with.

Scan k of station v draws from the seed (seed, v, k) and from nothing else, so any share of the scans can be made anywhere, every
estimator is given the same scans, and more scans per station leave the first ones as they were.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from viewgain.arrays import Array, Pose, Vector
from viewgain.box import Box
from viewgain.camera import Sensor
from viewgain.errors import ConfigError, ScanError
from viewgain.gain._estimators import VolumeEstimator, measured_volume
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.measure import POSE_SIGMA, Measurement, fuse_measurements, measure
from viewgain.rays import SceneCaster
from viewgain.rigs import Rig, Target, poses
from viewgain.scans import Scan
from viewgain.scenes import Scene
from viewgain.simulate import ALL_EFFECTS, NO_ERROR, Effects, RangeError, capture


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoxScans:
    """A box on the floor, and the jittered scans of it: all that makes them, and none of them yet."""

    box: Box
    """The box, world frame (z up), on the floor z = 0."""
    rig: Rig
    """Where the camera stands, with its jitter."""
    sensor: Sensor
    """The camera."""
    seed: int
    """Source of all randomness, >= 0."""
    elevation: float = float(np.deg2rad(35.0))
    """For the stations that leave it open, radians."""
    distance: float = 1.2
    """For the stations that leave it open, metres."""
    effects: Effects = ALL_EFFECTS
    """What the camera does to the truth."""
    error: RangeError = NO_ERROR
    """Its systematic error."""
    caster: SceneCaster = field(init=False, repr=False)
    """The scene, ready for rays."""

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise ConfigError(f"box scans: got seed {self.seed}, wanted a whole number from 0 on")
        object.__setattr__(self, "caster", SceneCaster(Scene((self.box,))))

    @property
    def views(self) -> int:
        """Number of stations, V."""
        return len(self.rig.stations)

    def camera_to_world(self, view: int, number: int) -> Pose:
        """Return the (4, 4) jittered pose of scan ``number`` from station ``view``."""
        return self._posed(view, number)[0]

    def scan(self, view: int, number: int) -> Scan | None:
        """Return scan ``number`` from station ``view``; None where the camera sees next to nothing.

        Raises:
            ConfigError: If there is no such station or number.
        """
        camera_to_world, rng = self._posed(view, number)
        name = f"view{view:02d}_{number:03d}"
        try:
            return capture(
                self.caster, camera_to_world, self.sensor, rng=rng, effects=self.effects, error=self.error, source=name
            )
        except ScanError:
            return None

    def _posed(self, view: int, number: int) -> tuple[Pose, np.random.Generator]:
        if not 0 <= view < self.views or number < 0:
            raise ConfigError(
                f"box scans: got scan {number} of view {view}, wanted a view under {self.views} and numbers from 0 on"
            )
        rng = np.random.default_rng([self.seed, view, number])
        target = Target(self.box.box_to_camera, self.box.extents)
        cameras = poses(self.rig, target, elevation=self.elevation, distance=self.distance, rng=rng)
        return cameras[view], rng


def volume_errors(scans: BoxScans, estimator: VolumeEstimator, numbers: Iterable[int]) -> Array:
    """Return the (V, n) relative volume errors V / V* - 1 of scans from every station, each measured alone; NaN for a miss.

    Args:
        scans: The box and its scans.
        estimator: Who measures, of :func:`viewgain.gain.volume_estimator` or your own.
        numbers: Which n scans of each station, e.g. ``range(700)``.
    """
    chosen = list(numbers)
    errors = np.full((scans.views, len(chosen)), np.nan)
    for view in range(scans.views):
        for column, number in enumerate(chosen):
            scan = scans.scan(view, number)
            errors[view, column] = np.nan if scan is None else estimator(scan) / scans.box.volume - 1
    return errors


def fused_errors(
    scans: BoxScans, present: int, numbers: Iterable[int], *, pose_sigma: tuple[float, float] | None = POSE_SIGMA
) -> tuple[Array, Vector]:
    """Return the volume errors of every station's scans, each fused with one from the present station (the default estimator).

    For each number a first scan is taken at the present station; scan ``number`` of every station is then fused with it. From the
    present station itself that is a second scan from there, its own jitter and noise, so that staying is a candidate too.

    Args:
        scans: The box and its scans.
        present: The present station.
        numbers: Which n scans of each station.
        pose_sigma: The camera's pose is believed to be off by errors drawn with these standard deviations (metres and radians per
            axis), and fused as such; None fuses without poses, by what the scans show.

    Returns:
        (V, n) relative volume errors after fusing, NaN for a miss; (n,) those of the first scans alone.

    Raises:
        ConfigError: If there is no such station.
    """
    chosen = list(numbers)
    errors, alone = np.full((scans.views, len(chosen)), np.nan), np.full(len(chosen), np.nan)
    for column, number in enumerate(chosen):
        # Odd numbers are first scans, even ones are candidates: no scan is fused with itself.
        first = measured_scan(scans, present, 2 * number + 1, pose_sigma)
        alone[column] = _error(scans, first)
        for view in range(scans.views):
            second = measured_scan(scans, view, 2 * number, pose_sigma)
            both = [each for each in (first, second) if each is not None]
            if both:
                errors[view, column] = _error(scans, fuse_measurements(both, pose_sigma=pose_sigma or POSE_SIGMA))
    return errors, alone


def believed_scan(scans: BoxScans, view: int, number: int, pose_sigma: tuple[float, float] | None = POSE_SIGMA) -> Scan | None:
    """Return scan ``number`` from station ``view``, with the pose that the camera believes in; None for no scan.

    Args:
        scans: The box and its scans.
        view: The station.
        number: Which scan of it.
        pose_sigma: How far the belief is from the truth, standard deviation per axis, metres and radians; None for no pose.

    Raises:
        ConfigError: If there is no such station or number.
    """
    scan = scans.scan(view, number)
    if scan is None or pose_sigma is None:
        return None if scan is None else replace(scan, camera_to_world=None)
    rng = np.random.default_rng([scans.seed, view, number, 1])
    metres, radians = pose_sigma
    miss = pose(rotation_from_rotvec(rng.normal(0.0, radians, 3)), rng.normal(0.0, metres, 3))
    return scan.posed(scans.camera_to_world(view, number) @ miss)


def measured_scan(
    scans: BoxScans, view: int, number: int, pose_sigma: tuple[float, float] | None = POSE_SIGMA
) -> Measurement | None:
    """Return the default estimator's measurement of :func:`believed_scan`; arguments and errors as there."""
    scan = believed_scan(scans, view, number, pose_sigma)
    return None if scan is None else measure(scan, camera=scans.sensor)


def _error(scans: BoxScans, measured: Measurement | None) -> float:
    return float("nan") if measured is None else measured_volume(measured) / scans.box.volume - 1

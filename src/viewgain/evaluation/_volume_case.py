"""Fresh boxes from a seed, and the cameras that look at them: what planners are asked about."""

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from viewgain.arrays import Mask, Poses
from viewgain.box import Box
from viewgain.camera import Sensor, sensor
from viewgain.errors import ConfigError
from viewgain.gain import ESTIMATORS, BoxScans, believed_scan
from viewgain.geometry import inverse
from viewgain.measure import POSE_SIGMA
from viewgain.rigs import Rig, Target, poses, refusals, rig
from viewgain.scans import Scan
from viewgain.scenes import SceneRanges, random_box
from viewgain.simulate import draw_range_error

LEAST_CAPTURES = 2
"""Fewer scans of each position have no spread."""
_CASE, _ASIDE = 0x7632, 0x7636
"""Streams of boxes, and of where the rig's middle lies from them."""
_TRIES = 1000


@dataclass(frozen=True, slots=True, kw_only=True)
class VolumeSettings:
    """What is asked: boxes, rig, camera, estimator. Two of equal settings are about the same boxes and the same scans."""

    seed: int = 0
    """Source of all boxes and scans, >= 0."""
    rig: str = "irregular4"
    """Positions: a preset or a rig file."""
    camera: str = "pico_flexx"
    """Camera: a preset or a file; each box has one of its own, with a systematic error drawn from what calibration leaves."""
    estimator: str = "default"
    """Who measures the volume, of ``viewgain.gain.ESTIMATORS``."""
    captures: int = 24
    """Scans of each position that score it; as many others are the oracle's."""
    fused: bool = False
    """Whether a position is worth what its scan and the present one say together, rather than its scan alone."""
    side: tuple[float, float] = (0.05, 1.2)
    """Least and longest side of a box, metres."""
    distance: float = 1.2
    """For stations that leave it open, metres from the box's centre."""
    elevation_deg: float = 35.0
    """For stations that leave it open, degrees."""
    off_centre: float = 0.0
    """How far the middle of the rig lies from the box's centre, standard deviation per axis, metres; 0 or more."""

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise ConfigError(f"evaluate: got seed {self.seed}, wanted 0 or more")
        if self.captures < LEAST_CAPTURES:
            raise ConfigError(f"evaluate volume: got {self.captures} captures, wanted {LEAST_CAPTURES} or more")
        if not 0 < self.side[0] <= self.side[1] < np.inf or not 0 < self.distance < np.inf:
            raise ConfigError(
                f"evaluate: got sides {self.side} and distance {self.distance}, wanted [low, high], positive and finite"
            )
        if not np.isfinite(self.elevation_deg):
            raise ConfigError(f"evaluate: got elevation {self.elevation_deg}, wanted a finite number of degrees")
        if not 0 <= self.off_centre < np.inf:
            raise ConfigError(f"evaluate volume: got {self.off_centre} m off centre, wanted a finite length of 0 or more")
        if self.estimator not in ESTIMATORS:
            raise ConfigError(f"estimator: got {self.estimator!r}, wanted one of {', '.join(ESTIMATORS)}")
        if self.fused and self.estimator != "default":
            raise ConfigError(f"evaluate volume: got --fused with {self.estimator}, which cannot fuse; take default")
        self.stations()
        sensor(self.camera)

    def stations(self) -> Rig:
        """Return the rig."""
        return rig(self.rig)

    def to_dict(self) -> dict[str, Any]:
        """Return the question as plain values; a rig whose middle is the box's goes without saying, as it always did."""
        plain = asdict(self)
        return plain if self.off_centre else {name: value for name, value in plain.items() if name != "off_centre"}


@dataclass(frozen=True, slots=True, eq=False)
class VolumeCase:
    """One box: where it stands, where a camera may stand, and where it stands now."""

    number: int
    """Which box."""
    settings: VolumeSettings
    """What it was drawn for."""
    scans: BoxScans
    """The box and all its scans."""
    stations: Poses
    """(V, 4, 4) ``camera_to_world`` of the positions, without jitter."""
    reachable: Mask
    """(V,) where a camera can stand; at least two positions."""
    present: int
    """Where the camera stands when it decides, drawn from those."""

    @property
    def box(self) -> Box:
        """The box, world frame."""
        return self.scans.box

    @property
    def camera(self) -> Sensor:
        """The camera as its data sheet has it."""
        return self.scans.sensor

    @property
    def seen(self) -> Scan | None:
        """The scan to decide by, with the pose that the camera believes in; None where it shows next to nothing.

        It is none of those that score the positions.
        """
        return believed_scan(self.scans, self.present, 2 * self.settings.captures, self._believed)

    def arrivals(self, rng: np.random.Generator) -> Poses:
        """Draw (V, 4, 4) where cameras sent to the positions arrive, by the rig's jitter, each in the frame of its position."""
        scans = self.scans
        there = poses(scans.rig, scans.target, elevation=scans.elevation, distance=scans.distance, rng=rng)
        return np.stack([inverse(station) @ camera for station, camera in zip(self.stations, there, strict=True)])

    @property
    def _believed(self) -> tuple[float, float]:
        """Standard deviation of the camera's belief about its pose; where nothing is fused no estimator looks at poses."""
        return POSE_SIGMA if self.settings.fused else (0.0, 0.0)


def volume_case(settings: VolumeSettings, number: int) -> VolumeCase:
    """Return box ``number`` of a seed. A box that leaves a camera fewer than two positions is drawn anew.

    Raises:
        ConfigError: If no box of 1,000 leaves two positions.
    """
    rng, rng_aside = (np.random.default_rng([settings.seed, stream, number]) for stream in (_CASE, _ASIDE))
    stations, camera = settings.stations(), sensor(settings.camera)
    ranges = SceneRanges(extent=settings.side, yaw_deg=(0.0, 360.0))
    for _ in range(_TRIES):
        box = random_box(rng, ranges)
        target, aside = Target(box.box_to_camera, box.extents), settings.off_centre * rng_aside.normal(size=3)
        elevation = float(np.deg2rad(settings.elevation_deg))
        cameras = poses(stations, target.shifted(aside), elevation=elevation, distance=settings.distance)
        limits = replace(stations, min_distance=max(stations.min_distance, camera.range_min))
        reachable = np.array([reason is None for reason in refusals(limits, cameras, target)])
        if reachable.sum() < 2:
            continue
        scans = BoxScans(
            box=box,
            rig=stations,
            sensor=camera,
            seed=int(rng.integers(2**31)),
            elevation=elevation,
            distance=settings.distance,
            error=draw_range_error(camera, rng=rng),
            aside=aside,
        )
        present = int(rng.choice(np.flatnonzero(reachable)))
        return VolumeCase(number, settings, scans, cameras, reachable, present)
    raise ConfigError(
        f"evaluate: got no box of {_TRIES} that leaves two positions of rig {stations.name}; take smaller boxes or"
        " a greater --distance"
    )

"""Many jittered scans of what stands on the floor, from every station of a rig.

Scan k of station v draws from the seed (seed, v, k) and from nothing else, so any share of the scans can be made anywhere, every
estimator is given the same scans, and more scans per station leave the first ones as they were.
"""

from abc import abstractmethod
from dataclasses import dataclass, field, replace

import numpy as np

from viewgain.arrays import Pose, Vector3
from viewgain.box import Box
from viewgain.camera import Sensor
from viewgain.errors import ConfigError, ScanError
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.measure import POSE_SIGMA
from viewgain.meshes import TriangleMesh
from viewgain.rays import SceneCaster
from viewgain.rigs import Rig, Target, poses
from viewgain.scans import Scan
from viewgain.scenes import Scene
from viewgain.simulate import ALL_EFFECTS, NO_ERROR, Effects, RangeError, capture


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StationScans:
    """Something on the floor z = 0 of a world, and the jittered scans of it: all that makes them, and none of them yet."""

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
            raise ConfigError(f"scans: got seed {self.seed}, wanted a whole number from 0 on")
        object.__setattr__(self, "caster", SceneCaster(self.scene))

    @property
    @abstractmethod
    def scene(self) -> Scene:
        """What is seen, world frame (z up)."""

    @property
    @abstractmethod
    def target(self) -> Target:
        """What the rig stands around, world frame."""

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
            raise ConfigError(f"scans: got scan {number} of view {view}, wanted a view under {self.views} and numbers from 0 on")
        rng = np.random.default_rng([self.seed, view, number])
        cameras = poses(self.rig, self.target, elevation=self.elevation, distance=self.distance, rng=rng)
        return cameras[view], rng


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BoxScans(StationScans):
    """Scans of a box."""

    box: Box
    """The box, world frame, on the floor."""
    aside: Vector3 = field(default_factory=lambda: np.zeros(3))
    """(3,) from the box's centre to the middle of the rig, metres, world."""

    @property
    def scene(self) -> Scene:
        """The box alone."""
        return Scene((self.box,))

    @property
    def target(self) -> Target:
        """The box, or as much space beside it."""
        return Target(self.box.box_to_camera, self.box.extents).shifted(self.aside)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeshScans(StationScans):
    """Scans of an object of any shape."""

    mesh: TriangleMesh
    """The object, world frame, on the floor."""

    @property
    def scene(self) -> Scene:
        """The object alone."""
        return Scene(meshes=(self.mesh,))

    @property
    def target(self) -> Target:
        """The box around the object along the world's axes."""
        return Target.at(self.mesh.bounds.mean(axis=0), self.mesh.extents)


def believed_scan(
    scans: StationScans, view: int, number: int, pose_sigma: tuple[float, float] | None = POSE_SIGMA
) -> Scan | None:
    """Return scan ``number`` from station ``view``, with the pose that the camera believes in; None for no scan.

    Args:
        scans: What is seen and its scans.
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

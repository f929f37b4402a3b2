"""A seeded generator of scenes and of cameras that look at them; every distribution is documented."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Pose, Vector3
from viewgain.box import Box
from viewgain.geometry import look_at, pose, rotation_from_rotvec
from viewgain.scenes._scene import UP


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneRanges:
    """Distributions of random scenes: every quantity is uniform between the two numbers, angles in degrees."""

    extent: tuple[float, float] = (0.1, 0.6)
    """Each side length, metres."""
    yaw_deg: tuple[float, float] = (0.0, 90.0)
    """Rotation of the box about the vertical."""
    azimuth_deg: tuple[float, float] = (0.0, 360.0)
    """Direction from which the camera looks."""
    elevation_deg: tuple[float, float] = (15.0, 60.0)
    """Height of the camera above the horizon as seen from the box."""
    distance: tuple[float, float] = (0.7, 1.6)
    """From the camera to the box's centre, metres."""
    aim_sd: float = 0.05
    """Standard deviation of where the camera is aimed, per axis, metres."""
    roll_sd_deg: float = 3.0
    """Standard deviation of the camera's roll."""


def standing_box(extents: Vector3, *, yaw: float = 0.0, at: tuple[float, float] = (0.0, 0.0)) -> Box:
    """Return a box on the world's floor.

    Args:
        extents: (3,) side lengths along x, y and z, metres.
        yaw: Rotation about the vertical, radians.
        at: Where on the floor its centre stands, metres.
    """
    turn = rotation_from_rotvec(np.array([0.0, 0.0, yaw]))
    return Box(pose(turn, np.array([at[0], at[1], 0.0])), np.asarray(extents, dtype=float))


def random_box(rng: np.random.Generator, ranges: SceneRanges | None = None) -> Box:
    """Return a random box at the origin of the world's floor."""
    ranges = ranges or SceneRanges()
    return standing_box(rng.uniform(*ranges.extent, 3), yaw=float(np.deg2rad(rng.uniform(*ranges.yaw_deg))))


def random_view(rng: np.random.Generator, box: Box, ranges: SceneRanges | None = None) -> Pose:
    """Return a random ``camera_to_world`` that looks roughly at ``box``."""
    ranges = ranges or SceneRanges()
    azimuth, elevation = np.deg2rad(rng.uniform(*ranges.azimuth_deg)), np.deg2rad(rng.uniform(*ranges.elevation_deg))
    target = box.centre + rng.normal(0.0, ranges.aim_sd, 3)
    return orbit_pose(
        target, azimuth, elevation, rng.uniform(*ranges.distance), float(np.deg2rad(rng.normal(0, ranges.roll_sd_deg)))
    )


def orbit_pose(target: Vector3, azimuth: float, elevation: float, distance: float, roll: float = 0.0) -> Pose:
    """Return ``camera_to_world`` of a camera that looks at ``target`` from a direction and distance (radians, metres)."""
    direction = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    camera = look_at(target + distance * direction, target, UP)
    return camera @ pose(rotation_from_rotvec(np.array([0.0, 0.0, roll])), np.zeros(3))

"""Where a camera may stand: the limits of a rig, and the one function that applies them."""

import numpy as np

from viewgain.arrays import Array, Mask, Points, Pose, Poses
from viewgain.errors import ConfigError
from viewgain.geometry import inverse, transform
from viewgain.rigs._rig import KeepOut, Rig
from viewgain.rigs._target import Target

HERE = np.eye(4)
"""The frame of cameras and target is the world itself."""


def refusals(rig: Rig, cameras: Poses, target: Target, *, floor_to_world: Pose | None = HERE) -> tuple[str | None, ...]:
    """Return why each camera cannot stand where it is, None where it can.

    The reasons, the first that holds: ``too near``, ``too far`` (from the target's surface), ``too low``, ``too high`` (above the
    floor), ``kept out`` (inside a cone, its mantle included).

    Args:
        rig: The limits.
        cameras: (v, 4, 4) poses in a frame whose z axis is up and whose floor is z = 0: a simulated world, or the floor's frame.
        target: What must not be touched, same frame.
        floor_to_world: (4, 4) pose of that frame in the world of the keep-out cones; None where it is not known.

    Raises:
        ConfigError: If a cone needs the world and it is not known: all but vertical ones at the target's centre do.
    """
    positions = cameras[:, :3, 3]
    distance, height = _distance(positions, target), positions[:, 2]
    inside = np.zeros(len(positions), dtype=bool)
    for cone in rig.keep_out:
        inside |= _inside(cone, positions, target, floor_to_world, rig.name)
    checks = (
        ("too near", distance < rig.min_distance),
        ("too far", distance > rig.max_distance),
        ("too low", height < rig.min_height),
        ("too high", height > rig.max_height),
        ("kept out", inside),
    )
    return tuple(next((reason for reason, holds in checks if holds[k]), None) for k in range(len(positions)))


def _distance(positions: Points, target: Target) -> Array:
    """Return the (v,) distances to the target's bounding box, metres; 0 inside."""
    local = transform(inverse(target.target_to_world), positions)
    low, high = np.array([[-0.5, -0.5, 0.0], [0.5, 0.5, 1.0]]) * target.extents
    return np.asarray(np.linalg.norm(local - np.clip(local, low, high), axis=1))


def _inside(cone: KeepOut, positions: Points, target: Target, floor_to_world: Pose | None, name: str) -> Mask:
    if floor_to_world is None:
        if cone.apex is not None or np.any(cone.axis[:2]):
            raise ConfigError(f"rig {name}: a keep-out cone is given in the world, and the scan has no camera_to_world")
        floor_to_world = HERE
    apex = target.centre if cone.apex is None else transform(inverse(floor_to_world), cone.apex)
    axis = floor_to_world[:3, :3].T @ cone.axis
    away = positions - apex
    angle = np.arctan2(np.linalg.norm(np.cross(axis, away), axis=1), away @ axis)
    return np.asarray(angle <= cone.half_angle)

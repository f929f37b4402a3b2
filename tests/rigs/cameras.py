"""Cameras around a target, and what can be read off them."""

import numpy as np
from numpy.typing import NDArray

from viewgain.geometry import look_at, pose, rotation_from_rotvec

Array = NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])
EYE = np.eye(4)


def direction(azimuth: float, elevation: float) -> Array:
    """The unit vector towards an azimuth and elevation, radians."""
    return np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])


def orbit(target: Array, azimuth: float, elevation: float, distance: float) -> Array:
    """camera_to_world of an upright camera that looks at a point; radians, metres."""
    return look_at(target + distance * direction(azimuth, elevation), target, UP)


def turn(angle: float, shift: Array | None = None) -> Array:
    """The motion of the world about its vertical, then a shift."""
    return pose(rotation_from_rotvec(angle * UP), np.zeros(3) if shift is None else shift)


def seen_from(target: Array, camera: Array) -> tuple[float, float, float]:
    """Azimuth, elevation (degrees) and distance (metres) of a camera as seen from a point."""
    offset = camera[:3, 3] - target
    distance = float(np.linalg.norm(offset))
    return float(np.rad2deg(np.arctan2(offset[1], offset[0]))), float(np.rad2deg(np.arcsin(offset[2] / distance))), distance

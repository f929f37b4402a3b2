"""Where directions lie on a map of the upper hemisphere, and which position every pixel of it belongs to."""

import numpy as np

from viewgain.arrays import Array, Mask, Points2, Vector
from viewgain.evaluation import GainMap

RIM = 90.0
"""Radius of the horizon in the unit of the maps: degrees from overhead."""
RASTER = 361
"""Pixels across a map."""
FARTHEST = 35.0
"""Nothing is painted more than this far from the nearest position, degrees; nearer where positions are dense."""
FOOT = 13.0
"""Half of the footprint's diagonal, degrees: it is a sign of how the box is turned, not to scale."""


def on_map(azimuth: Vector, elevation: Vector) -> Points2:
    """Return the (V, 2) places on a map, degrees from overhead, of directions in radians: azimuth 0 right, anticlockwise."""
    away = RIM - np.rad2deg(elevation)
    return np.stack([away * np.cos(azimuth), away * np.sin(azimuth)], axis=-1)


def footprint(drawn: GainMap) -> Points2:
    """Return the (4, 2) corners of the box's footprint on a map, turned as it stands, not to scale."""
    sides = drawn.case.box.extents[:2]
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * sides / float(np.hypot(*sides)) * FOOT
    turn = np.array([[np.cos(drawn.yaw), -np.sin(drawn.yaw)], [np.sin(drawn.yaw), np.cos(drawn.yaw)]])
    return np.asarray(corners @ turn.T)


def raster(drawn: GainMap) -> tuple[Points2, Array, Mask]:
    """Return (V, 2) places, (r, r) the nearest position to every pixel, and (r, r) the pixels that are painted."""
    steps = np.linspace(-RIM, RIM, RASTER)
    x, y = np.meshgrid(steps, steps)
    radius = np.hypot(x, y)
    towards = _directions(np.arctan2(y, x), np.deg2rad(RIM - radius))
    stands = _directions(drawn.azimuth, drawn.elevation)
    apart = towards.reshape(-1, 3) @ stands.T
    nearest = np.argmax(apart, axis=1).reshape(x.shape)
    angle = np.rad2deg(np.arccos(np.clip(apart.max(axis=1), -1, 1))).reshape(x.shape)
    among = stands @ stands.T - 3 * np.eye(len(stands))
    spacing = float(np.rad2deg(np.arccos(np.clip(among.max(axis=1), -1, 1))).max())
    return on_map(drawn.azimuth, drawn.elevation), nearest, (radius <= RIM) & (angle <= min(FARTHEST, spacing))


def _directions(azimuth: Array, elevation: Array) -> Array:
    """Return (..., 3) unit vectors."""
    level = np.cos(elevation)
    return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1)

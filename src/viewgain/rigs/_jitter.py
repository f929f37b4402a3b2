"""Jitter: how far a camera may stand from where its station says. Every number is uniform and independent of the others."""

from dataclasses import astuple, dataclass
from typing import TypeAlias

import numpy as np

from viewgain.arrays import Array
from viewgain.errors import ConfigError

Interval: TypeAlias = tuple[float, float]
"""Bounds (low, high) of a uniform distribution."""
Intervals: TypeAlias = tuple[Interval, Interval, Interval]
"""One for each of x, y and z."""
NEVER: Interval = (0.0, 0.0)
"""No jitter."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Jitter:
    """Bounds of the uniform errors of one camera; all zero unless said.

    The first five move the camera and what it aims at, before it is aimed; the rotation is added afterwards. A station with a
    pose of its own has position and rotation only.
    """

    azimuth: Interval = NEVER
    """Added to the azimuth, radians."""
    elevation: Interval = NEVER
    """Added to the elevation, radians."""
    distance: Interval = NEVER
    """Added to the distance, as a share of it."""
    position: Intervals = (NEVER, NEVER, NEVER)
    """Added to the camera's position along the target's x, y and z, metres."""
    aim: Intervals = (NEVER, NEVER, NEVER)
    """Added to the point that the camera looks at along the target's x, y and z, metres."""
    rotation: Intervals = (NEVER, NEVER, NEVER)
    """Added to the camera's Blender Euler angles x (tilts up), y (rolls a level camera) and z (pans to the left), radians.

    Those are the a, b, c of Rz(c) Ry(b) Rx(a), world axes with z up, for camera axes x right, y up, z backward.
    """

    def __post_init__(self) -> None:
        bounds = self.bounds
        if not np.all(np.isfinite(bounds)) or np.any(bounds[:, 0] > bounds[:, 1]) or self.distance[0] <= -1:
            raise ConfigError("jitter: wanted finite bounds, low <= high, and a distance that stays positive")

    @property
    def bounds(self) -> Array:
        """(12, 2) all bounds, in the order of the fields."""
        azimuth, elevation, distance, position, aim, rotation = astuple(self)
        return np.array([azimuth, elevation, distance, *position, *aim, *rotation], dtype=float)

    def draw(self, count: int, rng: np.random.Generator | None) -> Array:
        """Return (count, 12) errors in the order of :attr:`bounds`; zeros without ``rng``.

        Twelve numbers are drawn per camera whatever the bounds are, so that widening one leaves the others as they were.
        """
        if rng is None:
            return np.zeros((count, 12))
        low, high = self.bounds.T
        return np.asarray(low + (high - low) * rng.random((count, 12)))


NO_JITTER = Jitter()
"""Every camera stands exactly where its station says."""

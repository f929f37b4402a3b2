"""Lines in space or in the plane, as (m, d) points: smooth ones through given points, and polylines with rounded corners."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from viewgain.arrays import Array, Points2

Line = Array | Sequence[Sequence[float]]


def smooth(points: Line, count: int) -> Array:
    """Return ``count`` points along the Catmull-Rom curve through (m, d) points, from the first to the last."""
    knots = np.asarray(points, dtype=float)
    return np.asarray(_catmull_rom(len(knots), count) @ knots)


def rounded(points: Line, radius: float, steps: int = 4) -> Array:
    """Return a polyline with each inner corner replaced by a parabola that leaves it ``radius`` before and after.

    At most 0.45 of the shorter neighbouring segment is taken, so no two points ever coincide.
    """
    knots = np.asarray(points, dtype=float)
    if len(knots) < 3:
        return knots
    segment = np.diff(knots, axis=0)
    length = np.linalg.norm(segment, axis=1)
    cut = np.minimum(radius, 0.45 * np.minimum(length[:-1], length[1:]))
    before = knots[1:-1] - segment[:-1] * (cut / length[:-1])[:, None]
    after = knots[1:-1] + segment[1:] * (cut / length[1:])[:, None]
    weights = _parabola(steps)
    bends = weights[:, 0] * before[:, None] + weights[:, 1] * knots[1:-1, None] + weights[:, 2] * after[:, None]
    return np.concatenate([knots[:1], bends.reshape(-1, knots.shape[1]), knots[-1:]])


def rounded_loop(points: Line, radius: float, steps: int = 3) -> Array:
    """Return a closed polygon with all corners rounded as :func:`rounded` does."""
    knots = np.asarray(points, dtype=float)
    return rounded(np.concatenate([knots[-1:], knots, knots[:1]]), radius, steps)[1:-1]


def arc(radius: float, start: float, end: float, count: int) -> Points2:
    """Return ``count`` points of a circle about the origin, between two angles in radians."""
    angle = np.linspace(start, end, count)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


@lru_cache(maxsize=128)
def _catmull_rom(knots: int, count: int) -> Array:
    """Return the (count, knots) weights of each knot in each point of the curve; the end knots count twice."""
    place = np.linspace(0, knots - 1, count)
    left = np.minimum(place.astype(int), knots - 2)
    t = place - left
    basis = np.stack([-t + 2 * t**2 - t**3, 2 - 5 * t**2 + 3 * t**3, t + 4 * t**2 - 3 * t**3, t**3 - t**2]) / 2
    weights = np.zeros((count, knots))
    for k in range(4):
        np.add.at(weights, (np.arange(count), np.clip(left + k - 1, 0, knots - 1)), basis[k])
    return weights


@lru_cache(maxsize=16)
def _parabola(steps: int) -> Array:
    """Return (steps + 1, 3, 1) weights of a quadratic Bezier curve."""
    t = np.linspace(0, 1, steps + 1)
    return np.stack([(1 - t) ** 2, 2 * t * (1 - t), t**2], axis=1)[:, :, None]

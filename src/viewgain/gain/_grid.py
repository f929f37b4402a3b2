"""Points sorted into cubes no smaller than the reach, so that all neighbours of a point lie in the 27 cubes around it.

What "near" means in this room is said here, once: two points are near if dx dx + dy dy + dz dz < reach reach, summed in this
order in float64. The published scripts compare squares with the same strict sign, in float32.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Ids, Mask, Points, Vector
from viewgain.compiled import compiled
from viewgain.gain._kernels import find_corners, mark_around, sort_into_cubes
from viewgain.gain._search import SEARCHING

MOST_CELLS = 1 << 22
"""Of a grid; beyond it the cubes grow."""
SLACK = 1e-6
"""Share by which a cube is larger than the reach, so that rounding puts no neighbour two cubes away."""


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Points in cubes. Cubes that follow each other in x are neighbours in memory, so three of them are one look-up."""

    low: Vector
    """(3,) lowest corner."""
    side: float
    """Of a cube, more than the reach."""
    shape: Ids
    """(3,) cubes along x, y and z."""
    starts: Ids
    """(cubes + 1,) where each cube's points start, x fastest."""
    points: Points
    """(m, 3) in order of their cubes, and within one in the order they came."""
    ids: Ids
    """(m,) which point each was."""


def gridded(points: Points, reach: float) -> Grid:
    """Return (m, 3) finite points, m >= 1, sorted for searches within ``reach``.

    Raises:
        MissingExtraError: If numba is not installed.
    """
    low, high = compiled(find_corners, SEARCHING)(points)
    extents = high - low
    side = reach * (1 + SLACK)
    while np.prod(np.floor(extents / side) + 1) > MOST_CELLS:
        side *= 2
    shape = (np.floor(extents / side) + 1).astype(np.int32)
    starts, order = compiled(sort_into_cubes, SEARCHING)(points, low, side, shape)
    return Grid(low, side, shape, starts, points.take(order, axis=0), order)


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """Small cubes around points, so small that two points in one are near, and what a cube says of any point in it."""

    low: Vector
    """(3,) lowest corner, two cubes below the lowest point."""
    side: float
    """Of a cube."""
    status: NDArray[np.uint8]
    """(z, y, x) cubes: 2 if every point in it is near, 1 if one may be, 0 if none is."""


def surroundings(points: Points, reach: float) -> Surroundings:
    """Return what small cubes say of the nearness to (m, 3) finite points, m >= 1; raises as :func:`gridded`.

    A cube is a little under reach / sqrt(3) wide, so its diagonal is under the reach, and two cubes between two points are more
    than it. Where there would be too many cubes they grow, and none says 2.
    """
    side = reach * (1 - SLACK) / np.sqrt(3)
    lowest, highest = compiled(find_corners, SEARCHING)(points)
    extents = highest - lowest
    while np.prod(np.floor(extents / side) + 6) > MOST_CELLS:
        side *= 2
    low = lowest - 2 * side
    status = np.zeros((np.floor(extents / side)[::-1] + 6).astype(int), dtype=np.uint8)
    compiled(mark_around, SEARCHING)(points, low, side, 2 if side < reach / np.sqrt(3) else 1, status)
    return Surroundings(low, side, status)


def are_near(a: Points, b: Points, reach: float) -> Mask:
    """Return the (n,) mask of the pairs of (n, 3) points that are near each other: the definition."""
    dx, dy, dz = (a - b).T
    return np.asarray(dx * dx + dy * dy + dz * dz < reach * reach)

"""Points sorted into cubes no smaller than the reach, so that all neighbours of a point lie in the 27 cubes around it.

What "near" means in this room is said here, once: two points are near if dx dx + dy dy + dz dz < reach reach, summed in this
order in float64. The published scripts compare squares with the same strict sign, in float32.
"""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Ids, Mask, Points, Vector

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
    """Return (m, 3) finite points, m >= 1, sorted for searches within ``reach``."""
    low = points.min(axis=0)
    extents = points.max(axis=0) - low
    side = reach * (1 + SLACK)
    while np.prod(np.floor(extents / side) + 1) > MOST_CELLS:
        side *= 2
    shape = (np.floor(extents / side) + 1).astype(np.int32)
    x, y, z = np.minimum(((points - low) / side).astype(np.int32), shape - 1).T
    cells = (z * shape[1] + y) * shape[0] + x
    order = np.argsort(cells, kind="stable").astype(np.int32)
    starts = np.concatenate([[0], np.cumsum(np.bincount(cells, minlength=int(np.prod(shape))))]).astype(np.int32)
    return Grid(low, side, shape, starts, np.ascontiguousarray(points[order]), order)


def are_near(a: Points, b: Points, reach: float) -> Mask:
    """Return the (n,) mask of the pairs of (n, 3) points that are near each other: the definition."""
    dx, dy, dz = (a - b).T
    return np.asarray(dx * dx + dy * dy + dz * dz < reach * reach)

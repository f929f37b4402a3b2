"""Volumes of what stands on the floor z = 0: of the convex hull, and of the heap between floor and topmost surface."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import ConvexHull, QhullError

from viewgain.arrays import Array, Points

MAX_CELLS = 400
"""A heap's grid has at most this many cells along each side; a larger one is made coarser."""


def hull_volume(points: Points) -> float:
    """Return the volume of the convex hull of (n, 3) points, cubic metres; 0 where they have none."""
    try:
        return float(ConvexHull(points).volume)
    except (QhullError, ValueError):
        return 0.0


def heap_volume(points: Points, cell: float, *, closing: int = 2) -> float:
    """Return the volume between the floor and the topmost of (n, 3) points, cubic metres.

    The sum over the cells of a floor grid of the highest point above each, times the cell's area. What lies under an overhang
    counts: nothing seen from above tells it from matter. Cells without a point but surrounded by such with one are filled.

    Args:
        points: Points in a frame whose floor is z = 0.
        cell: Side of a cell, metres, > 0; take one and a half times the distance between neighbouring points.
        closing: How many cells wide a gap is closed.
    """
    if len(points) == 0:
        return 0.0
    low = points[:, :2].min(axis=0)
    cell = max(cell, float(np.ptp(points[:, :2], axis=0).max()) / MAX_CELLS)
    heights = _highest(np.floor((points[:, :2] - low) / cell).astype(int) + closing + 1, points[:, 2], closing + 1)
    filled = ndimage.binary_closing(np.isfinite(heights), iterations=closing)
    nearest = ndimage.distance_transform_edt(~np.isfinite(heights), return_distances=False, return_indices=True)
    return float(cell**2 * np.maximum(heights[tuple(nearest)][filled], 0.0).sum())


def _highest(cells: NDArray[np.intp], heights: Array, margin: int) -> Array:
    """Return the (a, b) grid of the highest value in each cell; minus infinity where there is none."""
    grid = np.full(tuple(cells.max(axis=0) + margin + 1), -np.inf)
    np.maximum.at(grid, (cells[:, 0], cells[:, 1]), heights)
    return grid

"""Which points are near which, by machine code (numba, the extra ``data``) or by scipy's tree: the same answer, bit for bit."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from viewgain.arrays import Indices, Mask, Points
from viewgain.compiled import compiled
from viewgain.gain._grid import Grid, are_near, gridded, surroundings
from viewgain.gain._kernels import find_pairs, find_touched
from viewgain.gain._mark_kernels import find_marks
from viewgain.gain._pairs import Pairs
from viewgain.gain._search import SEARCHING, Search, uses_numba

DOUBT = 1e-9
"""Relative width of the shell about the reach in which a tree's distance is not trusted but worked out again."""


def near_pairs(points: Points, others: Points, reach: float, *, search: Search = "auto") -> Pairs:
    """Return which of (m, 3) ``others`` are near each of (n, 3) ``points``; all finite, either may be empty.

    Raises:
        MissingExtraError: If ``search`` is "numba" and it is not installed.
    """
    if len(points) == 0 or len(others) == 0:
        return Pairs(np.zeros(len(points) + 1, np.int64), np.zeros(0, np.int32))
    if uses_numba(search):
        return Pairs(*compiled(find_pairs, SEARCHING)(points, *_parts(gridded(others, reach)), reach * reach))
    return _pairs_by_tree(points, others, reach)


def near_any(points: Points, chosen: Indices, others: Points, reach: float, *, search: Search = "auto") -> Mask:
    """Return the (k,) mask of the ``chosen`` among (n, 3) ``points`` that are near any of (m, 3) ``others``; raises as above."""
    if len(chosen) == 0 or len(others) == 0:
        return np.zeros(len(chosen), dtype=bool)
    if uses_numba(search):
        grid = gridded(others, reach)
        around = surroundings(grid.points, reach)
        known = around.low, around.side, around.status
        return np.asarray(compiled(find_touched, SEARCHING)(points, chosen, *_parts(grid), reach * reach, *known))
    return _any_by_tree(points[chosen], others, reach)


def near_marks(points: Points, marks: NDArray[np.uint64], reach: float, *, search: Search = "auto") -> NDArray[np.uint64]:
    """Return the (n,) union of the ``marks`` of all that are near each of (n, 3) ``points``; raises as above.

    Args:
        points: All points, finite; n may be 0. A point is near itself.
        marks: (n,) each point's mark: one bit, the same for all points of one view.
        reach: How near is near.
        search: How near points are found.
    """
    if uses_numba(search) and len(points):
        grid = gridded(points, reach / np.sqrt(3))  # mostly, two points in one cube are near
        parts = grid.shape, grid.starts, grid.points, grid.ids, marks[grid.ids], reach * reach
        return np.asarray(compiled(find_marks, SEARCHING)(*parts))
    near, everyone = np.zeros(len(points), np.uint64), np.arange(len(points))
    for mark in np.unique(marks):
        near[near_any(points, everyone, points[marks == mark], reach, search=search)] |= mark
    return near


def _pairs_by_tree(points: Points, others: Points, reach: float) -> Pairs:
    found = KDTree(points).sparse_distance_matrix(KDTree(others), reach * (1 + DOUBT), output_type="ndarray")
    found = found[are_near(points[found["i"]], others[found["j"]], reach)]
    starts = np.concatenate([[0], np.cumsum(np.bincount(found["i"], minlength=len(points)))])
    return Pairs(starts.astype(np.int64), found["j"][np.argsort(found["i"], kind="stable")].astype(np.int32))


def _any_by_tree(points: Points, others: Points, reach: float) -> Mask:
    tree = KDTree(others)
    distance, _ = tree.query(points, distance_upper_bound=reach * (1 + DOUBT))
    near = np.asarray(distance < reach * (1 - DOUBT))
    for k in np.flatnonzero(~near & np.isfinite(distance)):
        close = others[tree.query_ball_point(points[k], reach * (1 + DOUBT))]
        near[k] = np.any(are_near(np.broadcast_to(points[k], close.shape), close, reach))
    return near


def _parts(grid: Grid) -> tuple[Any, ...]:
    return grid.low, grid.side, grid.shape, grid.starts, grid.points, grid.ids

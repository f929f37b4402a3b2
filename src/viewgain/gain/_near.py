"""Which points are near which, by machine code (numba, the extra ``data``) or by scipy's tree: the same answer, bit for bit."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from viewgain.arrays import Ids, Indices, Mask, Points
from viewgain.errors import MissingExtraError
from viewgain.gain._grid import Grid, are_near, gridded
from viewgain.gain._kernels import find_pairs, find_touched

Search: TypeAlias = Literal["auto", "numba", "scipy"]
"""How near points are found; "auto" takes numba where it is installed."""
Starts: TypeAlias = NDArray[np.int64]
DOUBT = 1e-9
"""Relative width of the shell about the reach in which a tree's distance is not trusted but worked out again."""


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """For every point of one set, the points of another that are near it."""

    starts: Starts
    """(n + 1,) where each point's neighbours start in :attr:`ids`."""
    ids: Ids
    """(pairs,) the neighbours, a point's own in no particular order."""

    def of(self, points: Indices) -> Ids:
        """Return the neighbours of some points, one after the other."""
        first, count = self.starts[points], self.starts[points + 1] - self.starts[points]
        shift = np.repeat(first - np.concatenate([[0], np.cumsum(count)[:-1]]), count) if len(points) else np.zeros(0, np.int64)
        return np.asarray(self.ids[np.arange(len(shift)) + shift])


def near_pairs(points: Points, others: Points, reach: float, *, search: Search = "auto") -> Pairs:
    """Return which of (m, 3) ``others`` are near each of (n, 3) ``points``; all finite, either may be empty.

    Takes memory for every pair: about 20 million of them at the most are meant.

    Raises:
        MissingExtraError: If ``search`` is "numba" and it is not installed.
    """
    if len(points) == 0 or len(others) == 0:
        return Pairs(np.zeros(len(points) + 1, np.int64), np.zeros(0, np.int32))
    if _uses_numba(search):
        return Pairs(*_compiled(find_pairs)(points, *_parts(gridded(others, reach)), reach * reach))
    return _pairs_by_tree(points, others, reach)


def near_any(points: Points, chosen: Indices, others: Points, reach: float, *, search: Search = "auto") -> Mask:
    """Return the (k,) mask of the ``chosen`` among (n, 3) ``points`` that are near any of (m, 3) ``others``; raises as above."""
    if len(chosen) == 0 or len(others) == 0:
        return np.zeros(len(chosen), dtype=bool)
    if _uses_numba(search):
        return np.asarray(_compiled(find_touched)(points, chosen, *_parts(gridded(others, reach)), reach * reach))
    return _any_by_tree(points[chosen], others, reach)


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


def _uses_numba(search: Search) -> bool:
    return search == "numba" or (search == "auto" and find_spec("numba") is not None)


@cache
def _compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel as machine code; it is kept on disk where there is a place for it."""
    try:
        from numba import njit
    except ImportError as error:
        raise MissingExtraError('this search needs numba: pip install "viewgain[data]", or search with scipy') from error
    options: dict[str, Any] = {"nogil": True, "fastmath": False, "error_model": "numpy"}
    try:
        return njit(cache=True, **options)(function)  # type: ignore[no-any-return]  # numba is untyped
    except RuntimeError:  # neither the package's folder nor the user's cache can be written
        return njit(**options)(function)  # type: ignore[no-any-return]  # numba is untyped

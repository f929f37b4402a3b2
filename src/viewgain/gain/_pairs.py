"""Pairs of near points as lists of neighbours, and what they add up to per view and neighbour."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Ids, Indices
from viewgain.compiled import compiled
from viewgain.gain._kernels import add_pairs
from viewgain.gain._mark_kernels import join_pairs
from viewgain.gain._search import SEARCHING, Search, uses_numba

Starts: TypeAlias = NDArray[np.int64]
"""(n + 1,) where each list starts in the array of all, and where the last one ends."""
Tally: TypeAlias = NDArray[np.int32]
"""(V, m) number of near pairs between the points of each view and each sample."""


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """For every point of one set, the points of another that are near it."""

    starts: Starts
    """(n + 1,) where each point's neighbours start in :attr:`ids`."""
    ids: Ids
    """(pairs,) the neighbours, a point's own in no particular order."""

    def of(self, points: Indices) -> Ids:
        """Return the neighbours of some points, one list after the other."""
        begin, count = self.starts[points], np.diff(self.starts)[points]
        before = np.cumsum(count) - count
        return np.asarray(self.ids[np.repeat(begin - before, count) + np.arange(count.sum())])


def tally(counts: Tally, pairs: Pairs, points: Indices, views: Ids, sign: int, *, search: Search = "auto") -> None:
    """Add the pairs of some points to (V, m) ``counts``, in place, or take them away (``sign`` -1).

    Args:
        counts: Changed: by view and neighbour.
        pairs: The neighbours of all points.
        points: Which points.
        views: (n,) the view of each of all points.
        sign: 1 or -1.
        search: With "scipy", no machine code.
    """
    if uses_numba(search):
        compiled(add_pairs, SEARCHING)(counts, pairs.starts, pairs.ids, points, views, np.int32(sign))
        return
    rows = np.repeat(views[points].astype(np.int64), np.diff(pairs.starts)[points])
    slots = rows * counts.shape[1] + pairs.of(points)
    counts += sign * np.bincount(slots, minlength=counts.size).astype(np.int32).reshape(counts.shape)


def join(
    pairs: Pairs, sets: NDArray[np.uint64], views: Ids, shape: tuple[int, int], *, search: Search = "auto"
) -> NDArray[np.uint64]:
    """Return for each view and neighbour the union of the sets of the view's points that are near it.

    Args:
        pairs: The neighbours of all n points.
        sets: (n,) a set of bits of each point.
        views: (n,) the view of each point.
        shape: V and m, of the result.
        search: With "scipy", no machine code.
    """
    joined = np.zeros(shape, dtype=np.uint64)
    if uses_numba(search):
        compiled(join_pairs, SEARCHING)(joined, pairs.starts, pairs.ids, views, sets)
    else:
        lengths = np.diff(pairs.starts)
        np.bitwise_or.at(joined, (np.repeat(views, lengths), pairs.ids), np.repeat(sets, lengths))
    return joined

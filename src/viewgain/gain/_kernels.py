"""The two searches in a grid, written for numba: numbers and loops only. Both look into nine rows of three cubes around a point."""

import numpy as np

from viewgain.arrays import Ids, Indices, Mask, Points, Vector
from viewgain.gain._bits import Counts


def find_pairs(
    queries: Points, low: Vector, side: float, shape: Ids, starts: Ids, points: Points, ids: Ids, squared: float
) -> tuple[Counts, Ids]:
    """Return all near points of each query, see :class:`viewgain.gain._near.Pairs`; a grid's parts, and the reach squared."""
    first, found, total = np.zeros(len(queries) + 1, np.int64), np.empty(4 * len(queries) + 16, np.int32), 0
    for i in range(len(queries)):
        x, y, z = queries[i, 0], queries[i, 1], queries[i, 2]
        u, v, w = np.floor((x - low[0]) / side), np.floor((y - low[1]) / side), np.floor((z - low[2]) / side)
        if -1 <= u <= shape[0] and -1 <= v <= shape[1] and -1 <= w <= shape[2]:
            left, right = max(int(u) - 1, 0), min(int(u) + 2, shape[0])
            for level in range(max(int(w) - 1, 0), min(int(w) + 2, shape[2])):
                for row in range(max(int(v) - 1, 0), min(int(v) + 2, shape[1])):
                    cell = (level * shape[1] + row) * shape[0]
                    for k in range(starts[cell + left], starts[cell + right]):
                        dx, dy, dz = x - points[k, 0], y - points[k, 1], z - points[k, 2]
                        if dx * dx + dy * dy + dz * dz < squared:
                            if total == len(found):
                                longer = np.empty(2 * len(found), np.int32)
                                longer[:total] = found
                                found = longer
                            found[total] = ids[k]
                            total += 1
        first[i + 1] = total
    return first, found[:total].copy()


def find_touched(
    queries: Points,
    chosen: Indices,
    low: Vector,
    side: float,
    shape: Ids,
    starts: Ids,
    points: Points,
    ids: Ids,
    squared: float,
) -> Mask:
    """Return which of the ``chosen`` queries have a near point; otherwise as :func:`find_pairs`."""
    touched = np.zeros(len(chosen), np.bool_)
    for i in range(len(chosen)):
        x, y, z = queries[chosen[i], 0], queries[chosen[i], 1], queries[chosen[i], 2]
        u, v, w = np.floor((x - low[0]) / side), np.floor((y - low[1]) / side), np.floor((z - low[2]) / side)
        if -1 <= u <= shape[0] and -1 <= v <= shape[1] and -1 <= w <= shape[2]:
            left, right = max(int(u) - 1, 0), min(int(u) + 2, shape[0])
            for level in range(max(int(w) - 1, 0), min(int(w) + 2, shape[2])):
                for row in range(max(int(v) - 1, 0), min(int(v) + 2, shape[1])):
                    cell = (level * shape[1] + row) * shape[0]
                    for k in range(starts[cell + left], starts[cell + right]):
                        dx, dy, dz = x - points[k, 0], y - points[k, 1], z - points[k, 2]
                        if dx * dx + dy * dy + dz * dz < squared:
                            touched[i] = True
                            break
                    if touched[i]:
                        break
                if touched[i]:
                    break
    return touched

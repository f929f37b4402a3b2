"""What is slow in Python, written for numba: numbers and loops only. The two searches look into nine rows of three cubes."""

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Ids, Indices, Mask, Points, Vector


def find_corners(points: Points) -> tuple[Vector, Vector]:
    """Return the lowest and the highest corner of the box around (m, 3) points, m >= 1."""
    low, high = points[0].copy(), points[0].copy()
    for i in range(1, len(points)):
        for axis in range(3):
            low[axis], high[axis] = min(low[axis], points[i, axis]), max(high[axis], points[i, axis])
    return low, high


def sort_into_cubes(points: Points, low: Vector, side: float, shape: Ids) -> tuple[Ids, Ids]:
    """Return where each cube's points start, and the (m,) points in order of their cubes: :class:`viewgain.gain._grid.Grid`."""
    starts = np.zeros(shape[0] * shape[1] * shape[2] + 1, np.int32)
    cubes, order = np.empty(len(points), np.int32), np.empty(len(points), np.int32)
    for i in range(len(points)):
        x = min(int((points[i, 0] - low[0]) / side), shape[0] - 1)
        y = min(int((points[i, 1] - low[1]) / side), shape[1] - 1)
        z = min(int((points[i, 2] - low[2]) / side), shape[2] - 1)
        cubes[i] = (z * shape[1] + y) * shape[0] + x
        starts[cubes[i] + 1] += 1
    for cube in range(1, len(starts)):
        starts[cube] += starts[cube - 1]
    ends = starts.copy()
    for i in range(len(points)):
        order[ends[cubes[i]]] = i
        ends[cubes[i]] += 1
    return starts, order


def find_pairs(
    queries: Points, low: Vector, side: float, shape: Ids, starts: Ids, points: Points, ids: Ids, squared: float
) -> tuple[NDArray[np.int64], Ids]:
    """Return all near points of each query, see :class:`viewgain.gain._pairs.Pairs`; a grid's parts, and the reach squared.

    Neighbours in an image mostly share their cube, so what lies around it is gathered once for all that follow each other.
    """
    first, found, total = np.zeros(len(queries) + 1, np.int64), np.empty(3 * len(queries) + 16, np.int32), 0
    around, names, count = np.empty((len(points), 3)), np.empty(len(points), np.int32), 0
    column, row, level = np.nan, np.nan, np.nan
    for i in range(len(queries)):
        x, y, z = queries[i, 0], queries[i, 1], queries[i, 2]
        u, v, w = np.floor((x - low[0]) / side), np.floor((y - low[1]) / side), np.floor((z - low[2]) / side)
        if u != column or v != row or w != level:
            column, row, level, count = u, v, w, 0
            if -1 <= u <= shape[0] and -1 <= v <= shape[1] and -1 <= w <= shape[2]:
                left, right = max(int(u) - 1, 0), min(int(u) + 2, shape[0])
                for c in range(max(int(w) - 1, 0), min(int(w) + 2, shape[2])):
                    for b in range(max(int(v) - 1, 0), min(int(v) + 2, shape[1])):
                        cube = (c * shape[1] + b) * shape[0]
                        for k in range(starts[cube + left], starts[cube + right]):
                            around[count, 0], around[count, 1], around[count, 2] = points[k, 0], points[k, 1], points[k, 2]
                            names[count] = ids[k]
                            count += 1
        if total + count > len(found):
            longer = np.empty(2 * len(found) + count, np.int32)
            longer[:total] = found[:total]
            found = longer
        for k in range(count):
            dx, dy, dz = x - around[k, 0], y - around[k, 1], z - around[k, 2]
            found[total] = names[k]  # kept only if the count goes on: a branch that no processor can guess costs more
            total += dx * dx + dy * dy + dz * dz < squared
        first[i + 1] = total
    return first, found[:total].copy()


def mark_around(points: Points, low: Vector, side: float, inside: int, status: NDArray[np.uint8]) -> None:
    """Mark in ``status``, in place, what is known about small cubes: see :class:`viewgain.gain._grid.Surroundings`."""
    for i in range(len(points)):
        x, y, z = int((points[i, 0] - low[0]) / side), int((points[i, 1] - low[1]) / side), int((points[i, 2] - low[2]) / side)
        if status[z, y, x] != 2:
            for c in range(z - 2, z + 3):
                for b in range(y - 2, y + 3):
                    for a in range(x - 2, x + 3):
                        status[c, b, a] = max(status[c, b, a], 1)
            status[z, y, x] = inside


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
    corner: Vector,
    small: float,
    status: NDArray[np.uint8],
) -> Mask:
    """Return which of the ``chosen`` queries have a near point: a grid's parts, the reach squared, its surroundings' parts.

    Most are settled by the small cube they lie in. Of the others, what was near one is tried first on the next, its neighbour in
    an image; then the grid is searched, the middle row of cubes first.
    """
    touched, last = np.zeros(len(chosen), np.bool_), 0
    for i in range(len(chosen)):
        x, y, z = queries[chosen[i], 0], queries[chosen[i], 1], queries[chosen[i], 2]
        u, v, w = np.floor((x - corner[0]) / small), np.floor((y - corner[1]) / small), np.floor((z - corner[2]) / small)
        if not (0 <= u < status.shape[2] and 0 <= v < status.shape[1] and 0 <= w < status.shape[0]):
            continue
        known = status[int(w), int(v), int(u)]
        if known != 1:
            touched[i] = known == 2
            continue
        dx, dy, dz = x - points[last, 0], y - points[last, 1], z - points[last, 2]
        touched[i] = dx * dx + dy * dy + dz * dz < squared
        u, v, w = np.floor((x - low[0]) / side), np.floor((y - low[1]) / side), np.floor((z - low[2]) / side)
        if touched[i] or not (-1 <= u <= shape[0] and -1 <= v <= shape[1] and -1 <= w <= shape[2]):
            continue
        left, right = max(int(u) - 1, 0), min(int(u) + 2, shape[0])
        for n in range(9):
            b, c = int(v) + (n + 1) % 3 - 1, int(w) + (n // 3 + 1) % 3 - 1
            if touched[i] or not (0 <= b < shape[1] and 0 <= c < shape[2]):
                continue
            cube = (c * shape[1] + b) * shape[0]
            for k in range(starts[cube + left], starts[cube + right]):
                dx, dy, dz = x - points[k, 0], y - points[k, 1], z - points[k, 2]
                if dx * dx + dy * dy + dz * dz < squared:
                    touched[i], last = True, k
                    break
    return touched


def add_pairs(counts: NDArray[np.int32], starts: NDArray[np.int64], ids: Ids, chosen: Indices, views: Ids, sign: int) -> None:
    """Add ``sign`` to (V, m) ``counts`` for every neighbour of the ``chosen`` points, in place."""
    for i in range(len(chosen)):
        view = views[chosen[i]]
        for k in range(starts[chosen[i]], starts[chosen[i] + 1]):
            counts[view, ids[k]] += sign

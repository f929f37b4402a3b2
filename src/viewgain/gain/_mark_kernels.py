"""Two more loops for numba, over all views at once: which marks are near each point, and which of them reach each sample."""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Ids, Points

ROWS = np.array(sorted(product(range(-2, 3), repeat=2), key=lambda row: row[0] ** 2 + row[1] ** 2), dtype=np.int32)
"""(25, 2) steps in y and z to the rows of cubes around a cube, the nearest first."""


def find_marks(
    shape: Ids, starts: Ids, points: Points, ids: Ids, marks: NDArray[np.uint64], squared: float
) -> NDArray[np.uint64]:
    """Return the (n,) marks that are near each point: see :func:`viewgain.gain._near.near_marks`.

    Takes the parts of a grid whose cubes are more than half the reach wide, so that all near points lie in the 125 cubes around,
    and the (n,) marks in order of the cubes. Cube by cube: one point near the whole box around the cube's points settles its mark
    for all of them, and one that is not near the box is left out. No margin is needed: rounding keeps the order of differences,
    squares and sums, so no point of the box is farther than its farthest corner, to the last bit. The rest is tried in pairs.
    """
    near, most = np.zeros(len(points), np.uint64), 0
    present, in_row = np.zeros(len(starts) - 1, np.uint64), np.zeros(len(starts) - 1, np.uint64)
    for cube in range(len(present)):
        most = max(most, starts[cube + 1] - starts[cube])
        for k in range(starts[cube], starts[cube + 1]):
            present[cube] |= marks[k]
        if present[cube]:
            x = cube % shape[0]
            for other in range(cube - min(x, 2), cube + min(shape[0] - x, 3)):
                in_row[other] |= present[cube]
    held, doubtful = np.empty(most, np.uint64), np.empty(len(points), np.int32)
    for cube in range(len(present)):
        begin, end = starts[cube], starts[cube + 1]
        if begin == end:
            continue
        left, low, front = points[begin, 0], points[begin, 1], points[begin, 2]
        right, high, back = left, low, front
        for k in range(begin + 1, end):
            left, right = min(left, points[k, 0]), max(right, points[k, 0])
            low, high = min(low, points[k, 1]), max(high, points[k, 1])
            front, back = min(front, points[k, 2]), max(back, points[k, 2])
        dx, dy, dz = right - left, high - low, back - front
        sure = present[cube] if dx * dx + dy * dy + dz * dz < squared else present[cube] & np.uint64(0)

        x, y, z, count = cube % shape[0], cube // shape[0] % shape[1], cube // (shape[0] * shape[1]), 0
        for n in range(len(ROWS)):
            b, c = y + ROWS[n, 0], z + ROWS[n, 1]
            if not (0 <= b < shape[1] and 0 <= c < shape[2]):
                continue
            row = (c * shape[1] + b) * shape[0]
            if not in_row[row + x] & ~sure:
                continue
            for other in range(row + max(x - 2, 0), row + min(x + 3, shape[0])):
                if not present[other] & ~sure:
                    continue
                for k in range(starts[other], starts[other + 1]):
                    if not marks[k] & ~sure:
                        continue
                    u, v, w = points[k, 0], points[k, 1], points[k, 2]
                    dx, dy, dz = max(u - left, right - u), max(v - low, high - v), max(w - front, back - w)
                    if dx * dx + dy * dy + dz * dz < squared:
                        sure |= marks[k]
                        continue
                    dx, dy, dz = max(left - u, 0.0, u - right), max(low - v, 0.0, v - high), max(front - w, 0.0, w - back)
                    if dx * dx + dy * dy + dz * dz < squared:
                        doubtful[count] = k
                        count += 1

        held[: end - begin] = sure
        for n in range(count):
            k = doubtful[n]
            if marks[k] & ~sure:
                for i in range(begin, end):
                    if marks[k] & ~held[i - begin]:
                        dx, dy, dz = points[i, 0] - points[k, 0], points[i, 1] - points[k, 1], points[i, 2] - points[k, 2]
                        if dx * dx + dy * dy + dz * dz < squared:
                            held[i - begin] |= marks[k]
        for i in range(begin, end):
            near[ids[i]] = held[i - begin]
    return near


def join_pairs(joined: NDArray[np.uint64], starts: NDArray[np.int64], ids: Ids, views: Ids, sets: NDArray[np.uint64]) -> None:
    """Join each point's set of bits to those of all its neighbours, in (V, m) ``joined``, in place."""
    for i in range(len(views)):
        for k in range(starts[i], starts[i + 1]):
            joined[views[i], ids[k]] |= sets[i]

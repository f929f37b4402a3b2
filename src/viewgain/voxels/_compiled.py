"""Marching rays as machine code: the optional extra ``data`` (numba). The same numbers as the plain way, ray by ray."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Mask, Points, Vector, Vector3
from viewgain.compiled import compiled
from viewgain.voxels._lattice import Lattice

Counts: TypeAlias = NDArray[np.int64]
Walk: TypeAlias = Callable[[Vector3, float, Counts, Vector3, Points, float, Mask, Vector, NDArray[np.int32]], int]


def march_compiled(
    lattice: Lattice, origin: Vector3, directions: Points, reach: float, stops: Mask, enters: Vector
) -> NDArray[np.int32]:
    """Return the (steps, n) paths of rays; ``enters`` are the lengths at which they enter the lattice, inf for never.

    Raises:
        MissingExtraError: If numba is not installed.
    """
    paths = np.full((len(directions), sum(lattice.shape)), lattice.count, dtype=np.int32)  # ray by ray, as it is written
    shape = np.array(lattice.shape, dtype=np.int64)
    walk: Walk = compiled(_walk, "marching with numba")
    steps = walk(lattice.low, lattice.size, shape, origin, directions, float(reach), stops, enters, paths)
    return np.ascontiguousarray(paths[:, :steps].T)


def _walk(
    low: Vector3,
    size: float,
    shape: Counts,
    origin: Vector3,
    directions: Points,
    reach: float,
    stops: Mask,
    enters: Vector,
    paths: NDArray[np.int32],
) -> int:
    """Write the paths of rays into (n, steps) ``paths`` and return the number of steps of the longest.

    Written for numba: numbers and loops only. Every sum is in the order of the plain way, so both round alike.
    """
    longest = 0
    cell, up, following = np.empty(3, np.int64), np.empty(3, np.int64), np.empty(3)
    strides = np.array([shape[1] * shape[2], shape[2], 1])
    for ray in range(len(directions)):
        if not np.isfinite(enters[ray]):
            continue
        flat = 0
        for axis in range(3):
            along = directions[ray, axis]
            place = np.floor((origin[axis] + enters[ray] * along - low[axis]) / size)
            cell[axis] = int(min(max(place, 0.0), shape[axis] - 1.0))
            up[axis] = 1 if along > 0 else 0
            following[axis] = np.inf if along == 0 else (low[axis] + (cell[axis] + up[axis]) * size - origin[axis]) / along
            flat += cell[axis] * strides[axis]
        step = 0
        while True:
            paths[ray, step] = flat
            step += 1
            if stops[flat]:
                break
            axis = 0
            if not (following[0] <= following[1] and following[0] <= following[2]):
                axis = 1 if following[1] <= following[2] else 2
            forward = 2 * up[axis] - 1
            cell[axis] += forward
            if cell[axis] < 0 or cell[axis] >= shape[axis] or not following[axis] < reach:
                break
            flat += forward * strides[axis]
            following[axis] = (low[axis] + (cell[axis] + up[axis]) * size - origin[axis]) / directions[ray, axis]
        longest = max(longest, step)
    return longest

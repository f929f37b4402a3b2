"""Rays through a lattice: which voxels each passes, in order. All rays of a view at once.

A ray moves from voxel to voxel through the face it meets next. The place of that face is worked out anew from the voxel's index,
never summed up, so a long path is as exact as a short one, and the two backends agree to the last voxel.
"""

from importlib.util import find_spec
from typing import Annotated, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Mask, Points, Vector, Vector3
from viewgain.voxels._compiled import march_compiled
from viewgain.voxels._lattice import Lattice

Paths: TypeAlias = Annotated[NDArray[np.int32], "(steps, n) flat voxel indices"]
Backend: TypeAlias = Literal["auto", "numpy", "numba"]
"""Who marches; "auto" is numba where it is installed, five times as fast, and else numpy."""


def march(
    lattice: Lattice,
    origin: Vector3,
    directions: Points,
    *,
    reach: float = np.inf,
    stop: Mask | None = None,
    backend: Backend = "auto",
) -> Paths:
    """Return the voxels that rays from one point pass, one column per ray.

    Where a ray meets an edge or a corner of voxels, it crosses the faces in the order x, y, z.

    Args:
        lattice: The voxels.
        origin: (3,) where the rays start, metres, world frame; inside the lattice or not.
        directions: (n, 3) their directions, world frame, of any length.
        reach: A ray ends after this many lengths of its direction.
        stop: (count,) flags of the voxels that end a ray; the voxel itself is still on its path. None lets rays pass all.
        backend: Who marches.

    Returns:
        (steps, n) int32 flat indices, the first voxel in row 0; below a path's end :attr:`Lattice.count` fills up. No rows where
        every ray passes the lattice by.

    Raises:
        MissingExtraError: If numba was named and is not installed.

    Source:
        Amanatides and Woo (1987), A fast voxel traversal algorithm for ray tracing.
    """
    origin, directions = np.asarray(origin, dtype=float), np.ascontiguousarray(directions, dtype=float)
    stops = np.zeros(lattice.count, dtype=bool) if stop is None else np.asarray(stop, dtype=bool).ravel()
    inside = _inside(lattice, origin, directions, reach)
    if backend == "numba" or (backend == "auto" and find_spec("numba") is not None):
        return march_compiled(lattice, origin, directions, reach, stops, inside)
    return _march_plain(lattice, origin, directions, reach, stops, inside)


def _inside(lattice: Lattice, origin: Vector3, directions: Points, reach: float) -> Vector:
    """Return (n,) lengths along the rays at which they enter the lattice; inf where they pass it by."""
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (lattice.low - origin) / directions, (lattice.high - origin) / directions
    level = directions == 0
    between = (origin >= lattice.low) & (origin < lattice.high)
    enter = np.where(level, np.where(between, -np.inf, np.inf), np.minimum(one, other)).max(axis=1, initial=0.0)
    leave = np.where(level, np.where(between, np.inf, -np.inf), np.maximum(one, other)).min(axis=1, initial=reach)
    return np.where(enter < leave, enter, np.inf)


def _march_plain(lattice: Lattice, origin: Vector3, directions: Points, reach: float, stops: Mask, enters: Vector) -> Paths:
    """Return what :func:`march` does, step by step for all rays together; rays that have ended are dropped on the way."""
    paths = np.full((sum(lattice.shape), len(directions)), lattice.count, dtype=np.int32)
    rays = np.flatnonzero(np.isfinite(enters))
    d = directions[rays].T
    cells = _first_cells(lattice, origin, d, enters[rays])
    ups = [(d[axis] > 0).astype(np.int64) for axis in range(3)]
    nexts = [_crossing(lattice, origin, axis, cells[axis] + ups[axis], d[axis]) for axis in range(3)]
    d, strides = [d[0], d[1], d[2]], (lattice.shape[1] * lattice.shape[2], lattice.shape[2], 1)
    flat = cells[0] * strides[0] + cells[1] * strides[1] + cells[2]
    step = 0
    while rays.size:
        paths[step, rays] = flat
        step += 1
        along_x = (nexts[0] <= nexts[1]) & (nexts[0] <= nexts[2])
        along_y = ~along_x & (nexts[1] <= nexts[2])
        goes_on = ~stops[flat]
        for axis, moves in enumerate((along_x, along_y, ~(along_x | along_y))):
            moved = np.flatnonzero(moves)
            forward = 2 * ups[axis][moved] - 1
            cell = cells[axis][moved] + forward
            goes_on[moved] &= (cell >= 0) & (cell < lattice.shape[axis]) & (nexts[axis][moved] < reach)
            cells[axis][moved] = cell
            flat[moved] += forward * strides[axis]
            nexts[axis][moved] = _crossing(lattice, origin, axis, cell + ups[axis][moved], d[axis][moved])
        kept = np.flatnonzero(goes_on)
        rays, flat = rays[kept], flat[kept]
        cells, ups, nexts, d = ([part[kept] for part in parts] for parts in (cells, ups, nexts, d))
    return paths[:step]


def _first_cells(lattice: Lattice, origin: Vector3, directions: Points, enters: Vector) -> list[NDArray[np.int64]]:
    """Return three (n,) indices of the voxels in which rays, (3, n), enter."""
    cells = []
    for axis in range(3):
        place = np.floor((origin[axis] + enters * directions[axis] - lattice.low[axis]) / lattice.size)
        cells.append(np.clip(place, 0, lattice.shape[axis] - 1).astype(np.int64))
    return cells


def _crossing(lattice: Lattice, origin: Vector3, axis: int, face: NDArray[np.int64], along: Vector) -> Vector:
    """Return (n,) lengths at which rays meet faces of an axis, given by number; inf for a ray along the face."""
    with np.errstate(divide="ignore", invalid="ignore"):
        lengths = (lattice.low[axis] + face * lattice.size - origin[axis]) / along
    return np.where(along == 0, np.inf, lengths)

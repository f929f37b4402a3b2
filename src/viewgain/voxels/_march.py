"""Rays through a lattice: which voxels each passes, in order. All rays of a view at once.

A ray moves from voxel to voxel through the face it meets next. The place of that face is worked out anew from the voxel's index,
never summed up, so a long path is as exact as a short one, and the two backends agree to the last voxel.
"""

from importlib.util import find_spec
from typing import Annotated, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array, Indices, Mask, Points, Vector, Vector3
from viewgain.voxels._compiled import march_compiled
from viewgain.voxels._lattice import Lattice

Paths: TypeAlias = Annotated[NDArray[np.int32], "(steps, n) flat voxel indices"]
Backend: TypeAlias = Literal["auto", "numpy", "numba"]
"""Who marches; "auto" is numba where it is installed, many times as fast, and else numpy."""


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
    enters = _enters(lattice, origin, directions, reach)
    if backend == "numba" or (backend == "auto" and find_spec("numba") is not None):
        return march_compiled(lattice, origin, directions, reach, stops, enters)
    return _march_plain(lattice, origin, directions, reach, stops, enters)


def _enters(lattice: Lattice, origin: Vector3, directions: Points, reach: float) -> Vector:
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
    along = directions[rays].T
    cells, up = _first_cells(lattice, origin, along, enters[rays]), (along > 0).astype(np.int64)
    following = np.stack([_crossing(lattice, origin, axis, cells[axis] + up[axis], along[axis]) for axis in range(3)])
    strides = (lattice.shape[1] * lattice.shape[2], lattice.shape[2], 1)
    flat = cells[0] * strides[0] + cells[1] * strides[1] + cells[2]
    step = 0
    while rays.size:
        paths[step, rays] = flat
        step += 1
        goes_on = ~stops[flat]
        for axis, moved in enumerate(_next_axes(following)):
            forward = 2 * up[axis, moved] - 1
            cell = cells[axis, moved] + forward
            goes_on[moved] &= (cell >= 0) & (cell < lattice.shape[axis]) & (following[axis, moved] < reach)
            cells[axis, moved] = cell
            flat[moved] += forward * strides[axis]
            following[axis, moved] = _crossing(lattice, origin, axis, cell + up[axis, moved], along[axis, moved])
        kept = np.flatnonzero(goes_on)
        rays, flat, cells, up = rays[kept], flat[kept], cells[:, kept], up[:, kept]
        following, along = following[:, kept], along[:, kept]
    return paths[:step]


def _next_axes(following: Array) -> tuple[Indices, Indices, Indices]:
    """Return the places of the rays that cross a face of x, of y and of z next; ``following`` are the (3, n) lengths to those."""
    x, y, z = following
    along_x = (x <= y) & (x <= z)
    along_y = ~along_x & (y <= z)
    return np.flatnonzero(along_x), np.flatnonzero(along_y), np.flatnonzero(~(along_x | along_y))


def _first_cells(lattice: Lattice, origin: Vector3, directions: Array, enters: Vector) -> NDArray[np.int64]:
    """Return (3, n) indices of the voxels in which rays with (3, n) directions enter."""
    most = np.array(lattice.shape)[:, None] - 1
    place = np.floor((origin[:, None] + enters * directions - lattice.low[:, None]) / lattice.size)
    return np.clip(place, 0, most).astype(np.int64)


def _crossing(lattice: Lattice, origin: Vector3, axis: int, face: NDArray[np.int64], along: Vector) -> Vector:
    """Return (n,) lengths at which rays meet faces of an axis, given by number; inf for a ray along the face."""
    with np.errstate(divide="ignore", invalid="ignore"):
        lengths = (lattice.low[axis] + face * lattice.size - origin[axis]) / along
    return np.where(along == 0, np.inf, lengths)

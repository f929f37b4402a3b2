"""The inverse sensor model: what one scan says about each voxel, whatever was known before.

A return says that its voxel is occupied and that those before it are free. Each voxel is told at most once per scan, as in
OctoMap: the pixels of one scan are not independent witnesses. A voxel with a return in it counts as hit, however many other
rays pass through it.
"""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Ids, Mask, Points, Vector3
from viewgain.errors import ScanError
from viewgain.geometry import transform
from viewgain.scans import Scan
from viewgain.voxels._lattice import Lattice
from viewgain.voxels._march import Backend, march

BLOCK = 2**13
"""Rays at a time, so that their paths stay in the processor's cache."""


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """What one scan says about the voxels of a lattice."""

    hits: Ids
    """(h,) flat indices of the voxels with a return in them, ascending."""
    returns: Ids
    """(h,) number of returns in each."""
    passed: Ids
    """(p,) flat indices of the voxels that rays passed and that are no hits, ascending."""


def evidence(
    lattice: Lattice, scan: Scan, *, empty_is_free: bool = False, stride: int = 1, backend: Backend = "auto"
) -> Evidence:
    """Return what a posed scan says.

    Args:
        lattice: The voxels, world frame.
        scan: A scan with a pose; unorganised ones are welcome.
        empty_is_free: Whether a pixel without a return has looked through the whole lattice: true where nothing swallows light
            and the camera sees far enough, as in simulated worlds with nothing but an object in them. A real camera loses
            returns on dark and grazed surfaces, and then this would carve them away. Needs an organised scan with intrinsics.
        stride: Every return hits its voxel, but only every ``stride``-th pixel along rows and columns frees what lies before it
            (of an unorganised scan every ``stride`` squared-th point): a voxel is usually wider than a pixel.
        backend: Who marches.

    Raises:
        ScanError: If the scan has no pose, or pixels without a return shall speak and it has no image or no intrinsics.
        MissingExtraError: If numba was named and is not installed.
    """
    if scan.camera_to_world is None:
        raise ScanError(f"{scan.source}: a voxel grid needs the camera's pose; give camera_to_world")
    empty = np.zeros((0, 3))
    if empty_is_free:
        empty = _empty_directions(scan, stride) @ scan.camera_to_world[:3, :3].T
    points = transform(scan.camera_to_world, scan.points)
    return evidence_of_rays(lattice, scan.camera_to_world[:3, 3], points, empty, freeing=_freeing(scan, stride), backend=backend)


def evidence_of_rays(
    lattice: Lattice,
    origin: Vector3,
    points: Points,
    empty: Points | None = None,
    *,
    freeing: Mask | None = None,
    backend: Backend = "auto",
) -> Evidence:
    """Return what returns at points say, and rays without a return.

    Args:
        lattice: The voxels, world frame.
        origin: (3,) the camera's centre, metres, world frame.
        points: (n, 3) returns, metres, world frame, none at the centre. One outside the lattice frees what lies before it.
        empty: (m, 3) directions of rays that met nothing, world frame, any length; None for none.
        freeing: (n,) returns that free what lies before them; None for all.
        backend: Who marches.
    """
    voxels = lattice.voxels_of(points)
    hits, returns = np.unique(voxels[voxels < lattice.count], return_counts=True)
    passed = np.zeros(lattice.count + 1, dtype=bool)
    _mark(passed, lattice, origin, (points if freeing is None else points[freeing]) - origin, 1.0, backend)
    if empty is not None:
        _mark(passed, lattice, origin, empty, np.inf, backend)
    passed[hits] = False
    return Evidence(hits, returns.astype(np.int32), np.flatnonzero(passed[:-1]).astype(np.int32))


def _mark(passed: Mask, lattice: Lattice, origin: Vector3, directions: Points, reach: float, backend: Backend) -> None:
    """Set the flags of the voxels that rays pass; the last flag is for what lies outside."""
    for start in range(0, len(directions), BLOCK):
        passed[march(lattice, origin, directions[start : start + BLOCK], reach=reach, backend=backend)] = True


def _freeing(scan: Scan, stride: int) -> Mask:
    """Return (n,) the returns that free what lies before them."""
    if scan.pixels is None or scan.shape is None:
        return np.asarray(np.arange(len(scan.points)) % stride**2 == 0)
    rows, columns = np.divmod(scan.pixels, scan.shape[1])
    return np.asarray((rows % stride == 0) & (columns % stride == 0))


def _empty_directions(scan: Scan, stride: int) -> Points:
    """Return (m, 3) unit directions of every ``stride``-th pixel along rows and columns, without a return, camera frame."""
    if scan.pixels is None or scan.intrinsics is None:
        raise ScanError(f"{scan.source}: empty pixels can only speak in an organised scan with intrinsics")
    empty = np.ones((scan.intrinsics.height, scan.intrinsics.width), dtype=bool)
    empty.ravel()[scan.pixels] = False
    thinned = empty[::stride, ::stride]
    return np.asarray(scan.intrinsics.directions()[::stride, ::stride][thinned])

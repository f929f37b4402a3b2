"""Metrics of the rear side: unobserved space right before a surface that was seen from its other side. docs/volumetric.md."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Mask, Vector
from viewgain.gain._volumetric import GridKnown, ends, seen_entropy
from viewgain.voxels import Paths


@dataclass(frozen=True, slots=True)
class RearSideVoxel:
    """Number of rays that meet an occupied voxel right behind an unobserved one: they look at the back of a known surface.

    Source:
        Isler et al. (2016); Delmerico et al. (2018).
    """

    name: str = "rear_side_voxel"

    def gains(self, known: GridKnown) -> Vector:
        """Return (V,) numbers of rays; 0 for a view that looks past the grid."""
        return np.array([float(np.count_nonzero(meets_rear(known, paths))) for paths in known.paths])


@dataclass(frozen=True, slots=True)
class RearSideEntropy:
    """Over those rays, the sum of v(x) H(x) of the occupied voxel and of the unbroken row of unobserved ones before it.

    Source:
        Isler et al. (2016); Delmerico et al. (2018). That the row counts, and not its last voxel alone, is their public software.
    """

    name: str = "rear_side_entropy"

    def gains(self, known: GridKnown) -> Vector:
        """Return (V,) gains, nats; 0 for a view that looks past the grid."""
        return np.array([rear_entropy(known, paths[:, meets_rear(known, paths)]) for paths in known.paths])


def meets_rear(known: GridKnown, paths: Paths) -> Mask:
    """Return (rays,) whether each ray ends on an occupied voxel and the voxel before it is unobserved."""
    lengths = np.count_nonzero(paths != known.grid.lattice.count, axis=0)
    before = paths[np.maximum(lengths - 2, 0), np.arange(paths.shape[1])]
    return np.asarray((lengths > 1) & known.occupied[ends(known, paths)] & known.unobserved[before])


def rear_entropy(known: GridKnown, paths: Paths) -> float:
    """Return the sum, over rays that meet a rear side, of v(x) H(x) there: of the last voxel and of the row before it."""
    total = row = np.zeros(paths.shape[1])  # row: the sum over the unbroken row of unobserved voxels so far
    for voxels, seen in zip(paths, seen_entropy(known, paths), strict=True):
        total = np.where(known.occupied[voxels], row + seen, total)
        row = np.where(known.unobserved[voxels], row + seen, 0.0)
    return float(total.sum())

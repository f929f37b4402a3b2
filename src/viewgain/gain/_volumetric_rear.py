"""Metrics of the rear side: unobserved space right before a surface that was seen from its other side. docs/volumetric.md."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Mask, Vector
from viewgain.gain._volumetric import GridKnown, seen_entropy
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
        return np.array([float(np.count_nonzero(rear_sides(known, paths)[0])) for paths in known.paths])


@dataclass(frozen=True, slots=True)
class RearSideEntropy:
    """Over those rays, the sum of v(x) H(x) of the occupied voxel and of the unbroken row of unobserved ones before it.

    Source:
        Isler et al. (2016); Delmerico et al. (2018). That the row counts, and not its last voxel alone, is their public software.
    """

    name: str = "rear_side_entropy"

    def gains(self, known: GridKnown) -> Vector:
        """Return (V,) gains, nats; 0 for a view that looks past the grid."""
        return np.array([float(rear_sides(known, paths)[1].sum()) for paths in known.paths])


def rear_sides(known: GridKnown, paths: Paths) -> tuple[Mask, Array]:
    """Return (rays,) whether each ray ends at a rear side, and (rays,) its v(x) H(x) there, 0 where it does not."""
    information = seen_entropy(known, paths)
    rear, total = np.zeros(paths.shape[1], dtype=bool), np.zeros(paths.shape[1])
    before, row = rear.copy(), total.copy()  # was the last voxel unobserved, and the sum over the row that it ends
    for voxels, seen in zip(paths, information, strict=True):
        found = before & known.occupied[voxels]
        rear |= found
        total[found] = row[found] + seen[found]
        before = known.unobserved[voxels]
        row = np.where(before, row + seen, 0.0)
    return rear, total

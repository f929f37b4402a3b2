"""Proximity count: unobserved voxels count the more, the nearer they are to a surface that was seen. docs/volumetric.md."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt

from viewgain.arrays import Vector
from viewgain.gain._volumetric import GridKnown


@dataclass(frozen=True, slots=True)
class ProximityCount:
    """The sum of max(reach - d(x), 0) over the unobserved voxels of all rays, with d(x) the distance to the next occupied voxel.

    Source:
        Isler et al. (2016); Delmerico et al. (2018). Their public software measures d along the ray that was blocked when the
        surface was seen; ours is the Euclidean distance between the voxels' middles, as the formula reads.
    """

    reach: float = 8.0
    """Farther than this from a surface a voxel does not count, edges of a voxel, > 0. Ours: theirs is not known to us."""
    name: str = "proximity_count"

    def gains(self, known: GridKnown) -> Vector:
        """Return (V,) gains, edges of a voxel; 0 for a view that looks past the grid, and everywhere before anything was seen."""
        near = np.append(self.nearness(known), 0.0)
        return np.array([near[paths].sum() for paths in known.paths])

    def nearness(self, known: GridKnown) -> Vector:
        """Return (count,) what each voxel counts, edges of a voxel; 0 where it was observed."""
        occupied = known.grid.occupied.reshape(known.grid.lattice.shape)
        if not np.any(occupied):
            return np.zeros(occupied.size)
        distance = distance_transform_edt(~occupied).ravel()
        return np.where(known.grid.unobserved, np.maximum(self.reach - distance, 0.0), 0.0)

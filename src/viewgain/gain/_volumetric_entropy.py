"""Metrics that add up entropy along the rays: occlusion-aware, unobserved voxel, average entropy. docs/volumetric.md."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Vector
from viewgain.gain._volumetric import GridKnown, ends, seen_entropy


@dataclass(frozen=True, slots=True)
class OcclusionAware:
    """Expected visible uncertainty: the sum of v(x) H(x) over all voxels of all rays.

    Source:
        Isler et al. (2016), section on volumetric information; Delmerico et al. (2018).
    """

    name: str = "occlusion_aware"

    def gains(self, known: GridKnown) -> Vector:
        """Return (V,) gains, nats; 0 for a view that looks past the grid."""
        return np.array([seen_entropy(known, paths).sum() for paths in known.paths])


@dataclass(frozen=True, slots=True)
class UnobservedVoxel:
    """As occlusion-aware, but only voxels that no scan has spoken of count.

    Source:
        Isler et al. (2016); Delmerico et al. (2018).
    """

    name: str = "unobserved_voxel"

    def gains(self, known: GridKnown) -> Vector:
        """Return (V,) gains, nats; 0 for a view that looks past the grid."""
        return np.array([(seen_entropy(known, paths) * known.unobserved[paths]).sum() for paths in known.paths])


@dataclass(frozen=True, slots=True)
class AverageEntropy:
    """Mean entropy of the voxels on those rays that end on an occupied voxel, every voxel as often as rays pass it.

    Source:
        Kriegel et al. (2015), as the public software of Isler et al. (2016) counts it for its comparison.
    """

    name: str = "average_entropy"

    def gains(self, known: GridKnown) -> Vector:
        """Return (V,) means, nats; 0 for a view without a ray to an occupied voxel."""
        means = []
        for paths in known.paths:
            ending = paths[:, known.occupied[ends(known, paths)]]
            passed = np.count_nonzero(ending != known.grid.lattice.count)
            means.append(known.entropy[ending].sum() / max(passed, 1))
        return np.array(means)

"""Kriegel's utility: entropy of the space that a view looks through, joined with how poorly its surface is known so far."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Vector
from viewgain.errors import ConfigError
from viewgain.gain._volumetric import GridKnown, ends


@dataclass(frozen=True, slots=True)
class Kriegel:
    """(1 - weight) E / max E + weight Q / max Q over the candidates.

    E is the mean entropy over the voxels of all rays. Q is the mean, over the rays that end on an occupied voxel, of
    1 - min(returns there / enough, 1): high where the known surface has few points.

    Source:
        Kriegel et al. (2015), Efficient next-best-scan planning for autonomous 3D surface reconstruction of unknown objects,
        from memory and not verified: their quality is that of the reconstructed surface, their weight changes from scan to scan.
    """

    weight: float = 0.5
    """Of the surface against the entropy, 0 to 1."""
    enough: float = 100.0
    """Returns in a voxel after which its surface counts as known, > 0."""
    name: str = "kriegel"

    def __post_init__(self) -> None:
        if not (0 <= self.weight <= 1 and self.enough > 0):
            raise ConfigError(f"kriegel: got weight {self.weight} and enough {self.enough}, wanted 0 to 1 and over 0")

    def gains(self, known: GridKnown) -> Vector:
        """Return (V,) utilities, 0 to 1; 0 for a view that looks past the grid."""
        poorly = np.append(1 - np.minimum(known.grid.returns / self.enough, 1), 0.0)
        entropies, qualities = [], []
        for paths in known.paths:
            passed = np.count_nonzero(paths != known.grid.lattice.count)
            last = ends(known, paths) if paths.size else np.zeros(0, dtype=np.int32)
            surface = last[known.occupied[last]]
            entropies.append(known.entropy[paths].sum() / max(passed, 1))
            qualities.append(float(np.mean(poorly[surface])) if surface.size else 0.0)
        return (1 - self.weight) * _of_best(np.array(entropies)) + self.weight * _of_best(np.array(qualities))


def _of_best(values: Vector) -> Vector:
    """Return (V,) values as shares of the highest; zeros where all are 0."""
    return np.asarray(values / max(values.max(initial=0.0), np.finfo(float).tiny))

"""The area factor: a view should show some known surface, to join the scans, and much of what lies behind. docs/volumetric.md."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation

from viewgain.arrays import Mask, Vector
from viewgain.errors import ConfigError
from viewgain.gain._volumetric import GridKnown
from viewgain.voxels import Paths


@dataclass(frozen=True, slots=True)
class AreaFactor:
    """f(share of rays on occupied voxels; 0.2) + f(share on occplane voxels; 0.8), f being highest at the share asked for.

    An occplane voxel is an unobserved one with a free neighbour across a face: the border of what is hidden. Each ray counts
    once, for the first such or occupied voxel that it meets; the shares are of all rays that meet the grid.

    Source:
        Vasquez-Gomez et al. (2014), Volumetric next-best-view planning for 3D object reconstruction with positioning error: the
        area factor alone, without their factors for quality and distance. The shares asked for are the defaults of the public
        software of Isler et al. (2016).
    """

    occupied: float = 0.2
    """Share of rays on known surface that is best, 0 to 1, both excluded."""
    occplane: float = 0.8
    """Share of rays on the border of the hidden that is best, likewise."""
    name: str = "area_factor"

    def __post_init__(self) -> None:
        if not (0 < self.occupied < 1 and 0 < self.occplane < 1):
            raise ConfigError(f"area factor: got shares {self.occupied} and {self.occplane}, wanted both between 0 and 1")

    def gains(self, known: GridKnown) -> Vector:
        """Return (V,) factors, 0 to 2; 0 for a view that looks past the grid."""
        border = np.append(occplane(known), False)
        shares = np.array([_shares(known, paths, border) for paths in known.paths]).reshape(-1, 2)
        return preference(shares[:, 0], self.occupied) + preference(shares[:, 1], self.occplane)


def occplane(known: GridKnown) -> Mask:
    """Return (count,) the unobserved voxels with a free neighbour across a face."""
    free = known.grid.free.reshape(known.grid.lattice.shape)
    return np.asarray(binary_dilation(free).ravel() & known.grid.unobserved)


def preference(share: Vector, best: float) -> Vector:
    """Return f(share): 0 at 0 and 1, 1 at ``best``, level at all three, and a cubic in between.

    Args:
        share: (n,) shares, 0 to 1.
        best: The share at which f is 1, between 0 and 1.
    """
    rising = np.clip(np.asarray(share) / best, 0, 1)
    falling = np.clip((1 - np.asarray(share)) / (1 - best), 0, 1)
    nearness = np.minimum(rising, falling)
    return np.asarray(nearness**2 * (3 - 2 * nearness))


def _shares(known: GridKnown, paths: Paths, border: Mask) -> tuple[float, float]:
    """Return the shares of a view's rays that first meet an occupied, and an occplane voxel."""
    if paths.size == 0:
        return 0.0, 0.0
    special = border[paths] | known.occupied[paths]
    first = paths[np.argmax(special, axis=0), np.arange(paths.shape[1])]
    on_border, on_surface = border[first], known.occupied[first]
    return float(np.mean(on_surface)), float(np.mean(on_border))

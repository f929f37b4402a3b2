"""Where the voxels lie: an axis-aligned box in the world, cut into cubes."""

from dataclasses import dataclass
from math import prod

import numpy as np

from viewgain.arrays import Ids, Points, Vector3
from viewgain.errors import ConfigError

MOST_VOXELS = 2**27
"""More would not fit into the memory of a laptop; a slip of the keyboard in the resolution asks for it soon."""


@dataclass(frozen=True, slots=True, eq=False)
class Lattice:
    """Cubes of equal size, side by side. Voxel (i, j, k) has the flat index (i * ny + j) * nz + k."""

    low: Vector3
    """(3,) the lowest corner, metres, world frame."""
    size: float
    """Edge of a voxel, metres."""
    shape: tuple[int, int, int]
    """Number of voxels along x, y and z."""

    def __post_init__(self) -> None:
        low = np.asarray(self.low, dtype=float)
        if low.shape != (3,) or not np.all(np.isfinite(low)):
            raise ConfigError(f"lattice: got the corner {self.low}, wanted three finite numbers")
        if not (np.isfinite(self.size) and self.size > 0) or min(self.shape) < 1:
            raise ConfigError(f"lattice: got voxels of {self.size} m, {self.shape} of them; wanted a positive size and counts")
        if prod(self.shape) > MOST_VOXELS:
            raise ConfigError(f"lattice: got {self.shape} voxels, wanted at most {MOST_VOXELS:,} in all; make them larger")
        object.__setattr__(self, "low", low)
        object.__setattr__(self, "shape", tuple(int(count) for count in self.shape))

    @classmethod
    def around(cls, points: Points, *, voxels: int = 40, margin: float = 2.0) -> "Lattice":
        """Return the lattice around (n, 3) points, ``voxels`` along the longest side and ``margin`` more at either end.

        Raises:
            ConfigError: If there is no point, or all are the same.
        """
        points = np.asarray(points, dtype=float)
        if len(points) == 0 or not np.any(np.ptp(points, axis=0)):
            raise ConfigError("lattice: got no two different points to lie around; give the corners of the space to watch")
        low, high = points.min(axis=0), points.max(axis=0)
        size = float((high - low).max()) / voxels
        shape = np.maximum(np.ceil((high - low) / size - 1e-9) + 2 * margin, 1).astype(int)
        return cls((low + high) / 2 - shape * size / 2, size, (int(shape[0]), int(shape[1]), int(shape[2])))

    @property
    def count(self) -> int:
        """Number of voxels; as an index it stands for what lies outside."""
        return prod(self.shape)

    @property
    def high(self) -> Vector3:
        """(3,) the highest corner, metres, world frame."""
        return np.asarray(self.low + self.size * np.array(self.shape))

    @property
    def centres(self) -> Points:
        """(count, 3) middles of the voxels by flat index, metres, world frame."""
        indices = np.stack(np.unravel_index(np.arange(self.count), self.shape), axis=-1)
        return np.asarray(self.low + (indices + 0.5) * self.size)

    def voxels_of(self, points: Points) -> Ids:
        """Return the (n,) int32 flat indices of the voxels that hold (n, 3) world points; :attr:`count` for a point outside.

        A voxel owns its lower faces; the highest face of the lattice is outside.
        """
        cells = np.floor((np.asarray(points, dtype=float) - self.low) / self.size)
        inside = np.all((cells >= 0) & (cells < self.shape), axis=1)
        i, j, k = np.where(inside[:, None], cells, 0).astype(np.int64).T
        return np.where(inside, (i * self.shape[1] + j) * self.shape[2] + k, self.count).astype(np.int32)

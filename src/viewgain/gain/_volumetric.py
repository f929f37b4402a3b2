"""What every volumetric metric looks at: a voxel grid, candidate views, and the rays of those views through the grid.

Notation of docs/volumetric.md: a ray passes the voxels x1, x2, ... up to the first occupied one, which is still on it, or to the
far side of the grid. H(x) is the entropy of x in nats, and x is visible with probability v(xn) = product of (1 - p(xi)), i < n.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array, Mask, Poses, Vector
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError
from viewgain.voxels import Backend, Paths, VoxelGrid, march


@dataclass(frozen=True, eq=False)
class GridKnown:
    """What is known when volumetric metrics are asked: a grid, and where the camera could go.

    The rays are cast at the first question and kept, so that several metrics about the same situation share them.
    """

    grid: VoxelGrid
    """What the scans so far say about space, world frame."""
    candidates: Poses
    """(V, 4, 4) poses ``camera_to_world``."""
    camera: Intrinsics
    """One ray per pixel; about one per voxel is enough (:func:`viewgain.voxels.coarser`)."""
    backend: Backend = "auto"
    """Who casts the rays."""

    def __post_init__(self) -> None:
        candidates = np.asarray(self.candidates, dtype=float)
        if candidates.ndim != 3 or candidates.shape[1:] != (4, 4):
            raise ConfigError(f"candidates: got an array of shape {candidates.shape}, wanted (V, 4, 4) poses")
        object.__setattr__(self, "candidates", candidates)

    @cached_property
    def paths(self) -> tuple[Paths, ...]:
        """Per view the (steps, rays) flat voxel indices along its rays; a ray that misses the grid has no column."""
        directions, stop = self.camera.directions().reshape(-1, 3), self.grid.occupied
        lattice = self.grid.lattice
        every = (
            march(lattice, pose[:3, 3], directions @ pose[:3, :3].T, stop=stop, backend=self.backend) for pose in self.candidates
        )
        return tuple(np.ascontiguousarray(paths[:, np.any(paths[:1] != lattice.count, axis=0)]) for paths in every)

    @cached_property
    def entropy(self) -> Vector:
        """(count + 1,) entropy of each voxel, nats; 0 for what lies outside, the last."""
        return np.append(self.grid.entropy, 0.0)

    @cached_property
    def transmission(self) -> Vector:
        """(count + 1,) probability of each voxel to be free; 1 for what lies outside, the last."""
        return np.append(1 - self.grid.probability, 1.0)

    @cached_property
    def unobserved(self) -> Mask:
        """(count + 1,) voxels that no scan has spoken of; what lies outside, the last, is none."""
        return np.append(self.grid.unobserved, False)

    @cached_property
    def occupied(self) -> Mask:
        """(count + 1,) voxels that are occupied; what lies outside, the last, is none."""
        return np.append(self.grid.occupied, False)


def visibility(known: GridKnown, paths: Paths) -> Array:
    """Return the (steps, rays) probability that a voxel is seen past those before it on its ray: 1 in the first row."""
    through = np.ones(paths.shape)
    for before, here, passing in zip(through, through[1:], known.transmission[paths[:-1]], strict=False):
        np.multiply(before, passing, out=here)  # row by row: np.cumprod along the first axis takes ten times as long
    return through


def seen_entropy(known: GridKnown, paths: Paths) -> Array:
    """Return the (steps, rays) volumetric information v(x) H(x); 0 below a path's end."""
    return visibility(known, paths) * known.entropy[paths]


def ends(known: GridKnown, paths: Paths) -> NDArray[np.int32]:
    """Return the (rays,) last voxel on each ray."""
    lengths = np.count_nonzero(paths != known.grid.lattice.count, axis=0)
    return np.asarray(paths[lengths - 1, np.arange(paths.shape[1])])

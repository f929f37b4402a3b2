"""Voxels ray by ray and cube by cube: which cubes a ray passes, and the volumetric metrics as their sums are written."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from viewgain.voxels import Lattice, VoxelGrid

Row = NDArray[np.float64]
SLIVER = 1e-9
"""A ray that stays in a cube for less than this share of its length only touches it, as far as rounding can tell."""


def passed_voxels(lattice: Lattice, origin: Row, direction: Row, reach: float = math.inf) -> list[int]:
    """Return the flat indices of the cubes that a ray passes through, in the order of entry: every cube is tried."""
    found = []
    nx, ny, nz = lattice.shape
    for i in range(nx):
        for j in range(ny):
            for k in range(nz):
                low = [lattice.low[axis] + (i, j, k)[axis] * lattice.size for axis in range(3)]
                inside = through_cube(low, lattice.size, origin, direction, reach)
                if inside is not None and inside[1] - inside[0] > SLIVER:
                    found.append((inside[0], (i * ny + j) * nz + k))
    return [index for _, index in sorted(found)]


def through_cube(low: Sequence[float], size: float, origin: Row, direction: Row, reach: float) -> tuple[float, float] | None:
    """Return from where to where a ray is in a cube, in lengths of its direction; None if it passes it by."""
    start, end = 0.0, reach
    for axis in range(3):
        if direction[axis] == 0:
            if not low[axis] <= origin[axis] < low[axis] + size:
                return None
            continue
        faces = [(low[axis] - origin[axis]) / direction[axis], (low[axis] + size - origin[axis]) / direction[axis]]
        start, end = max(start, min(faces)), min(end, max(faces))
    return (start, end) if start < end else None


def until_occupied(grid: VoxelGrid, voxels: Sequence[int]) -> list[int]:
    """Return a path up to its first occupied voxel, that one included."""
    path = []
    for voxel in voxels:
        path.append(voxel)
        if probability(grid, voxel) > 0.5:
            break
    return path


def probability(grid: VoxelGrid, voxel: int) -> float:
    """Return the probability of a voxel to be occupied."""
    return 1 / (1 + math.exp(-grid.log_odds[voxel]))


def entropy(grid: VoxelGrid, voxel: int) -> float:
    """Return its entropy, nats."""
    p = probability(grid, voxel)
    return -p * math.log(p) - (1 - p) * math.log(1 - p)


def information(grid: VoxelGrid, path: Sequence[int]) -> list[float]:
    """Return v(x) H(x) of every voxel of a path."""
    seen, visible = [], 1.0
    for voxel in path:
        seen.append(visible * entropy(grid, voxel))
        visible *= 1 - probability(grid, voxel)
    return seen


def metric(name: str, grid: VoxelGrid, rays: Sequence[Sequence[int]]) -> float:
    """Return a metric of one view from the voxels that each of its rays passes (not yet cut at the first occupied one)."""
    paths = [path for path in (until_occupied(grid, ray) for ray in rays) if path]
    return {
        "occlusion_aware": lambda: sum(sum(information(grid, path)) for path in paths),
        "unobserved_voxel": lambda: sum(
            seen for path in paths for voxel, seen in zip(path, information(grid, path), strict=True) if not grid.observed[voxel]
        ),
        "rear_side_voxel": lambda: float(sum(is_rear(grid, path) for path in paths)),
        "rear_side_entropy": lambda: sum(rear_entropy(grid, path) for path in paths if is_rear(grid, path)),
        "average_entropy": lambda: average_entropy(grid, paths),
        "proximity_count": lambda: sum(nearness(grid, voxel) for path in paths for voxel in path),
        "area_factor": lambda: area_factor(grid, paths),
    }[name]()


def is_rear(grid: VoxelGrid, path: Sequence[int]) -> bool:
    """Return whether a path ends on an occupied voxel right behind an unobserved one."""
    return len(path) > 1 and probability(grid, path[-1]) > 0.5 and not grid.observed[path[-2]]


def rear_entropy(grid: VoxelGrid, path: Sequence[int]) -> float:
    """Return the sum over the last voxel and the row of unobserved ones before it."""
    seen = information(grid, path)
    total, place = seen[-1], len(path) - 2
    while place >= 0 and not grid.observed[path[place]]:
        total += seen[place]
        place -= 1
    return total


def average_entropy(grid: VoxelGrid, paths: Sequence[Sequence[int]]) -> float:
    """Return the mean over the voxels of the rays that end on an occupied one."""
    entropies = [entropy(grid, voxel) for path in paths if probability(grid, path[-1]) > 0.5 for voxel in path]
    return sum(entropies) / len(entropies) if entropies else 0.0


def nearness(grid: VoxelGrid, voxel: int, reach: float = 8.0) -> float:
    """Return what an unobserved voxel counts: reach minus the distance to the next occupied one, at least 0."""
    occupied = np.flatnonzero(grid.log_odds > 0)
    if grid.observed[voxel] or not len(occupied):
        return 0.0
    cells = np.array(np.unravel_index(occupied, grid.lattice.shape)).T
    apart = np.linalg.norm(cells - np.unravel_index(voxel, grid.lattice.shape), axis=1)
    return max(reach - float(apart.min()), 0.0)


def area_factor(grid: VoxelGrid, paths: Sequence[Sequence[int]]) -> float:
    """Return f(share on occupied; 0.2) + f(share on occplane; 0.8), f as the polynomial of the public software."""
    counts = {"occupied": 0, "occplane": 0}
    for path in paths:
        for voxel in path:
            if probability(grid, voxel) > 0.5:
                counts["occupied"] += 1
                break
            if not grid.observed[voxel] and any(grid.log_odds[other] < 0 for other in neighbours(grid.lattice, voxel)):
                counts["occplane"] += 1
                break
    if not paths:
        return 0.0
    return cubic(counts["occupied"] / len(paths), 0.2) + cubic(counts["occplane"] / len(paths), 0.8)


def cubic(x: float, a: float) -> float:
    """Return the area factor's f(x; a) by its two polynomials (Vasquez-Gomez et al. 2014)."""
    if x <= a:
        return -2 / a**3 * x**3 + 3 / a**2 * x**2
    d = (a - 1) ** 3
    return -2 / d * x**3 + 3 * (a + 1) / d * x**2 - 6 * a / d * x + (3 * a - 1) / d


def neighbours(lattice: Lattice, voxel: int) -> list[int]:
    """Return the voxels across the faces of one."""
    cell = np.array(np.unravel_index(voxel, lattice.shape))
    found = []
    for axis in range(3):
        for step in (-1, 1):
            other = cell.copy()
            other[axis] += step
            if np.all(other >= 0) and np.all(other < lattice.shape):
                found.append(int(np.ravel_multi_index(tuple(other), lattice.shape)))
    return found

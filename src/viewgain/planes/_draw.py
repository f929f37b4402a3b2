"""Which points are references, and which are their partners: as published, or drawn fairly."""

import numpy as np

from viewgain.arrays import Indices, Points, Vector
from viewgain.planes._cloud import Cloud
from viewgain.planes._settings import Settings

_TREE_LEVELS = 10
"""Halvings per axis of the tree; at 1.5 m its cells measure 1.5 mm."""
_SPHERE_BINS = 6
"""Cells along each axis of the cube that normals are counted in: about 15 degrees wide."""


def draw_references(cloud: Cloud, settings: Settings, rng: np.random.Generator) -> Indices:
    """Return the indices of the reference points, with replacement."""
    count = max(len(cloud) // 500, settings.references)
    return rng.choice(len(cloud), count, p=balance(cloud.normals) if settings.balanced_draw else None)


def draw_pairs(cloud: Cloud, references: Indices, settings: Settings, rng: np.random.Generator) -> Indices:
    """Return the (r, k) partners of each reference, k the cap on pairs or the size of the cloud."""
    count = min(settings.pairs, len(cloud))
    if not settings.random_pairs:
        return first_in_tree(cloud.points, references, count)
    return rng.choice(len(cloud), (len(references), count), p=balance(cloud.normals) if settings.balanced_draw else None)


def balance(normals: Points) -> Vector:
    """Return (n,) probabilities that make every direction of normals about equally likely, however many points have it.

    Directions are cells of a cube; a cell's share grows with the root of its count only, so that a face with a tenth of the
    points has a third of the chances, and stray normals still have few.
    """
    cell = np.clip(((normals + 1) / 2 * _SPHERE_BINS).astype(int), 0, _SPHERE_BINS - 1) @ (_SPHERE_BINS**2, _SPHERE_BINS, 1)
    weight = 1 / np.sqrt(np.bincount(cell))[cell]
    return np.asarray(weight / weight.sum())


def first_in_tree(points: Points, references: Indices, count: int) -> Indices:
    """Return the (r, count) points that a tree search from each reference meets first.

    A search descends into the half of every cell that holds the reference before the other, so the points come in the order of
    where their path through the tree parts from the reference's: that of the exclusive or of the two paths. With halvings at
    the middle of cells, x, y and z in turn, a path is the point's Morton code.
    """
    path = morton_codes(points)
    order = np.argsort(path, kind="stable")
    path = path[order]
    partners = np.empty((len(references), count), dtype=np.intp)
    own = path[np.argsort(order)[references]]
    for k, (low, high) in enumerate(zip(*_smallest_cells(path, own, count), strict=True)):
        first = np.argsort(path[low:high] ^ own[k], kind="stable")[:count]
        partners[k] = order[low + first]
    return partners


def morton_codes(points: Points) -> Indices:
    """Return (n,) codes whose bits, from the highest, tell in which half of the cloud's cube a point lies: x, y, z, x, ..."""
    low = points.min(axis=0)
    side = float((points.max(axis=0) - low).max()) * (1 + 1e-9) + 1e-12
    cell = ((points - low) / side * 2**_TREE_LEVELS).astype(np.intp)
    code = np.zeros(len(points), dtype=np.intp)
    for level in reversed(range(_TREE_LEVELS)):
        for axis in range(3):
            code = (code << 1) | ((cell[:, axis] >> level) & 1)
    return code


def _smallest_cells(path: Indices, own: Indices, count: int) -> tuple[Indices, Indices]:
    """Return where in sorted ``path`` the smallest cell about each ``own`` path begins and ends that holds ``count`` points."""
    low, high = np.zeros(len(own), dtype=np.intp), np.full(len(own), len(path))
    for bits in reversed(range(3 * _TREE_LEVELS)):
        first = own >> bits << bits
        begin, end = np.searchsorted(path, first), np.searchsorted(path, first + (1 << bits))
        holds = end - begin >= count
        low, high = np.where(holds, begin, low), np.where(holds, end, high)
    return low, high

"""Parallel planes share a direction (stages 4 and 5): a graph of directions, each with its offsets, joined by right angles."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Indices, Mask, Points, Vector
from viewgain.planes._cluster import components, rewired
from viewgain.planes._settings import Settings
from viewgain.planes._votes import Edges, Hypotheses


@dataclass(frozen=True, slots=True, eq=False)
class Planes:
    """Planes grouped by direction: plane k is ``normals[direction[k]] . x + offsets[k] = 0``."""

    normals: Points
    """(g, 3) unit normals, one per direction."""
    direction: Indices
    """(m,) the direction of each plane."""
    offsets: Vector
    """(m,) metres."""
    edges: Edges
    """(e, 2) directions that are orthogonal, by votes."""
    hidden: int = 0
    """So many of the last planes have no points of their own: sides that the others' ends tell of."""

    def __len__(self) -> int:
        return len(self.offsets)

    @property
    def each_normal(self) -> Points:
        """(m, 3) the normal of each plane."""
        return np.asarray(self.normals[self.direction])

    @property
    def seen(self) -> int:
        """How many planes have points; they come first."""
        return len(self) - self.hidden

    def heights(self, points: Points) -> Array:
        """Return the (n, m) signed distances of points from planes, metres."""
        return np.asarray((points @ self.normals.T)[:, self.direction] + self.offsets)

    def kept(self, planes: Mask) -> "Planes":
        """Return the marked planes; directions left without a plane go, with their edges."""
        present = np.bincount(self.direction[planes], minlength=len(self.normals)) > 0
        renamed = np.cumsum(present) - 1
        edges = self.edges[present[self.edges].all(axis=1)]
        return Planes(self.normals[present], renamed[self.direction[planes]], self.offsets[planes], renamed[edges])


def parallel_sets(planes: Hypotheses, settings: Settings) -> Planes:
    """Return the planes grouped into directions; the first plane of each gives its normal."""
    first, label = _leaders(planes.normals, settings)
    normals = planes.normals[first]
    offsets = -np.einsum("mk,mk->m", normals[label], planes.anchors)
    return Planes(normals, label, offsets, rewired(planes.edges, label))


def united_triangles(planes: Planes) -> Planes:
    """Return the planes with directions united that are orthogonal to the same two orthogonal directions: they are parallel.

    In the graph these are the far corners of two triangles that share an edge.
    """
    adjacent = np.zeros((len(planes.normals),) * 2, dtype=bool)
    adjacent[planes.edges[:, 0], planes.edges[:, 1]] = True
    adjacent |= adjacent.T
    over_edge = adjacent[planes.edges[:, 0]] & adjacent[planes.edges[:, 1]]  # [edge, direction]
    label = components(over_edge.T.astype(int) @ over_edge > 0)
    return united(planes, label, signed=True)


def merged(planes: Planes, settings: Settings) -> Planes:
    """Return the planes after near-parallel directions became one and near offsets their mean (end of stage 7).

    Published, the offsets of a direction with an opposite normal keep their sign, which moves those planes elsewhere;
    ``signed_merge`` mends it. ``merge_band`` is the gap below which two sorted offsets are one plane.
    """
    _, label = _leaders(planes.normals, settings)
    together = united(planes, label, signed=settings.signed_merge)
    order = np.lexsort([together.offsets, together.direction])
    direction, offsets = together.direction[order], together.offsets[order]
    apart = (np.diff(direction, prepend=-1) != 0) | (np.diff(offsets, prepend=-np.inf) >= settings.merge_band)
    plane = np.cumsum(apart) - 1
    mean = np.bincount(plane, offsets) / np.maximum(np.bincount(plane), 1)
    return Planes(together.normals, direction[apart], mean, together.edges)


def united(planes: Planes, label: Indices, *, signed: bool) -> Planes:
    """Return the planes with directions of one label united under the first one's normal.

    Args:
        planes: The planes.
        label: (g,) 0, 1, ... in the order of first appearance.
        signed: Whether an offset changes its sign where its normal opposes the first one's.
    """
    _, first = np.unique(label, return_index=True)
    turned = np.einsum("gk,gk->g", planes.normals, planes.normals[first][label]) < 0
    sign = np.where(turned & signed, -1.0, 1.0)
    return Planes(
        planes.normals[first], label[planes.direction], planes.offsets * sign[planes.direction], rewired(planes.edges, label)
    )


def _leaders(normals: Points, settings: Settings) -> tuple[Indices, Indices]:
    """Return, for groups of parallel normals, the index of each first one, and (n,) group labels."""
    near = np.abs(normals @ normals.T) > settings.parallel
    label = np.full(len(normals), -1)
    first: list[int] = []
    for k in range(len(normals)):
        if label[k] < 0:
            label[near[k] & (label < 0)] = len(first)
            first.append(k)
    return np.array(first, dtype=np.intp), label

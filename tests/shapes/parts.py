"""Taking an object apart again: its parts are the connected pieces of its mesh. What closed, outward-wound surfaces obey."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pieces:
    """The connected pieces of a mesh, by shared vertices."""

    label: NDArray[np.intp]
    """(f,) piece of each triangle."""
    volumes: Array
    """(p,) signed volume of each piece: positive where the triangles point outwards."""
    areas: Array
    """(f,) area of each triangle."""


def is_closed(faces: NDArray[np.int32]) -> bool:
    """Return whether each edge belongs to exactly two triangles, which run along it in opposite senses."""
    start, end = faces.ravel().astype(np.int64), faces[:, [1, 2, 0]].ravel().astype(np.int64)
    edge = np.minimum(start, end) * (int(faces.max()) + 1) + np.maximum(start, end)
    keys = np.sort(2 * edge + (start > end))  # each edge must come as an even number and the odd one after it
    pairs = keys.reshape(-1, 2) if len(keys) % 2 == 0 else keys[:0]
    return len(pairs) > 0 and bool(
        (pairs[:, 0] % 2 == 0).all() and (pairs[:, 1] == pairs[:, 0] + 1).all() and (pairs[1:, 0] > pairs[:-1, 0]).all()
    )


def signed_volume(triangles: Array) -> float:
    """Return the volume that closed triangles enclose, by the divergence theorem."""
    return float(np.einsum("ij,ij->", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])) / 6)


def surface_area(triangles: Array) -> float:
    """Return the total area."""
    return float(np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1).sum() / 2)


def pieces(vertices: Array, faces: NDArray[np.int32]) -> Pieces:
    """Return the connected pieces; each volume is measured from one of the piece's own vertices, so that it keeps its digits."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [0, 2]]])
    graph = coo_matrix((np.ones(len(edges)), edges.T), shape=(len(vertices), len(vertices)))
    count, of_vertex = connected_components(graph, directed=False)
    label = of_vertex[faces[:, 0]]
    first = np.empty(count, dtype=int)
    first[of_vertex[::-1]] = np.arange(len(vertices))[::-1]
    start = vertices[faces[:, 0]]
    normals = doubled_normals(start, vertices[faces[:, 1]], vertices[faces[:, 2]])
    heights = np.einsum("ij,ij->i", start - vertices[first[label]], normals)
    return Pieces(label, np.bincount(label, heights / 6, count), np.sqrt(np.einsum("ij,ij->i", normals, normals)) / 2)


def doubled_normals(a: Array, b: Array, c: Array) -> Array:
    """Return the cross products of two sides; as long as twice the area."""
    (ux, uy, uz), (vx, vy, vz) = (b - a).T, (c - a).T
    return np.stack([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], axis=1)


def repeats(label: NDArray[np.intp], triangles: Array) -> bool:
    """Return whether a piece has two triangles with the same three corners, to 1e-9."""
    weights = np.array(
        [1.0, 0.7548776662, 0.5698402910]
    )  # one number per corner, in a direction that no shape is symmetric about
    corners = np.sort(triangles @ weights, axis=1)
    keys = np.sort(np.round((corners @ [1.0, 10.0, 100.0] + 1000.0 * label) / 1e-9))
    return bool((keys[1:] == keys[:-1]).any())


def first_hits(triangles: Array, origin: Array, ray: Array) -> NDArray[np.intp]:
    """Return the first triangle that each of (n, 3) parallel rays meets, -1 for none; plain Moeller-Trumbore, no shortcuts."""
    base, u, v = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    across = np.cross(ray, v)
    det = np.einsum("fi,fi->f", u, across)
    usable = np.abs(det) > 1e-14
    base, u, v, across, det = base[usable], u[usable], v[usable], across[usable], det[usable]
    at = origin @ across.T - np.einsum("fi,fi->f", base, across)
    turned = np.cross(u, ray)  # ray . (s x u) = s . (u x ray)
    bt = origin @ turned.T - np.einsum("fi,fi->f", base, turned)
    normal = np.cross(u, v)
    depth = (origin @ normal.T - np.einsum("fi,fi->f", base, normal)) / det
    inside = (at / det >= 0) & (bt / det >= 0) & ((at + bt) / det <= 1)
    depth = np.where(inside, depth, np.inf)
    nearest = depth.argmin(axis=1)
    found = np.isfinite(depth[np.arange(len(origin)), nearest])
    return np.where(found, np.flatnonzero(usable)[nearest], -1)

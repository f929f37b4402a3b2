"""Ray by ray, triangle by triangle: where a ray meets a mesh. Slow, plain, and without Moeller and Trumbore. Also meshes to try.

Seen along the ray, a triangle is a flat figure around a point: the ray meets it if that point is inside, and how far the
point is from the sides says how sure that is.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.oracles.rays import Triple, cross, dot, minus
from viewgain.meshes import TriangleMesh

Array = NDArray[np.float64]
CLEAR = 1e-6
"""A ray that passes an edge at this distance (metres) or less may be decided by rounding."""


@dataclass(frozen=True)
class FirstHit:
    """What one ray meets first."""

    range: float
    index: int
    cosine: float
    """Of incidence; 0 for a miss."""
    clearance: float
    """Distance from the ray's line to the nearest edge of any triangle, metres."""
    gap: float
    """From the first hit to the second, metres: below :data:`CLEAR`, either may be found."""


def first_hit(mesh: TriangleMesh, origin: Array, direction: Array) -> FirstHit:
    """Return the first hit of a unit ray; a range of inf and an index of -1 for a miss."""
    start, along = as_triple(origin), as_triple(direction)
    hits, clearance = [], math.inf
    for index, corners in enumerate(mesh.triangles.tolist()):
        offsets = [minus(corner, start) for corner in corners]
        flat = [minus(offset, scaled(along, dot(offset, along))) for offset in offsets]
        clearance = min(clearance, *(from_segment(flat[k - 1], flat[k]) for k in range(3)))
        normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]))
        size = math.sqrt(dot(normal, normal))
        sides = [dot(along, cross(flat[k - 1], flat[k])) for k in range(3)]
        if size < 1e-15 or abs(dot(normal, along)) < 1e-12 * size:
            continue
        distance = dot(normal, offsets[0]) / dot(normal, along)
        if distance > 1e-6 and (min(sides) >= 0 or max(sides) <= 0):
            hits.append((distance, index, abs(dot(normal, along)) / size))
    hits.sort()
    if not hits:
        return FirstHit(math.inf, -1, 0.0, clearance, math.inf)
    gap = hits[1][0] - hits[0][0] if len(hits) > 1 else math.inf
    return FirstHit(*hits[0], clearance, gap)


def first_hits(mesh: TriangleMesh, origins: Array, directions: Array) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Return (n,) ranges, indices, cosines, and a mask of the rays whose answer does not hang on rounding."""
    hits = [first_hit(mesh, o, d) for o, d in zip(np.broadcast_to(origins, directions.shape), directions, strict=True)]
    clear = np.array([hit.clearance > CLEAR and hit.gap > CLEAR for hit in hits])
    return np.array([h.range for h in hits]), np.array([h.index for h in hits]), np.array([h.cosine for h in hits]), clear


def as_triple(point: Array) -> Triple:
    """Return three plain numbers."""
    return float(point[0]), float(point[1]), float(point[2])


def scaled(a: Triple, by: float) -> Triple:
    """Return a * by."""
    return a[0] * by, a[1] * by, a[2] * by


def from_segment(start: Triple, end: Triple) -> float:
    """Return the distance of a segment to the origin."""
    side = minus(end, start)
    length = dot(side, side)
    share = min(max(-dot(start, side) / length, 0.0), 1.0) if length > 0 else 0.0
    nearest = minus(start, scaled(side, -share))
    return math.sqrt(dot(nearest, nearest))


def soup(rng: np.random.Generator, count: int = 25, size: float = 0.7) -> TriangleMesh:
    """Return triangles in all directions from the origin, 1 to 3 m away; every eighth is degenerate."""
    away = unit_rays(rng, count) * rng.uniform(1, 3, (count, 1))
    corners = away[:, None] + rng.normal(scale=size, size=(count, 3, 3))
    corners[::8, 2] = corners[::8, 1]
    return TriangleMesh(corners.reshape(-1, 3), np.arange(3 * count, dtype=np.int32).reshape(-1, 3), "soup")


def unit_rays(rng: np.random.Generator, count: int) -> Array:
    """Return (n, 3) directions, evenly spread."""
    directions = rng.normal(size=(count, 3))
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True))


def block(low: Array, high: Array) -> TriangleMesh:
    """Return the twelve triangles of an axis-aligned box; triangles 2 k and 2 k + 1 are side k of -x, +x, -y, +y, -z, +z."""
    corners = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
    quads = [(0, 2, 6, 4), (1, 5, 7, 3), (0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2), (4, 6, 7, 5)]
    return TriangleMesh(
        corners, np.array([half for a, b, c, d in quads for half in ((a, b, c), (a, c, d))], dtype=np.int32), "block"
    )


def block_ranges(low: Array, high: Array, origins: Array, directions: Array) -> Array:
    """Return (n,) ranges to the surface of that box, by the slabs between its sides; inf for a miss."""
    with np.errstate(divide="ignore"):
        sides = (np.stack([low, high]) - np.broadcast_to(origins, directions.shape)[:, None]) / directions[:, None]
    enter, leave = sides.min(axis=1).max(axis=1), sides.max(axis=1).min(axis=1)
    return np.where((enter > leave) | (leave <= 0), np.inf, np.where(enter > 0, enter, leave))


def bumpy_sphere(rows: int = 160, columns: int = 160) -> TriangleMesh:
    """Return a closed ball of radius 0.4 m with bumps and dents: 2 * rows * columns triangles, those at the poles degenerate."""
    polar, turn = np.meshgrid(np.linspace(0, np.pi, rows + 1), np.arange(columns) * 2 * np.pi / columns, indexing="ij")
    flat = np.sin(polar)
    radius = 0.4 + 0.06 * np.sin(5 * turn) * flat**2 * np.sin(4 * polar) + 0.012 * np.cos(23 * turn) * flat
    radius[[0, -1]] = 0.4
    flat[[0, -1]] = 0.0
    points = radius[..., None] * np.stack([flat * np.cos(turn), flat * np.sin(turn), np.cos(polar)], axis=-1)
    row, column = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    a, b = row * columns + column, row * columns + (column + 1) % columns
    halves = [np.stack([a, a + columns, b + columns], axis=-1), np.stack([a, b + columns, b], axis=-1)]
    return TriangleMesh(points.reshape(-1, 3), np.concatenate(halves).reshape(-1, 3), "bumpy sphere")

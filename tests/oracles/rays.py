"""Ray by ray, polygon by polygon: where a ray meets a box on a floor. Slow, plain, and made of corners only."""

import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from viewgain.box import Box

Point = NDArray[np.float64]
Triple = tuple[float, float, float]

# Corner k of a box lies at (x, y, z) with x the first bit of k, y the second and z the third; each face once around.
QUADS = {
    "+x": (1, 3, 7, 5),
    "-x": (0, 4, 6, 2),
    "+y": (2, 6, 7, 3),
    "-y": (0, 1, 5, 4),
    "top": (4, 5, 7, 6),
    "bottom": (0, 2, 3, 1),
}
NOWHERE = math.inf


def hit_polygon(corners: Sequence[Triple], origin: Triple, direction: Triple) -> tuple[float, float]:
    """Return the distance along the unit ray to a convex polygon and the cosine of incidence; (inf, 0) for a miss."""
    normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]))
    size = math.sqrt(dot(normal, normal))
    approach = dot(normal, direction) / size
    if abs(approach) < 1e-12:
        return NOWHERE, 0.0
    distance = dot(normal, minus(corners[0], origin)) / size / approach
    if distance <= 0:
        return NOWHERE, 0.0
    point = (origin[0] + distance * direction[0], origin[1] + distance * direction[1], origin[2] + distance * direction[2])
    sides = [dot(normal, cross(minus(corners[k], corners[k - 1]), minus(point, corners[k - 1]))) for k in range(len(corners))]
    inside = all(side >= 0 for side in sides) or all(side <= 0 for side in sides)
    return (distance, abs(approach)) if inside else (NOWHERE, 0.0)


def dot(a: Triple, b: Triple) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def minus(a: Triple, b: Triple) -> Triple:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def cross(a: Triple, b: Triple) -> Triple:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def hit_box(box: Box, origin: Point, direction: Point) -> tuple[float, float, str | None]:
    """Return range, cosine and name of the first face of a closed box that a ray meets; (inf, 0, None) for a miss."""
    corners, start, along = corners_of(box).tolist(), tuple(map(float, origin)), tuple(map(float, direction))
    hits = [(*hit_polygon([corners[k] for k in quad], start, along), name) for name, quad in QUADS.items()]
    distance, cosine, name = min(hits, key=lambda hit: hit[0])
    return (distance, cosine, name) if math.isfinite(distance) else (NOWHERE, 0.0, None)


def corners_of(box: Box) -> Point:
    """Return the (8, 3) corners from the pose and the extents alone."""
    corners = []
    for k in range(8):
        x, y, z = (1 if k & 1 else -1) / 2, (1 if k & 2 else -1) / 2, 1 if k & 4 else 0
        corners.append(box.box_to_camera @ np.array([x * box.extents[0], y * box.extents[1], z * box.extents[2], 1.0]))
    return np.array(corners)[:, :3]


def world_range(boxes: Iterable[Box], camera_to_world: Point, direction: Point) -> tuple[float, float]:
    """Return range and cosine of incidence of one camera ray in a world of boxes (world frame) on the floor z = 0."""
    origin, ray = camera_to_world[:3, 3], camera_to_world[:3, :3] @ direction
    best = (-origin[2] / ray[2], -ray[2]) if ray[2] < 0 else (NOWHERE, 0.0)
    for box in boxes:
        distance, cosine, _ = hit_box(box, origin, ray)
        if distance < best[0]:
            best = (distance, cosine)
    return float(best[0]), float(best[1])


def to_segment(point: Point, start: Point, end: Point) -> float:
    """Return the distance of a point in the plane to a segment."""
    side = end - start
    along = min(max(float((point - start) @ side) / float(side @ side), 0.0), 1.0)
    return float(np.linalg.norm(point - start - along * side))

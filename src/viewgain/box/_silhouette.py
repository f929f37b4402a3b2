"""The outline of a box in the image: its polygon, each pixel's signed distance to it, and how that moves with the box.

Image coordinates here are the normalised ones, (x/z, y/z), in which straight edges stay straight whatever the lens.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array, Indices, Mask, Points2
from viewgain.box._box import CORNERS, FLOOR, PLANE_EXTENTS, PLANE_NORMALS, Box
from viewgain.geometry import cross_matrix

_Number = TypeVar("_Number", np.float64, np.intp)

NEAR = 0.02
"""Corners nearer than this to the image plane through the camera are held at it, metres."""


@dataclass(frozen=True, eq=False)
class Outline:
    """The convex outline of a box as the camera sees it, or of each box of a stack.

    Then k is that of the longest of them: the last vertex of the others is repeated, which makes edges of no length.
    """

    vertices: Points2
    """(k, 2) normalised image coordinates of the outline, counter-clockwise for x right and y up (clockwise on screen)."""
    corners: Indices
    """(k,) which corner of the box each vertex is."""

    @cached_property
    def lengths(self) -> Array:
        """(k,) lengths of the edges."""
        return np.asarray(np.maximum(np.linalg.norm(following(self.vertices, axis=-2) - self.vertices, axis=-1), 1e-12))

    @cached_property
    def tangents(self) -> Points2:
        """(k, 2) unit directions of the edges, each from its vertex to the next."""
        return np.asarray((following(self.vertices, axis=-2) - self.vertices) / self.lengths[..., None])

    @cached_property
    def inward(self) -> Points2:
        """(k, 2) unit normals of the edges, pointing inside."""
        return np.stack([-self.tangents[..., 1], self.tangents[..., 0]], axis=-1)

    @property
    def middle(self) -> Points2:
        """(2,) mean of the vertices."""
        own = self.corners != following(self.corners, axis=-1)  # not repeated
        return np.asarray(np.sum(self.vertices * own[..., None], axis=-2) / own.sum(axis=-1, keepdims=True))

    def outside(self, points: Points2) -> Mask:
        """Return which of (m, 2) image points lie outside, (m,)."""
        level = np.sum(self.vertices * self.inward, axis=-1)
        return np.asarray(np.any(self.inward @ points.mT < level[..., None], axis=-2))


@dataclass(frozen=True, slots=True)
class EdgeDistances:
    """Signed distances of image points to an outline."""

    distance: Array
    """(n,) distance to the nearest edge line, normalised units, positive inside."""
    edge: Indices
    """(n,) which edge that is: from vertex ``edge`` to the next."""
    along: Array
    """(n,) where on that edge the foot point lies, 0 to 1."""

    def take(self, chosen: Indices) -> "EdgeDistances":
        """Return a subset of the points."""
        return EdgeDistances(self.distance[chosen], self.edge[chosen], self.along[chosen])


@lru_cache(maxsize=16)  # predicting a view asks for it several times; a box is known by its identity
def outline(box: Box) -> Outline:
    """Return the convex hull of the box's eight projected corners (Andrew's monotone chain); takes a stack."""
    points = _project(box.corners())
    hulls = [_hull([(x, y) for x, y in each]) for each in points.reshape(-1, 8, 2).tolist()]
    longest = max(map(len, hulls))
    padded = [[*hull, *[hull[-1]] * (longest - len(hull))] for hull in hulls]
    corners: Indices = np.array(padded, dtype=np.intp).reshape(*points.shape[:-2], longest)
    return Outline(_of_corners(points, corners), corners)


def edge_distances(shape: Outline, points: Points2) -> EdgeDistances:
    """Return the signed distance of (n, 2) image points to the outline: the least over its edges, positive inside.

    Outside near a vertex this is the distance to the farther edge's line, an under-estimate that is right where it matters,
    within a few pixels of the edges.
    """
    start, tangent, inward = shape.vertices, shape.tangents, shape.inward
    offset, origin = np.sum(start * inward, axis=1), np.sum(start * tangent, axis=1)
    x, y = np.ascontiguousarray(points[:, 0]), np.ascontiguousarray(points[:, 1])
    # Edge by edge on columns, in place: an argmin over an (n, k) array takes several times as long.
    distance, edge = np.full(len(x), np.inf), np.zeros(len(x), dtype=np.intp)
    signed, rest = np.empty(len(x)), np.empty(len(x))
    for k, (across, down, level) in enumerate(zip(*inward.T.tolist(), offset.tolist(), strict=True)):
        np.multiply(x, across, out=signed)
        np.multiply(y, down, out=rest)
        signed += rest
        signed -= level
        np.copyto(edge, k, where=signed < distance)
        np.minimum(distance, signed, out=distance)
    along = tangent[:, 0].take(edge) * x + tangent[:, 1].take(edge) * y - origin.take(edge)
    along /= shape.lengths.take(edge)
    return EdgeDistances(distance, edge, np.clip(along, 0.0, 1.0, out=along))


def edge_jacobian(box: Box, shape: Outline, distances: EdgeDistances) -> Array:
    """Return the (n, 9) derivative of each signed distance with respect to a step of the box (:meth:`Box.moved`)."""
    at_start, at_end = edge_end_jacobians(box, shape)
    share = distances.along[:, None]
    return np.asarray((1 - share) * at_start[distances.edge] + share * at_end[distances.edge])


def edge_end_jacobians(box: Box, shape: Outline) -> tuple[Array, Array]:
    """Return the derivatives (k, 9) of distances to each edge with the foot point at its start, and at its end.

    In between they are mixed linearly: an edge moves with the two corners that carry it. Takes a stack.
    """
    corner_steps = _of_corners(_corner_jacobian(box), shape.corners)
    inward = shape.inward[..., None, :]
    at_start = -(inward @ corner_steps)[..., 0, :]
    at_end = -(inward @ following(corner_steps, axis=-3))[..., 0, :]
    return np.asarray(at_start), np.asarray(at_end)


def edge_cosines(box: Box, shape: Outline) -> Array:
    """Return the (k,) cosine of the angle of incidence on the visible face that each edge of the outline bounds, at its middle.

    An edge of the outline parts a face turned to the camera from one turned away; 0 where rounding finds neither. Takes a stack.
    """
    camera = (-box.box_to_camera[..., :3, :3].mT @ box.box_to_camera[..., :3, 3:]).mT  # (1, 3)
    start, end = CORNERS[shape.corners], CORNERS[following(shape.corners, axis=-1)]
    sight = camera - (start + end) / 2 * box.extents[..., None, :]
    sight /= np.linalg.norm(sight, axis=-1, keepdims=True)
    normals, extents = PLANE_NORMALS[:FLOOR].T, PLANE_EXTENTS[:FLOOR]
    side, facing = extents.sum(axis=1), camera @ normals > box.extents[..., None, :] @ extents.T
    on_face = (start @ normals == side) & (end @ normals == side) & facing  # [edges, faces]
    return np.asarray(np.clip(np.where(on_face, sight @ normals, 0.0).max(axis=-1), 0.0, 1.0))


def following(values: NDArray[_Number], axis: int) -> NDArray[_Number]:
    """Return for each of k values around an outline, along ``axis``, the next one: ``np.roll``, in a tenth of its time."""
    first = values.swapaxes(0, axis)
    return np.concatenate((first[1:], first[:1])).swapaxes(0, axis)


def _project(points: Array) -> Array:
    return np.asarray(points[..., :2] / np.maximum(points[..., 2:], NEAR))


def _of_corners(values: Array, corners: Indices) -> Array:
    """Return (k, ...), of (8, ...) values of corners those asked for; of stacks too."""
    return values[corners] if corners.ndim == 1 else values[np.arange(len(corners))[:, None], corners]


def _corner_jacobian(box: Box) -> Array:
    """Return the (8, 2, 9) derivative of the projected corners with respect to a step of the box."""
    rotation, camera = box.box_to_camera[..., None, :3, :3], box.corners()
    steps = np.empty((*camera.shape, 9))
    steps[..., :3] = rotation @ cross_matrix(-CORNERS * box.extents[..., None, :])
    steps[..., 3:6] = rotation
    steps[..., 6:] = rotation * CORNERS[:, None, :]
    depth = np.maximum(camera[..., 2], NEAR)
    projection = np.zeros((*depth.shape, 2, 3))
    projection[..., 0, 0] = projection[..., 1, 1] = 1 / depth
    projection[..., 2] = -camera[..., :2] / depth[..., None] ** 2
    return np.asarray(projection @ steps)


def _hull(points: list[tuple[float, float]]) -> list[int]:
    """Return the indices of the hull's points; of plain numbers, for of eight points arrays take ten times as long."""
    order = sorted(range(len(points)), key=points.__getitem__)
    return [*_half_hull(points, order), *_half_hull(points, order[::-1])]


def _half_hull(points: list[tuple[float, float]], order: list[int]) -> list[int]:
    """Return one chain of the convex hull, without its last vertex."""
    chain: list[int] = []
    for index in order:
        while len(chain) > 1 and _turn(points[chain[-2]], points[chain[-1]], points[index]) <= 0:
            chain.pop()
        chain.append(index)
    return chain[:-1]


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

"""Rays against a box and its floor: where each ray meets them, under what angle, and how that moves with the box.

Rays start at the camera. Arrays are kept as separate x, y, z columns (structure of arrays): the slab test then runs about ten
times faster than on (n, 3) rows. All but the factors take stacks of boxes, with rays in common, (n, 3), or each its own.
"""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Indices, Mask, Points
from viewgain.box._box import FLOOR, PLANE_EXTENTS, PLANE_NORMALS, Box

SLIVER = 0.02
"""A face seen under a smaller sine than this (1.1 degrees) is under a pixel wide: rays are taken past it to the next face."""

_FACES = tuple((int(np.flatnonzero(normal)[0]), float(normal.sum())) for normal in PLANE_NORMALS[:FLOOR])
"""Axis of the box that each face is perpendicular to, and which way along it the face looks."""
_ACROSS = tuple(tuple(int(k) for k in np.flatnonzero(normal == 0)) for normal in PLANE_NORMALS)
"""The two axes of the box that each plane contains."""
_BASES = np.array([
    [
        np.concatenate([np.cross(np.eye(3)[across[0]], normal), np.zeros(6)]),
        np.concatenate([np.cross(np.eye(3)[across[1]], normal), np.zeros(6)]),
        np.concatenate([np.zeros(3), normal, extents]),
    ]
    for across, normal, extents in zip(_ACROSS, PLANE_NORMALS, PLANE_EXTENTS, strict=True)
])  # fmt: skip
"""(6, 3, 9) how the range on each plane follows a step of the box, per unit of its two coordinates there and by itself."""


@dataclass(frozen=True, slots=True)
class Hits:
    """Where rays meet a plane of the box."""

    ranges: Array
    """(n,) distance along the ray, metres; inf where the plane is not in front."""
    planes: Indices
    """(n,) index of the plane (the five faces, then the floor)."""
    cosine: Array
    """(n,) cosine of the angle of incidence, in [0, 1]."""

    def take(self, chosen: Indices) -> "Hits":
        """Return a subset of the rays."""
        return Hits(self.ranges[chosen], self.planes[chosen], self.cosine[chosen])

    def followed_by(self, others: "Hits") -> "Hits":
        """Return these, then the others."""
        return Hits(
            np.concatenate([self.ranges, others.ranges], axis=-1),
            np.concatenate([self.planes, others.planes], axis=-1),
            np.concatenate([self.cosine, others.cosine], axis=-1),
        )


def box_hits(box: Box, directions: Points) -> Hits:
    """Return where (n, 3) unit rays from the camera meet the box's visible faces, extended beyond their edges.

    The farthest of the visible faces' planes is the entry point of a ray that hits, and continues it smoothly for one that
    passes just beside; :func:`entry_mask` tells which is which. No visible face (camera inside) gives inf.
    """
    origin, along = _in_box_frame(box, directions)
    heights = origin @ PLANE_NORMALS[:FLOOR].T - box.extents @ PLANE_EXTENTS[:FLOOR].T
    visible = heights > SLIVER * np.linalg.norm(origin, axis=-1, keepdims=True)
    heights[~visible] = -np.inf  # never the farthest
    ranges = np.full(along[..., 0, :].shape, -np.inf)
    planes = np.zeros(ranges.shape, dtype=np.intp)
    cosine = np.zeros(ranges.shape)
    for face, (axis, sign) in enumerate(_FACES):
        if not visible[..., face].any():
            continue
        approach = along[..., axis, :] * -sign
        distance = heights[..., face, None] / np.maximum(approach, 1e-9)
        farther = (distance > ranges) & (approach > 1e-9)
        np.copyto(ranges, distance, where=farther)
        np.copyto(planes, face, where=farther)
        np.copyto(cosine, approach, where=farther)
    ranges[np.isneginf(ranges)] = np.inf
    return Hits(ranges, planes, cosine)


def floor_hits(box: Box, directions: Points) -> Hits:
    """Return where (n, 3) unit rays from the camera meet the box's floor; inf above the horizon."""
    normal = box.box_to_camera[..., :3, 2:3]
    height = -(normal.mT @ box.box_to_camera[..., :3, 3:])[..., 0]
    approach = -(directions @ normal)[..., 0]
    ranges = np.where(approach > 1e-6, height / np.maximum(approach, 1e-6), np.inf)
    return Hits(ranges, np.full(ranges.shape, FLOOR, dtype=np.intp), np.maximum(approach, 0.0))


def entry_mask(box: Box, directions: Points) -> Mask:
    """Return the (n,) mask of unit rays from the camera that hit the box (the slab test)."""
    origin, along = _in_box_frame(box, directions)
    low, high = np.array([-0.5, -0.5, 0.0]) * box.extents - origin, np.array([0.5, 0.5, 1.0]) * box.extents - origin
    near, far = np.full(along[..., 0, :].shape, 1e-9), np.full(along[..., 0, :].shape, np.inf)
    for axis in range(3):
        with np.errstate(divide="ignore"):
            inverse = 1.0 / np.where(np.abs(along[..., axis, :]) < 1e-12, 1e-12, along[..., axis, :])
        first, second = low[..., axis, None] * inverse, high[..., axis, None] * inverse
        near = np.maximum(near, np.minimum(first, second))
        far = np.minimum(far, np.maximum(first, second))
    return np.asarray(near < far)


def range_jacobian(box: Box, directions: Points, hits: Hits) -> Array:
    """Return the (n, 9) derivative of each hit's range with respect to a step of the box (:meth:`Box.moved`).

    The plane n . x = e . extents, moved by rotation w and translation t of the box's frame, meets the ray at p when
    dr = (e . d_extents + n . t + (p x n) . w) / (n . v), with p and the direction v in the box's frame (ours).
    """
    origin, along = _in_box_frame(box, directions)
    normals = PLANE_NORMALS[hits.planes]
    x, y, z = (origin[..., k, None] + hits.ranges * along[..., k, :] for k in range(3))
    a, b, c = normals[..., 0], normals[..., 1], normals[..., 2]
    jacobian = np.empty((*hits.ranges.shape, 9))
    jacobian[..., 0], jacobian[..., 1], jacobian[..., 2] = y * c - z * b, z * a - x * c, x * b - y * a
    jacobian[..., 3:6] = normals
    jacobian[..., 6:] = PLANE_EXTENTS[hits.planes]
    return np.asarray(jacobian / -np.maximum(hits.cosine, 1e-6)[..., None])


def range_jacobian_factors(box: Box, directions: Points, hits: Hits) -> list[tuple[Indices, Array, Array]]:
    """Return :func:`range_jacobian` in factors, plane by plane: which rays meet it, (3, m) and (3, 9), whose product it is.

    On a plane with normal along axis k of the box only the two other coordinates of the point vary, so the rows span three
    dimensions.
    """
    origin, along = _in_box_frame(box, directions)
    scale = -1 / np.maximum(hits.cosine, 1e-6)
    far = hits.ranges * scale
    factors = []
    for plane in np.flatnonzero(np.bincount(hits.planes)):
        mine = np.flatnonzero(hits.planes == plane)
        local = np.empty((3, len(mine)))
        for row, k in enumerate(_ACROSS[plane]):
            local[row] = origin[k] * scale[mine] + along[k, mine] * far[mine]
        local[2] = scale[mine]
        factors.append((mine, local, _BASES[plane]))
    return factors


def _in_box_frame(box: Box, directions: Points) -> tuple[Array, Array]:
    """Return the camera's centre (3,) and the ray directions (3, n) in the box's frame."""
    rotation = box.box_to_camera[..., :3, :3].mT
    return (-rotation @ box.box_to_camera[..., :3, 3:])[..., 0], np.asarray(rotation @ directions.mT)

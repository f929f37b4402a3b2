"""The two constraints that a time-of-flight camera puts on a view of a box: incidence on its faces, nearness to the image border.

Source: the paper's third contribution names both and gives no formula; these are ours. The one definition of either: the flags
``grazing`` and ``cut``, the open extents of cut boxes, the prediction of views and the JSON read it here.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Indices, Points2
from viewgain.box._box import CORNERS, FLOOR, PLANE_EXTENTS, PLANE_NORMALS, Box
from viewgain.box._silhouette import NEAR, following, outline

BORDER_PX = 1.0
"""An outline that comes this close to the image border counts as being on it, pixels."""
_PER_EDGE = 32
_FROM_VERTEX = np.linspace(0.0, 1.0, _PER_EDGE, endpoint=False)
"""(32,) places along an edge of the outline: from vertex to vertex, so that an extreme point is never missed."""
_END_TO_END = np.linspace(0.0, 1.0, _PER_EDGE)
"""(32,) places along an edge of the box."""


def _edges() -> Indices:
    """Return (8, 4): two faces that share an edge, and the corners at its ends. The four edges on the floor are no two faces'."""
    normals, extents = PLANE_NORMALS[:FLOOR], PLANE_EXTENTS[:FLOOR]
    on_face = np.isclose(normals @ CORNERS.T, extents.sum(axis=1, keepdims=True))
    pairs = [(one, other, np.flatnonzero(on_face[one] & on_face[other])) for one in range(FLOOR) for other in range(one)]
    return np.array([(one, other, *ends) for one, other, ends in pairs if len(ends) == 2])


_EDGES = _edges()


@dataclass(frozen=True, slots=True, eq=False)
class Constraints:
    """How a camera sees a box, as far as time of flight cares."""

    incidence: Array
    """(5,) angle between each face's normal and the line of sight to its centre, radians; NaN for a face turned away."""
    border: float
    """Share of the outline's length in the image that lies on the image border or beyond it, 0 to 1."""

    @property
    def cut(self) -> bool:
        """Whether the box leaves the image."""
        return self.border > 0


def constraints(
    box: Box, to_pixels: Callable[[Points2], Points2], size: tuple[int, int], margin: float = BORDER_PX
) -> Constraints:
    """Return incidence and border share of ``box`` as a camera sees it.

    Args:
        box: The box, in the camera's frame.
        to_pixels: The camera: (n, 2) normalised image points to (n, 2) pixel coordinates (u, v).
        size: (width, height) of the image, pixels.
        margin: How close to the border counts as on it, pixels.

    Returns:
        A border share of 1 for a box that reaches behind the camera.
    """
    return Constraints(incidence(box), float(border_share(box, to_pixels, size, margin)))


def incidence(box: Box) -> Array:
    """Return the (5,) angle of incidence at the centre of each face, radians; NaN for a face turned away from the camera.

    Takes a stack.
    """
    normals = PLANE_NORMALS[:FLOOR]
    centres = PLANE_EXTENTS[:FLOOR] * normals.sum(axis=1, keepdims=True) * box.extents[..., None, :]
    centres[..., 2] += np.where(normals[:, 2] == 0, box.extents[..., 2:] / 2, 0.0)
    seen = box.in_camera(centres)
    cosine = -np.sum(seen * (normals @ box.box_to_camera[..., :3, :3].mT), axis=-1) / np.linalg.norm(seen, axis=-1)
    return np.asarray(np.arccos(np.where(cosine > 0, np.minimum(cosine, 1.0), np.nan)))


def border_share(box: Box, to_pixels: Callable[[Points2], Points2], size: tuple[int, int], margin: float = BORDER_PX) -> Array:
    """Return the share of the outline's length on the image border or beyond it; arguments as :func:`constraints`, or a stack."""
    start = outline(box).vertices
    side = following(start, axis=-2) - start
    along = start[..., None, :] + _FROM_VERTEX[:, None] * side[..., None, :]  # (k, 32, 2)
    outside = (clearance(to_pixels(along.reshape(-1, 2)), size) < margin).reshape(along.shape[:-1])
    length = np.linalg.norm(side, axis=-1)
    share = np.sum(length * outside.mean(axis=-1), axis=-1) / np.maximum(length.sum(axis=-1), 1e-12)
    return np.where(np.any(box.corners()[..., 2] <= NEAR, axis=-1), 1.0, share)


def edges_shown(box: Box, to_pixels: Callable[[Points2], Points2], size: tuple[int, int], margin: float = BORDER_PX) -> Array:
    """Return the (5, 5) share of the edge between two faces that lies in the image, whether or not the box itself hides it.

    The diagonal and pairs of opposite faces, which share no edge, are 0; so is an edge that is behind the camera. Arguments as
    :func:`constraints`, or a stack.
    """
    one, other, start, end = _EDGES.T
    corners = box.corners()
    in_front = (corners[..., start, 2] > NEAR) & (corners[..., end, 2] > NEAR)
    image = corners[..., :2] / np.maximum(corners[..., 2:], NEAR)
    first, last = image[..., start, None, :], image[..., end, None, :]
    line = first + _END_TO_END[:, None] * (last - first)  # (8, 32, 2)
    outside = (clearance(to_pixels(line.reshape(-1, 2)), size) < margin).reshape(line.shape[:-1])
    shown = np.zeros((*in_front.shape[:-1], FLOOR, FLOOR))
    shown[..., one, other] = shown[..., other, one] = np.where(in_front, 1 - outside.mean(axis=-1), 0.0)
    return shown


def clearance(pixels: Points2, size: tuple[int, int]) -> Array:
    """Return how far (..., 2) pixel coordinates lie inside the border of a (width, height) image, pixels; negative beyond it."""
    u, v = pixels[..., 0], pixels[..., 1]
    return np.asarray(np.min([u + 0.5, v + 0.5, size[0] - 0.5 - u, size[1] - 0.5 - v], axis=0))

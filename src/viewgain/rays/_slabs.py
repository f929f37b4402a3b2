"""Rays against boxes and planes by the slab test, on numpy arrays and torch tensors alike.

Everything is in the camera's frame, so every ray starts at the origin and the directions of a camera's pixels are made once.
The three components of the directions are separate arrays: that is several times faster than rows of (n, 3). A number of a body
(an element of its rotation, a half side) is a float for one scene, or an array that broadcasts against the rays for a batch of
scenes.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from viewgain.arrays import Pose
from viewgain.box import Box
from viewgain.geometry import Plane, inverse

Tensor: TypeAlias = Any
"""A numpy array or a torch tensor."""
Triple: TypeAlias = tuple[Tensor, Tensor, Tensor]

FACES_PER_BOX = 6
"""Surfaces of a box in index order: +x, -x, +y, -y, top, bottom of its own frame."""
_NEAREST = 1e-9
"""A surface nearer than this is taken to be the camera's own place, metres."""
_TINY = 1e-30
"""Added to a direction's component: leaves all but an exact zero as it is, and makes the division safe, also in float32."""


@dataclass(frozen=True, slots=True, eq=False)
class BoxBody:
    """A box as the slab test wants it: where the camera is in the box's centred frame."""

    axes: tuple[Triple, Triple, Triple]
    """The box's x, y and z axes, each by its components in the camera's frame."""
    camera: Triple
    """The camera in the frame of the box's centre, metres."""
    half: Triple
    """Half the side lengths, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaneBody:
    """A plane, seen only from the side its normal points to."""

    normal: Triple
    """Unit normal, camera frame."""
    height: Tensor
    """Height of the camera above it, metres; at most 0 for a camera behind it, which sees nothing of it."""


def box_body(box: Box) -> BoxBody:
    """Return a box, given in the camera's frame, ready for :func:`cast_slabs`."""
    rotation = box.box_to_camera[:3, :3]
    x, y, z = rotation.T.tolist()
    u, v, w = (-rotation.T @ box.centre).tolist()
    a, b, c = (box.extents / 2).tolist()
    return BoxBody((tuple(x), tuple(y), tuple(z)), (u, v, w), (a, b, c))


def plane_body(plane: Plane, camera_to_world: Pose) -> PlaneBody:
    """Return a plane of the world as the camera at ``camera_to_world`` sees it."""
    a, b, c = (camera_to_world[:3, :3].T @ plane.normal).tolist()
    return PlaneBody((a, b, c), float(plane.height(camera_to_world[:3, 3])))


def bodies_in_camera(
    boxes: Sequence[Box], planes: Sequence[Plane], camera_to_world: Pose
) -> tuple[list[BoxBody], list[PlaneBody]]:
    """Return boxes and planes of the world as a camera sees them."""
    world_to_camera = inverse(camera_to_world)
    return [box_body(box.in_frame(world_to_camera)) for box in boxes], [plane_body(plane, camera_to_world) for plane in planes]


def cast_slabs(
    boxes: Sequence[BoxBody], planes: Sequence[PlaneBody], directions: Triple, *, first_plane: int | None = None
) -> tuple[Tensor, Tensor, Tensor]:
    """Return what unit rays from the camera meet first among boxes and planes.

    Args:
        boxes: Boxes; box b owns the surfaces 6 b to 6 b + 5. A box that holds the camera is not seen.
        planes: Planes; plane p is surface ``first_plane + p``.
        directions: Three arrays of one shape: the components of the unit directions, camera frame.
        first_plane: Surface of the first plane; by default the one after the last box's.

    Returns:
        Ranges (metres; inf for a miss), surfaces (int32; -1 for a miss) and cosines of incidence (0 for a miss), each of the
        directions' shape, in the directions' precision, on their device.

    Source:
        Kay and Kajiya (1986), with the centred form near, far = -o/d -+ |half/d|.
    """
    xp = _namespace(directions[0])
    x, y, z = directions
    ranges = xp.full_like(x, float("inf"))
    surfaces = xp.full_like(x, -1, dtype=xp.int32)
    cosine = xp.zeros_like(x)
    start = FACES_PER_BOX * len(boxes) if first_plane is None else first_plane
    for index, plane in enumerate(planes):
        a, b, c = plane.normal
        approach = -(a * x + b * y + c * z)
        distance = plane.height / xp.where(approach > _NEAREST, approach, xp.full_like(x, _TINY))
        nearer = (approach > _NEAREST) & (distance > _NEAREST) & (distance < ranges)
        ranges = xp.where(nearer, distance, ranges)
        surfaces = xp.where(nearer, xp.full_like(surfaces, start + index), surfaces)
        cosine = xp.where(nearer, approach, cosine)
    for index, box in enumerate(boxes):
        chosen, rays, limit = _around(box, directions, ranges)
        x, y, z = rays
        along = tuple(axis[0] * x + axis[1] * y + axis[2] * z + _TINY for axis in box.axes)
        entry, leave = [], []
        for place, half, d in zip(box.camera, box.half, along, strict=True):
            per_metre = 1.0 / d
            middle, reach = per_metre * (-place), abs(per_metre) * half
            entry.append(middle - reach)
            leave.append(middle + reach)
        near = xp.maximum(xp.maximum(entry[0], entry[1]), entry[2])
        far = xp.minimum(xp.minimum(leave[0], leave[1]), leave[2])
        hit = (near < far) & (near > _NEAREST) & (near < limit)
        on = [values[hit] for values in (near, *entry[:2], *along)]
        face, facing = _face(xp, *on)
        at = hit if chosen is None else chosen[hit]
        ranges[at] = on[0]
        surfaces[at] = face + FACES_PER_BOX * index
        cosine[at] = facing
    return ranges, surfaces, cosine


def _around(box: BoxBody, directions: Triple, ranges: Tensor) -> tuple[Tensor | None, Triple, Tensor]:
    """Return which rays pass through the ball around a box, as indices, with those rays and their ranges so far.

    None, and all rays, for a batch of scenes and for a camera within the ball.
    """
    if not isinstance(box.half[0], float) or directions[0].ndim != 1:
        return None, directions, ranges
    square = sum(place * place for place in box.camera)
    sine_square = sum(half * half for half in box.half) / square
    if sine_square >= 1:
        return None, directions, ranges
    towards = [-sum(place * axis[k] for place, axis in zip(box.camera, box.axes, strict=True)) / square**0.5 for k in range(3)]
    x, y, z = directions
    inside = towards[0] * x + towards[1] * y + towards[2] * z > (1 - sine_square) ** 0.5
    chosen = inside.nonzero() if not isinstance(inside, np.ndarray) else np.flatnonzero(inside)
    chosen = chosen.reshape(-1)
    return chosen, (x[chosen], y[chosen], z[chosen]), ranges[chosen]


def _face(xp: Any, near: Tensor, x_entry: Tensor, y_entry: Tensor, x: Tensor, y: Tensor, z: Tensor) -> tuple[Tensor, Tensor]:
    """Return which face rays enter by (+ faces even, - faces odd) and the cosine of incidence on it."""
    by_x, by_y = near == x_entry, near == y_entry
    along = xp.where(by_x, x, xp.where(by_y, y, z))
    axis = xp.where(by_x, xp.zeros_like(near), xp.where(by_y, xp.ones_like(near), xp.full_like(near, 2.0)))
    face = 2 * axis + xp.where(along > 0, xp.ones_like(near), xp.zeros_like(near))
    return face.astype(np.int32) if isinstance(face, np.ndarray) else face.to(xp.int32), abs(along)


def _namespace(array: Tensor) -> Any:
    """Return numpy, or torch for a tensor: whoever holds a tensor has imported it."""
    return np if isinstance(array, np.ndarray) else sys.modules["torch"]

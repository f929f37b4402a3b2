"""Rays that stand for the pixels of a candidate view, on the faces of the box and on the floor around it.

The same number for every box, so that many views are sampled in one go; a ray that does not count weighs nothing.
"""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Mask, Points, Points2
from viewgain.box import FLOOR, PLANE_NORMALS, Box, Hits, floor_hits, outline
from viewgain.camera import Sensor

_PER_SIDE = 6
PER_FACE = _PER_SIDE**2
"""Rays to each face."""
_FLOOR_SAMPLES = 12
_FACE_OF = np.repeat(np.arange(FLOOR), PER_FACE)
"""(m,) the face of each sample."""
_LEAST_COSINE = 0.02
"""Faces seen under less are not turned to the camera."""


def _grid_on_faces() -> Points:
    """Return (m, 3) samples on the faces of a cube of side 1 around the origin."""
    cell = (np.arange(_PER_SIDE) + 0.5) / _PER_SIDE - 0.5
    across = np.stack(np.meshgrid(cell, cell), axis=-1).reshape(-1, 2)
    grid = np.repeat(PLANE_NORMALS[:FLOOR] / 2, PER_FACE, axis=0)
    for face, normal in enumerate(PLANE_NORMALS[:FLOOR]):
        grid[np.ix_(np.flatnonzero(face == _FACE_OF), np.flatnonzero(normal == 0))] = across
    return grid


_ON_FACES = _grid_on_faces()


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Rays in n views, m in each."""

    rays: Points
    """(n, m, 3) unit vectors."""
    hits: Hits
    """(n, m) where they hit; finite."""
    weight: Array
    """(n, m) how many pixels each stands for."""


def face_samples(box: Box, sensor: Sensor) -> Samples:
    """Return rays to a grid on each face, ``PER_FACE`` on one after the other, of a stack of boxes."""
    extents = box.extents[:, None]
    points = box.in_camera(_ON_FACES * extents + extents * [0.0, 0.0, 0.5])
    ranges = np.linalg.norm(points, axis=-1)
    rays = points / ranges[..., None]
    normals = PLANE_NORMALS[:FLOOR] @ box.box_to_camera[:, :3, :3].mT
    cosine = -np.einsum("nmk,nmk->nm", rays, normals[:, _FACE_OF])
    area = np.prod(np.where(PLANE_NORMALS[:FLOOR] == 0, extents, 1.0), axis=-1)[:, _FACE_OF] / PER_FACE
    solid = area * np.maximum(cosine, 0.0) / ranges**2
    pixels = solid * sensor.intrinsics.fx * sensor.intrinsics.fy / np.maximum(rays[..., 2], 0.1) ** 3
    weight = pixels * (1 - sensor.loss(cosine)) * in_view(rays, ranges, sensor) * (cosine > _LEAST_COSINE)
    return Samples(rays, Hits(ranges, np.broadcast_to(_FACE_OF, ranges.shape), cosine), weight)


def floor_samples(box: Box, sensor: Sensor) -> Samples:
    """Return rays to the floor on a grid over the image around the box, of a stack of boxes."""
    camera = sensor.intrinsics
    last = np.array([camera.width - 1, camera.height - 1])
    corners = np.clip(camera.project(box.corners()), 0, last)
    low, high = np.maximum(corners.min(axis=1) - 16, 0), np.minimum(corners.max(axis=1) + 16, last)
    places = np.linspace(low, high, _FLOOR_SAMPLES, axis=1)
    pixels = np.empty((len(low), _FLOOR_SAMPLES, _FLOOR_SAMPLES, 2))
    pixels[..., 0], pixels[..., 1] = places[:, None, :, 0], places[:, :, None, 1]
    image = camera.undistort((pixels.reshape(len(low), -1, 2) - (camera.cx, camera.cy)) / (camera.fx, camera.fy))
    rays = unit(image)
    hits = floor_hits(box, rays)
    each = np.prod(high - low, axis=1, keepdims=True) / _FLOOR_SAMPLES**2
    in_range = hits.ranges < sensor.range_max
    weight = each * outline(box).outside(image) * (1 - sensor.loss(hits.cosine)) * in_range
    return Samples(rays, Hits(np.where(in_range, hits.ranges, sensor.range_max), hits.planes, hits.cosine), weight)


def in_view(rays: Points, ranges: Array, sensor: Sensor) -> Mask:
    """Return which of (..., 3) unit rays a camera has pixels for, where what they meet is in range."""
    camera = sensor.intrinsics
    ahead = rays[..., 2] > 0.05
    pixels = camera.project(np.where(ahead[..., None], rays, [0.0, 0.0, 1.0]))
    u, v = pixels[..., 0], pixels[..., 1]
    inside = (u > 0) & (v > 0) & (u < camera.width - 1) & (v < camera.height - 1) & ahead
    return np.asarray(inside & (ranges > sensor.range_min) & (ranges < sensor.range_max))


def unit(image: Points2) -> Points:
    """Return the (..., 3) unit rays to (..., 2) normalised image points."""
    rays = np.ones((*image.shape[:-1], 3))
    rays[..., :2] = image
    return np.asarray(rays / np.linalg.norm(rays, axis=-1, keepdims=True))

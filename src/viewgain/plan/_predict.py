"""What a camera at a given pose would learn about a box: the expectation of the measuring likelihood's information.

The same two kinds of evidence as in measuring (docs/next_view.md): every face in view is a cloud of range readings, every stretch
of outline in front of a farther background is a row of pixels that hit or miss. Both are summed on a coarse grid, weighted by
how many pixels each sample stands for, so a prediction takes about a millisecond.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from viewgain.arrays import Array, Mask, Points, Points2, Pose
from viewgain.box import (
    FACES,
    FLOOR,
    PARAMETERS,
    PLANE_NORMALS,
    Box,
    EdgeDistances,
    Hits,
    box_hits,
    constraints,
    edge_cosines,
    edge_distances,
    edge_jacobian,
    floor_hits,
    outline,
    range_jacobian,
)  # fmt: skip
from viewgain.camera import Intrinsics, Sensor
from viewgain.geometry import inverse, transform
from viewgain.measure import SYSTEMATIC, Knowledge, common_shift, without_edge_bias

EDGE_INFORMATION = 1.81
"""Integral of phi^2 / (Phi (1 - Phi)): Fisher information about a probit edge, per pixel of edge length and unit softness."""
EDGE_SOFTNESS = 0.5
"""Blur of an outline in the sharpest fit, pixels."""
UNMIXED = 0.7
"""Share of the pixels on an outline that are not mixed of foreground and background, and so tell where it is."""
MIN_FACE_PIXELS = 25
"""A face counts as seen if at least this many returns are expected from it."""
_KEPT = 1024
"""Predictions that are kept: policy, model and judge of one decision ask about the same boxes from the same places."""
_FACE_SAMPLES = 6
_EDGE_SAMPLES = 12
_FLOOR_SAMPLES = 12
_FACE_OF = np.repeat(np.arange(FLOOR), _FACE_SAMPLES**2)
"""(n,) the face of each sample."""


def _grid_on_faces() -> Points:
    """Return (n, 3) samples on the faces of a cube of side 1 around the origin."""
    cell = (np.arange(_FACE_SAMPLES) + 0.5) / _FACE_SAMPLES - 0.5
    across = np.stack(np.meshgrid(cell, cell), axis=-1).reshape(-1, 2)
    grid = np.repeat(PLANE_NORMALS[:FLOOR] / 2, _FACE_SAMPLES**2, axis=0)
    for face, normal in enumerate(PLANE_NORMALS[:FLOOR]):
        grid[np.ix_(np.flatnonzero(face == _FACE_OF), np.flatnonzero(normal == 0))] = across
    return grid


_ON_FACES = _grid_on_faces()


Samples = tuple[Points, Hits, Array]
"""(n, 3) rays, where they hit, and (n,) how many pixels each stands for."""


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """How a candidate camera would see one face."""

    name: str
    """Which face: +x, -x, +y, -y (box frame) or top."""
    incidence: float
    """Angle of incidence at the face's centre, radians."""
    returns: float
    """Expected number of returns."""


@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """What one candidate view is expected to show and to teach."""

    knowledge: Knowledge
    """Expected information and systematic gradient, box frame."""
    sights: tuple[Sight, ...]
    """Faces turned towards the camera."""
    border: float
    """Share of the outline that would lie on the image border or beyond it (viewgain.box.Constraints)."""

    @property
    def cut(self) -> bool:
        """Whether the outline would leave the image."""
        return self.border > 0


def predict(box: Box, camera_to_current: Pose, sensor: Sensor, noise: float) -> Prediction:
    """Return what ``sensor`` at a candidate pose would learn about ``box``.

    Args:
        box: The box as now believed, in the present camera's frame.
        camera_to_current: (4, 4) candidate pose in the present camera's frame.
        sensor: The camera.
        noise: Its noise on this scene as a multiple of the data sheet's.

    Returns:
        Information zero and no faces where the box lies behind the camera or out of range. Its arrays are read only.
    """
    placed = inverse(camera_to_current) @ box.box_to_camera
    return _predicted(placed.tobytes(), np.asarray(box.extents, dtype=float).tobytes(), sensor, noise)


@lru_cache(maxsize=_KEPT)
def _predicted(box_to_camera: bytes, extents: bytes, sensor: Sensor, noise: float) -> Prediction:
    seen = Box(np.frombuffer(box_to_camera).reshape(4, 4), np.frombuffer(extents))
    if np.any(seen.corners()[:, 2] < 0.05):
        return Prediction(_known(np.zeros((PARAMETERS, PARAMETERS)), np.zeros((PARAMETERS, SYSTEMATIC))), (), 1.0)
    camera = sensor.intrinsics
    seen_as = constraints(seen, to_pixels(camera), (camera.width, camera.height))
    rays, hits, weight = _face_samples(seen, sensor)
    returns = np.bincount(hits.planes, weight, minlength=FLOOR)
    sights = tuple(Sight(FACES[face], float(seen_as.incidence[face]), float(returns[face])) for face in np.unique(hits.planes))
    # As in measuring: a face that loses its returns is little believed.
    believed = rays, hits, weight * (1 - sensor.loss(hits.cosine))
    ranges, gradient = _range_information(seen, believed, _floor_samples(seen, sensor), sensor, noise)
    edges, shift = _edge_information(seen, sensor, noise)
    return Prediction(_known(ranges + edges, np.column_stack([gradient, shift])), sights, seen_as.border)


def forget_predictions() -> None:
    """Forget the predictions that are kept: for whoever times one policy after another."""
    _predicted.cache_clear()


def _known(information: Array, systematic: Array) -> Knowledge:
    """Return what many will share, so that none can change it."""
    information.flags.writeable = systematic.flags.writeable = False
    return Knowledge(information, systematic)


def to_pixels(camera: Intrinsics) -> Callable[[Points2], Points2]:
    """Return the map from (n, 2) normalised image points to (n, 2) pixels."""
    return lambda image: camera.project(np.column_stack([image, np.ones(len(image))]))


def _range_information(box: Box, faces: Samples, floor: Samples, sensor: Sensor, noise: float) -> tuple[Array, Array]:
    """Return the evidence of range readings, J^T J / sigma^2, and its systematic gradient."""
    hits, weight = faces[1].followed_by(floor[1]), np.append(faces[2], floor[2])
    jacobian = range_jacobian(box, np.concatenate([faces[0], floor[0]]), hits)
    weighted = jacobian.T * (weight / (noise * sensor.range_sigma(hits.ranges, hits.cosine)) ** 2)
    return weighted @ jacobian, weighted @ sensor.systematic_shapes(hits.ranges)


def _edge_information(box: Box, sensor: Sensor, noise: float) -> tuple[Array, Array]:
    """Return the evidence of the outline, and the gradient of one sigma of shift of all its edges.

    The evidence is per pixel of its length, as far as box and background can be told apart there.
    """
    shape = outline(box)
    edges = np.repeat(np.arange(len(shape.vertices)), _EDGE_SAMPLES)
    along = np.tile((np.arange(_EDGE_SAMPLES) + 0.5) / _EDGE_SAMPLES, len(shape.vertices))
    start, end = shape.vertices[edges], shape.vertices[(edges + 1) % len(shape.vertices)]
    image = start + along[:, None] * (end - start)
    length = np.linalg.norm(end - start, axis=1) / _EDGE_SAMPLES * sensor.intrinsics.fx
    rays = _unit(image)
    inward = _unit(image + 1e-4 * (shape.vertices.mean(axis=0) - image))
    near, far = box_hits(box, inward), floor_hits(box, rays)
    sigma = noise * sensor.range_sigma(np.minimum(near.ranges, 10.0), near.cosine)
    with np.errstate(over="ignore"):
        gap = np.clip((far.ranges - near.ranges) / sigma, 0.0, 50.0)
    told_apart = (1 - np.exp(-(gap**2) / 8)) * _in_view(rays, near.ranges, sensor)
    weight = UNMIXED * EDGE_INFORMATION / EDGE_SOFTNESS * length * told_apart
    jacobian = edge_jacobian(box, shape, EdgeDistances(np.zeros(len(edges)), edges, along)) * sensor.intrinsics.fx
    pull = (jacobian * weight[:, None]).reshape(-1, _EDGE_SAMPLES, PARAMETERS).sum(axis=1)
    precision = weight.reshape(-1, _EDGE_SAMPLES).sum(axis=1)
    sigma = sensor.edge_sigma(edge_cosines(box, shape))
    free = without_edge_bias((jacobian.T * weight) @ jacobian, pull, precision, sigma)
    return free, common_shift(pull, precision, sigma)


def _face_samples(box: Box, sensor: Sensor) -> Samples:
    """Return rays to a grid on each face that is turned to the camera."""
    grid = _ON_FACES * box.extents + np.array([0.0, 0.0, box.extents[2] / 2])
    points = transform(box.box_to_camera, grid)
    ranges = np.linalg.norm(points, axis=1)
    rays = points / ranges[:, None]
    cosine = -np.einsum("nk,nk->n", rays, (PLANE_NORMALS @ box.box_to_camera[:3, :3].T)[_FACE_OF])
    area = np.prod(np.where(PLANE_NORMALS[:FLOOR] == 0, box.extents, 1.0), axis=1)[_FACE_OF] / _FACE_SAMPLES**2
    solid = area * np.maximum(cosine, 0.0) / ranges**2
    pixels = solid * sensor.intrinsics.fx * sensor.intrinsics.fy / np.maximum(rays[:, 2], 0.1) ** 3
    weight = pixels * (1 - sensor.loss(cosine)) * _in_view(rays, ranges, sensor)
    used = (cosine > 0.02) & (weight > 0)
    return rays[used], Hits(ranges[used], _FACE_OF[used], cosine[used]), weight[used]


def _floor_samples(box: Box, sensor: Sensor) -> Samples:
    """Return rays to the floor on a grid over the image around the box, and how many pixels each stands for."""
    camera = sensor.intrinsics
    centre = np.clip(camera.project(box.corners()), 0, (camera.width - 1, camera.height - 1))
    low, high = np.maximum(centre.min(axis=0) - 16, 0), np.minimum(centre.max(axis=0) + 16, (camera.width - 1, camera.height - 1))
    u, v = (np.linspace(low[k], high[k], _FLOOR_SAMPLES) for k in (0, 1))
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    image = camera.undistort((pixels - (camera.cx, camera.cy)) / (camera.fx, camera.fy))
    rays = _unit(image)
    hits = floor_hits(box, rays)
    outside = edge_distances(outline(box), image).distance < 0
    each = float(np.prod(high - low)) / len(rays)
    weight = each * outside * (1 - sensor.loss(hits.cosine)) * (hits.ranges < sensor.range_max)
    used = weight > 0
    return rays[used], hits.take(np.flatnonzero(used)), weight[used]


def _in_view(rays: Points, ranges: Array, sensor: Sensor) -> Mask:
    camera = sensor.intrinsics
    u, v = camera.project(np.where(rays[:, 2:] > 0.05, rays, [0.0, 0.0, 1.0])).T
    inside = (u > 0) & (v > 0) & (u < camera.width - 1) & (v < camera.height - 1) & (rays[:, 2] > 0.05)
    return np.asarray(inside & (ranges > sensor.range_min) & (ranges < sensor.range_max))


def _unit(image: Array) -> Points:
    rays = np.column_stack([image, np.ones(len(image))])
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))

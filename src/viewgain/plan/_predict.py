"""What a camera at a given pose would learn about a box: the expectation of the measuring likelihood's information.

The same two kinds of evidence as in measuring (docs/next_view.md): every face in view is a cloud of range readings, every stretch
of outline in front of a farther background is a row of pixels that hit or miss. Both are summed on a coarse grid, weighted by
how many pixels each sample stands for. Many boxes and poses are predicted in one go: alone, most of the time is that of calls.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from viewgain.arrays import Array, Points2, Pose, Poses, Vector
from viewgain.box import (
    FACES,
    FLOOR,
    PARAMETERS,
    Box,
    border_share,
    box_hits,
    edge_cosines,
    edge_end_jacobians,
    floor_hits,
    following,
    incidence,
    outline,
    range_jacobian,
)  # fmt: skip
from viewgain.camera import Intrinsics, Sensor
from viewgain.geometry import inverse
from viewgain.measure import SYSTEMATIC, Knowledge, common_shift, marginal, pose_precision, without_edge_bias
from viewgain.plan._samples import PER_FACE, Samples, face_samples, floor_samples, in_view, unit

EDGE_INFORMATION = 1.81
"""Integral of phi^2 / (Phi (1 - Phi)): Fisher information about a probit edge, per pixel of edge length and unit softness."""
EDGE_SOFTNESS = 0.5
"""Blur of an outline in the sharpest fit, pixels."""
UNMIXED = 0.7
"""Share of the pixels on an outline that are not mixed of foreground and background, and so tell where it is."""
MIN_FACE_PIXELS = 25
"""A face counts as seen if at least this many returns are expected from it."""
_AHEAD = 0.05
"""A box with a corner less far ahead than this lies behind the camera, metres."""
_KEPT = 32
"""Answers that are kept: policy, model and judge of one decision ask about the same boxes from the same places."""
_ALONG = (np.arange(12) + 0.5) / 12
"""(12,) places of samples along an edge of the outline, 0 to 1."""


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


@dataclass(frozen=True, slots=True, eq=False)
class Predictions:
    """What n views are expected to show and to teach. The arrays are read only."""

    knowledge: Knowledge
    """(n, 9, 9) and (n, 9, 5) expected information and systematic gradient, box frame."""
    incidence: Array
    """(n, 5) angle of incidence at each face's centre, radians; NaN for a face turned away."""
    returns: Array
    """(n, 5) expected number of returns from each face."""
    border: Vector
    """(n,) share of the outline on the image border or beyond it."""

    def __getitem__(self, view: int) -> Prediction:
        """Return what one of them is expected to show and to teach."""
        sights = tuple(
            Sight(FACES[face], float(self.incidence[view, face]), float(self.returns[view, face]))
            for face in np.flatnonzero(self.returns[view])
        )
        return Prediction(self.knowledge.take(view), sights, float(self.border[view]))


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
    return predictions(paired((box,), camera_to_current[None])[1], sensor, noise)[0]


def paired(boxes: Sequence[Box], cameras_to_current: Poses) -> tuple[Box, Box]:
    """Return each of b boxes with each of (v, 4, 4) cameras: two stacks of b times v, all cameras of the first box first.

    The one is of the boxes as they are, in the present camera's frame, the other in the frames of the cameras.
    """
    here = Box.stack(boxes).take(np.repeat(np.arange(len(boxes)), len(cameras_to_current)))
    return here, here.in_frame(np.tile(inverse(cameras_to_current), (len(boxes), 1, 1)))


def predictions(seen: Box, sensor: Sensor, noise: float) -> Predictions:
    """Return :func:`predict` of a stack of n boxes, each in the frame of the camera that is to see it."""
    return _predicted(seen.box_to_camera.tobytes(), seen.extents.tobytes(), sensor, noise)


@lru_cache(maxsize=_KEPT)
def _predicted(boxes_to_cameras: bytes, extents: bytes, sensor: Sensor, noise: float) -> Predictions:
    boxes = Box(np.frombuffer(boxes_to_cameras).reshape(-1, 4, 4), np.frombuffer(extents).reshape(-1, 3))
    count = len(boxes.extents)
    information, systematic = np.zeros((count, PARAMETERS, PARAMETERS)), np.zeros((count, PARAMETERS, SYSTEMATIC))
    angles, returns, border = np.full((count, FLOOR), np.nan), np.zeros((count, FLOOR)), np.ones(count)
    ahead = np.flatnonzero(np.all(boxes.corners()[..., 2] >= _AHEAD, axis=1))
    if len(ahead):
        seen, camera = boxes.take(ahead), sensor.intrinsics
        faces, floor = face_samples(seen, sensor), floor_samples(seen, sensor)
        ranges, gradient = _range_information(seen, faces, floor, sensor, noise)
        edges, shift = _edge_information(seen, sensor, noise)
        information[ahead] = ranges + edges
        systematic[ahead] = np.concatenate([gradient, shift[..., None]], axis=-1)
        angles[ahead] = incidence(seen)
        returns[ahead] = faces.weight.reshape(-1, FLOOR, PER_FACE).sum(axis=-1)
        border[ahead] = border_share(seen, to_pixels(camera), (camera.width, camera.height))
    for shared in (information, systematic, angles, returns, border):
        shared.flags.writeable = False
    return Predictions(Knowledge(information, systematic), angles, returns, border)


def forget_predictions() -> None:
    """Forget the predictions that are kept: for whoever times one policy after another."""
    _predicted.cache_clear()


def on_arrival(known: Knowledge, here: Box, seen: Box, pose_sigma: tuple[float, float]) -> Knowledge:
    """Return what of a view's knowledge is left where its pose is known so well: the rest explains errors of two poses.

    Args:
        known: What the view says if its pose is exact.
        here: The box in the present camera's frame, or a stack.
        seen: The box in the frame of the view's camera, or a stack.
        pose_sigma: Standard deviation of a camera pose, metres and radians per axis.
    """
    precision = pose_precision(inverse(seen.box_to_camera), inverse(here.box_to_camera), pose_sigma)
    return Knowledge(*marginal(known.information, known.systematic, precision))


def to_pixels(camera: Intrinsics) -> Callable[[Points2], Points2]:
    """Return the map from (n, 2) normalised image points to (n, 2) pixels."""
    return lambda image: camera.project(np.column_stack([image, np.ones(len(image))]))


def _range_information(box: Box, faces: Samples, floor: Samples, sensor: Sensor, noise: float) -> tuple[Array, Array]:
    """Return the evidence of range readings, J^T J / sigma^2, and its systematic gradient.

    As in measuring a face that loses its returns is little believed.
    """
    hits = faces.hits.followed_by(floor.hits)
    weight = np.concatenate([faces.weight * (1 - sensor.loss(faces.hits.cosine)), floor.weight], axis=-1)
    jacobian = range_jacobian(box, np.concatenate([faces.rays, floor.rays], axis=1), hits)
    weighted = jacobian.mT * (weight / (noise * sensor.range_sigma(hits.ranges, hits.cosine)) ** 2)[:, None]
    return weighted @ jacobian, weighted @ sensor.systematic_shapes(hits.ranges)


def _edge_information(box: Box, sensor: Sensor, noise: float) -> tuple[Array, Array]:
    """Return the evidence of the outline, and the gradient of one sigma of shift of all its edges.

    The evidence is per pixel of its length, as far as box and background can be told apart there.
    """
    shape = outline(box)
    start, side = shape.vertices, following(shape.vertices, axis=-2) - shape.vertices
    image = (start[:, :, None] + _ALONG[:, None] * side[:, :, None]).reshape(len(start), -1, 2)
    rays, inward = unit(image), unit(image + 1e-4 * (shape.middle[:, None] - image))
    near, far = box_hits(box, inward), floor_hits(box, rays)
    sigma = noise * sensor.range_sigma(np.minimum(near.ranges, 10.0), near.cosine)
    with np.errstate(over="ignore"):
        gap = np.clip((far.ranges - near.ranges) / sigma, 0.0, 50.0)
    told_apart = (1 - np.exp(-(gap**2) / 8)) * in_view(rays, near.ranges, sensor)
    length = np.linalg.norm(side, axis=-1, keepdims=True) / len(_ALONG) * sensor.intrinsics.fx
    weight = UNMIXED * EDGE_INFORMATION / EDGE_SOFTNESS * length * told_apart.reshape(*side.shape[:-1], -1)  # [views, edges, 12]
    at_start, at_end = (each[:, :, None] * sensor.intrinsics.fx for each in edge_end_jacobians(box, shape))
    jacobian = (1 - _ALONG)[:, None] * at_start + _ALONG[:, None] * at_end
    weighted = jacobian * weight[..., None]
    information = jacobian.reshape(len(start), -1, PARAMETERS).mT @ weighted.reshape(len(start), -1, PARAMETERS)
    pull, precision = weighted.sum(axis=2), weight.sum(axis=2)
    sigma = sensor.edge_sigma(edge_cosines(box, shape))
    return without_edge_bias(information, pull, precision, sigma), common_shift(pull, precision, sigma)

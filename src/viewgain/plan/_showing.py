"""What one view is expected to show of a box: information about it, and which of its dimensions can be seen from end to end."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Mask, Pose
from viewgain.box import FACES, Box, clearance, edges_shown
from viewgain.camera import Sensor
from viewgain.geometry import inverse
from viewgain.measure import MIN_EDGE_SHOWN, SPANNING, SPANNING_POINTS, Knowledge
from viewgain.plan._floor_in_view import FloorInView, floor_in_view
from viewgain.plan._predict import MIN_FACE_PIXELS, Prediction, predict, to_pixels

_ENDS = ((0, 1), (2, 3), (4, 4))
"""The faces at the ends of each axis of the box; of z only the upper one, for the lower is the floor."""
_BY_RETURNS = 0.5
"""How well an end counts as shown by a face with ``SPANNING_POINTS`` returns; an edge in full view counts as 1."""
_NEAR = 0.05
FARTHEST = 0.3
"""Farther than this from the image border is all the same, radians or so."""


@dataclass(frozen=True, slots=True, eq=False)
class Showing:
    """What a camera at a pose would show of a box."""

    knowledge: Knowledge
    """Expected information and systematic gradient, box frame."""
    spanned: Mask
    """(3,) axes of the box that faces with many returns show from end to end, as in measuring."""
    border: float
    """Share of its outline on the image border or beyond it."""
    returns: Array
    """(5,) expected number of returns from each face, in the order of ``viewgain.box.FACES``."""
    ends: Array
    """(3, 2) how well both ends of each axis can be seen, 0 to 1: by the edges there that lie in the image, or by the face."""
    corners: float
    """Share of the box's corners that project into the image."""
    clearance: float
    """How far inside the image border the outermost corner lies, over the focal length, so about radians; negative beyond it, and
    at most ``FARTHEST`` either way."""
    distance: float
    """From the camera to the box's centre, metres."""
    elevation: float
    """Of the camera above the horizon of the box's centre, radians."""
    floor: FloorInView
    """What the image shows of the floor."""

    @property
    def cut(self) -> bool:
        """Whether the box leaves the image."""
        return self.border > 0


def showing(box: Box, camera_to_current: Pose, sensor: Sensor, noise: float) -> Showing:
    """Return what ``sensor`` at a pose would show of ``box``; arguments as :func:`viewgain.plan.predict`."""
    predicted = predict(box, camera_to_current, sensor, noise)
    returns, edges = _returns(predicted), np.zeros((len(FACES), len(FACES)))
    corners, outermost = 0.0, -FARTHEST
    seen, camera = box.in_frame(inverse(camera_to_current)), sensor.intrinsics
    if predicted.sights:
        size = (camera.width, camera.height)
        edges = edges_shown(seen, to_pixels(camera), size)
        inside = clearance(camera.project(seen.corners()), size)
        corners = float(np.mean(inside >= 0.5))
        outermost = float(np.clip(inside.min() / camera.fx, -FARTHEST, FARTHEST))
    sight = camera_to_current[:3, 3] - box.centre
    distance = max(float(np.linalg.norm(sight)), _NEAR)
    upward = float(np.clip(box.box_to_camera[:3, 2] @ sight / distance, -1.0, 1.0))
    return Showing(
        predicted.knowledge, _spanned(returns, edges), predicted.border, returns, _ends_shown(returns, edges), corners,
        outermost, distance, float(np.arcsin(upward)), floor_in_view(seen, sensor),
    )  # fmt: skip


def _returns(predicted: Prediction) -> Array:
    returns = np.zeros(len(FACES))
    for sight in predicted.sights:
        returns[FACES.index(sight.name)] = sight.returns
    return returns


def _spanned(returns: Array, edges: Array) -> Mask:
    shown, spanned = edges >= MIN_EDGE_SHOWN, np.zeros(3, dtype=bool)
    for axis, ends in enumerate(_ENDS):
        along = [face for face in SPANNING[axis] if returns[face] >= SPANNING_POINTS]
        spanned[axis] = bool(along) and all(returns[end] >= SPANNING_POINTS or shown[along, end].any() for end in ends)
    return spanned


def _ends_shown(returns: Array, edges: Array) -> Array:
    shown = np.zeros((3, 2))
    for axis, ends in enumerate(_ENDS):
        along = [face for face in SPANNING[axis] if returns[face] >= MIN_FACE_PIXELS]
        for place, end in enumerate(ends):
            by_edges = float(edges[along, end].max()) if along else 0.0
            shown[axis, place] = max(_BY_RETURNS * min(returns[end] / SPANNING_POINTS, 1.0), by_edges)
    return shown

"""What one view is expected to show of a box: information about it, and which of its dimensions can be seen from end to end."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Indices, Mask, Pose
from viewgain.box import FACES, Box, clearance, edges_shown
from viewgain.camera import Sensor
from viewgain.measure import MIN_EDGE_SHOWN, SPANNING, SPANNING_POINTS, Knowledge
from viewgain.plan._floor_in_view import FloorInView, floor_in_view
from viewgain.plan._predict import MIN_FACE_PIXELS, paired, predictions, to_pixels

_ENDS = ((0, 1), (2, 3), (4, 4))
"""The faces at the ends of each axis of the box; of z only the upper one, for the lower is the floor."""
_BY_RETURNS = 0.5
"""How well an end counts as shown by a face with ``SPANNING_POINTS`` returns; an edge in full view counts as 1."""
_NEAR = 0.05
FARTHEST = 0.3
"""Farther than this from the image border is all the same, radians or so."""


@dataclass(frozen=True, slots=True, eq=False)
class Showing:
    """What a camera at a pose would show of a box; of a stack of n boxes all arrays have n as their first dimension."""

    knowledge: Knowledge
    """Expected information and systematic gradient, box frame."""
    spanned: Mask
    """(3,) axes of the box that faces with many returns show from end to end, as in measuring."""
    border: Array
    """Share of its outline on the image border or beyond it."""
    returns: Array
    """(5,) expected number of returns from each face, in the order of ``viewgain.box.FACES``."""
    ends: Array
    """(3, 2) how well both ends of each axis can be seen, 0 to 1: by the edges there that lie in the image, or by the face."""
    corners: Array
    """Share of the box's corners that project into the image."""
    clearance: Array
    """How far inside the image border the outermost corner lies, over the focal length, so about radians; negative beyond it, and
    at most ``FARTHEST`` either way."""
    distance: Array
    """From the camera to the box's centre, metres."""
    elevation: Array
    """Of the camera above the horizon of the box's centre, radians."""
    floor: FloorInView
    """What the image shows of the floor."""

    @property
    def cut(self) -> Mask:
        """Whether the box leaves the image."""
        return self.border > 0

    def take(self, chosen: Indices | int) -> "Showing":
        """Return some of a stack, or one of it."""
        return Showing(
            self.knowledge.take(chosen), self.spanned[chosen], self.border[chosen], self.returns[chosen], self.ends[chosen],
            self.corners[chosen], self.clearance[chosen], self.distance[chosen], self.elevation[chosen], self.floor.take(chosen),
        )  # fmt: skip


def showing(box: Box, camera_to_current: Pose, sensor: Sensor, noise: float) -> Showing:
    """Return what ``sensor`` at a pose would show of ``box``; arguments as :func:`viewgain.plan.predict`."""
    return showings(paired((box,), camera_to_current[None])[1], sensor, noise).take(0)


def showings(seen: Box, sensor: Sensor, noise: float) -> Showing:
    """Return :func:`showing` of a stack of n boxes, each in the frame of the camera that is to see it."""
    predicted = predictions(seen, sensor, noise)
    returns, count = predicted.returns, len(seen.extents)
    edges, corners, outermost = np.zeros((count, len(FACES), len(FACES))), np.zeros(count), np.full(count, -FARTHEST)
    some, camera = np.flatnonzero(returns.any(axis=1)), sensor.intrinsics
    if len(some):
        shown, size = seen.take(some), (camera.width, camera.height)
        edges[some] = edges_shown(shown, to_pixels(camera), size)
        inside = clearance(camera.project(shown.corners()), size)
        corners[some] = np.mean(inside >= 0.5, axis=1)
        outermost[some] = np.clip(inside.min(axis=1) / camera.fx, -FARTHEST, FARTHEST)
    sight = -seen.centre
    distance = np.maximum(np.linalg.norm(sight, axis=1), _NEAR)
    upward = np.clip(np.sum(seen.box_to_camera[:, :3, 2] * sight, axis=1) / distance, -1.0, 1.0)
    return Showing(
        predicted.knowledge, _spanned(returns, edges), predicted.border, returns, _ends_shown(returns, edges), corners,
        outermost, distance, np.arcsin(upward), floor_in_view(seen, sensor),
    )  # fmt: skip


def _spanned(returns: Array, edges: Array) -> Mask:
    """Return (n, 3), by (n, 5) returns and (n, 5, 5) edges, which axes are shown from end to end."""
    full, shown = returns >= SPANNING_POINTS, edges >= MIN_EDGE_SHOWN
    spanned = np.zeros((len(returns), 3), dtype=bool)
    for axis, ends in enumerate(_ENDS):
        faces = list(SPANNING[axis])
        along = full[:, faces]
        by_edges = np.any(along[..., None] & shown[:, faces][..., list(ends)], axis=1)
        spanned[:, axis] = along.any(axis=1) & np.all(full[:, list(ends)] | by_edges, axis=1)
    return spanned


def _ends_shown(returns: Array, edges: Array) -> Array:
    """Return (n, 3, 2), by (n, 5) returns and (n, 5, 5) edges, how well the ends of each axis are shown."""
    by_face = _BY_RETURNS * np.minimum(returns / SPANNING_POINTS, 1.0)
    shown = np.zeros((len(returns), 3, 2))
    for axis, ends in enumerate(_ENDS):
        faces = list(SPANNING[axis])
        along = returns[:, faces] >= MIN_FACE_PIXELS
        by_edges = np.max(along[..., None] * edges[:, faces][..., list(ends)], axis=1)
        shown[:, axis] = np.maximum(by_face[:, list(ends)], by_edges)
    return shown

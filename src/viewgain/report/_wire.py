"""A box as lines: its twelve edges, which of them it hides itself, and where it stands open. Needs numpy only."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Mask, Points, Points2, Vector3
from viewgain.box import CORNERS, FACES, PLANE_NORMALS, Box
from viewgain.geometry import pose, transform
from viewgain.measure import LOOSE_PRIOR, BoxEstimate

NORMALS = np.vstack([PLANE_NORMALS[: len(FACES)], [0.0, 0.0, -1.0]])
"""(6, 3) outward normals of the five named faces and the bottom, box frame."""
LABELS = tuple(name.replace("-", "−") for name in FACES)
"""Names of the five faces as they are printed."""
FARTHEST = 1.2
"""A dimension without an upper end is drawn as if it went on to this length, metres, or half as far again as its lower bound."""


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """One edge of a box."""

    ends: Points
    """(2, 3) its two corners."""
    hidden: bool
    """Whether the box itself hides it."""


def facing_camera(box: Box) -> Mask:
    """Return the (6,) mask of faces turned towards a camera at the origin."""
    centres = transform(box.box_to_camera, _centres(box))
    return np.asarray(np.sum((NORMALS @ box.box_to_camera[:3, :3].T) * centres, axis=1) < 0)


def facing_direction(box: Box, direction: Vector3) -> Mask:
    """Return the (6,) mask of faces turned towards a viewer infinitely far away in a direction."""
    return np.asarray(NORMALS @ box.box_to_camera[:3, :3].T @ direction > 0)


def edges(box: Box, facing: Mask) -> tuple[Edge, ...]:
    """Return the twelve edges; one is hidden if neither of its two faces is turned towards the viewer."""
    corners = box.corners()
    found = []
    for first in range(8):
        for axis in range(3):
            second = first + 2**axis
            if CORNERS[first, axis] == CORNERS[:, axis].max():
                continue
            middle = (CORNERS[first] + CORNERS[second]) / 2 - (0, 0, 0.5)
            beside = NORMALS @ middle > 0.4
            found.append(Edge(corners[[first, second]], not bool(np.any(facing & beside))))
    return tuple(found)


def faces(box: Box, facing: Mask) -> dict[str, Points]:
    """Return every named face that is turned towards the viewer: its centre and then its four corners in turn, (5, 3)."""
    corners, centres = box.corners(), transform(box.box_to_camera, _centres(box))
    found = {}
    for index in np.flatnonzero(facing[: len(LABELS)]):
        own = np.flatnonzero(np.abs((CORNERS - (0, 0, 0.5)) @ NORMALS[index] - 0.5) < 0.1)
        found[LABELS[index]] = np.vstack([centres[index], corners[own[[0, 1, 3, 2]]]])
    return found


def room(face: Points2) -> float:
    """Return how far the centre of a face is from its sides in a picture, where ``face`` (5, 2) is centre and corners."""
    start, end = face[1:] - face[0], np.roll(face[1:], -1, axis=0) - face[0]
    side = end - start
    return float(
        np.min(np.abs(start[:, 0] * side[:, 1] - start[:, 1] * side[:, 0]) / np.maximum(np.linalg.norm(side, axis=1), 1e-9))
    )


def reported_box(estimate: BoxEstimate) -> Box:
    """Return the box as its numbers say it: an open dimension as long as its lower bound, its known end in place."""
    box, values = estimate.box, reported_extents(estimate)
    shift = np.zeros(3)
    for axis in np.flatnonzero(estimate.is_open[:2]):
        shift[axis] = 0.5 * open_side(estimate, int(axis)) * (values[axis] - box.extents[axis])
    return Box(box.box_to_camera @ pose(np.eye(3), shift), values)


def reported_extents(estimate: BoxEstimate) -> Vector3:
    """Return (3,) the reported dimensions along the box's x, y and z, metres."""
    values = np.empty(3)
    values[estimate.order] = estimate.dimensions
    return values


def open_edges(estimate: BoxEstimate) -> list[Points]:
    """Return the (2, 3) lines along which the box may go on: from the free end of each open dimension to its upper end."""
    box = reported_box(estimate)
    lines = []
    for axis in np.flatnonzero(estimate.is_open):
        side = open_side(estimate, int(axis))
        low, high = box.extents[axis], estimate.intervals[axis].high
        further = min(float(high), max(FARTHEST, 1.5 * low)) - low
        along = box.box_to_camera[:3, axis] * side * further
        free = box.corners()[CORNERS[:, axis] * side == (CORNERS[:, axis] * side).max()]
        lines += [np.array([corner, corner + along]) for corner in free]
    return lines


def open_side(estimate: BoxEstimate, axis: int) -> int:
    """Return which end of an open dimension is the free one, +1 or -1: the one that moves as the dimension grows."""
    if axis == 2:
        return 1
    ridge = np.linalg.inv(estimate.knowledge.information + LOOSE_PRIOR)[:, 6 + axis]
    return 1 if ridge[3 + axis] >= 0 else -1


def _centres(box: Box) -> Points:
    """Return the (6, 3) centres of the faces, box frame."""
    return np.asarray((NORMALS / 2 + (0, 0, 0.5)) * box.extents)

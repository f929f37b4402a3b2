"""First guesses of the box: yaw from the faces' normals and from the footprint, extents from what is seen."""

import numpy as np

from viewgain.arrays import Array, Points, Points2
from viewgain.box import PARAMETERS, Box
from viewgain.geometry import floor_to_camera, pose
from viewgain.measure._floor import Floor

_YAWS = np.deg2rad(np.arange(0.0, 90.0, 2.0))
_TRIM = 0.01
_ABOVE_FLOOR = 0.25
_THIN = 0.15
MIN_EXTENT = 0.02
"""A hypothesis is never thinner than this, metres: a face seen head-on has no depth of its own."""


def hypotheses(points: Points, floor: Floor) -> list[Box]:
    """Return a few standing boxes around (n, 3) camera-frame ``points`` of one object, best guesses first.

    Points in the lowest quarter are left out: real floors rise towards a box, by multipath, and would widen its footprint.

    The yaw comes from the smallest rectangle around the top's footprint, from the smallest around the whole footprint, and
    from the rectangle whose sides the footprint hugs best; extents are 1 % trimmed. A bare front is also tried with depth.
    """
    placing = floor_to_camera(floor.plane)
    local = (points - placing[:3, 3]) @ placing[:3, :3]
    local = local[:: max(1, len(local) // 3000)]
    top = float(np.quantile(local[:, 2], 0.97))
    crown = local[local[:, 2] > top - max(0.02, 3 * floor.spread)]
    local = local[local[:, 2] > _ABOVE_FLOOR * top]
    footprint = local[:, :2]
    yaws = [
        _smallest_rectangle(crown[:, :2] if len(crown) > 30 else footprint),
        _smallest_rectangle(footprint),
        _hugging(footprint),
    ]
    guesses = [_box_at(yaw, local, top, placing) for yaw in _distinct(yaws)]
    return [deeper for guess in guesses for deeper in _with_depth(guess)]


def _with_depth(box: Box) -> list[Box]:
    """Return the box, and where it is only a seen front without depth, the same front on boxes of plausible depths."""
    axis = int(np.argmin(box.extents[:2]))
    front, depth = box.extents[1 - axis], box.extents[axis]
    if depth > _THIN * front:
        return [box]
    away = 1.0 if box.box_to_camera[:3, axis] @ box.box_to_camera[:3, 3] > 0 else -1.0
    deeper = []
    for factor in (0.4, 1.0):
        step = np.zeros(PARAMETERS)
        step[6 + axis] = factor * front - depth
        step[3 + axis] = away * step[6 + axis] / 2
        deeper.append(box.moved(step))
    return [box, *deeper]


def _box_at(yaw: float, local: Points, top: float, placing: Array) -> Box:
    cosine, sine = np.cos(yaw), np.sin(yaw)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    turned = local[:, :2] @ turn[:2, :2]
    low, high = np.quantile(turned, [_TRIM, 1 - _TRIM], axis=0)
    middle = turn[:2, :2] @ ((low + high) / 2)
    extents = np.maximum([*(high - low), top], MIN_EXTENT)
    return Box(placing @ pose(turn, np.array([*middle, 0.0])), extents)


def _smallest_rectangle(points: Points2) -> float:
    """Return the yaw in [0, 90) degrees whose 2 % trimmed bounding rectangle has the least area."""
    low, high = np.quantile(_turned(points), [0.02, 0.98], axis=1)
    return float(_YAWS[np.argmin(np.prod(high - low, axis=-1))])


def _hugging(points: Points2) -> float:
    """Return the yaw at which points lie closest to the nearest side of their bounding rectangle (an L of two faces)."""
    turned = _turned(points)
    low, high = np.quantile(turned, [0.02, 0.98], axis=1)
    gap = np.minimum(np.abs(turned - low[:, None]), np.abs(turned - high[:, None])).min(axis=2)
    return float(_YAWS[np.argmin(np.mean(np.minimum(gap, 0.05), axis=1))])


def _turned(points: Points2) -> Array:
    """Return (yaws, n, 2): the points in the frame of each candidate yaw."""
    points = points[:: max(1, len(points) // 400)]
    cosine, sine = np.cos(_YAWS)[:, None], np.sin(_YAWS)[:, None]
    x, y = points[:, 0], points[:, 1]
    return np.stack([cosine * x + sine * y, cosine * y - sine * x], axis=2)


def _distinct(yaws: list[float]) -> list[float]:
    kept: list[float] = []
    for yaw in yaws:
        apart = [abs((yaw - other + np.pi / 4) % (np.pi / 2) - np.pi / 4) for other in kept]
        if all(gap > np.deg2rad(3.0) for gap in apart):
            kept.append(yaw)
    return kept

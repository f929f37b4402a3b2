"""The boxes that could have made a scan in which nothing could be measured, by a sequential Monte Carlo sampler (ours).

In the sense of Del Moral, Doucet and Jasra 2006: boxes are drawn around the place where one stands, and weighted by how well each
explains the ranges of some returns, to 30 cm at first and to 4 cm in the end. After each step they are resampled, and then moved
a face at a time by Metropolis's rule, so that they stay what place and scan together say. Floor, border and edges need not be
seen: a wall of cardboard that fills the image is explained by large boxes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from viewgain.arrays import Array, Indices, Points, Vector, Vector3
from viewgain.box import Box
from viewgain.geometry import Plane, floor_to_camera, pose, transform
from viewgain.plan._place import Place

PARTICLES, KEPT, RETURNS = 3000, 500, 160
"""Boxes drawn at first, boxes that go on, and returns that each has to explain."""
TOLERANCES = (0.3, 0.15, 0.08, 0.04)
"""Range error that counts as one, metres, step by step: warm at first, so that more than a lucky few go on."""
MOVES = 12
"""Moves that every box may make after each step; it takes some for the faces that nobody sees to spread."""
_MOST_WRONG = 4.0
"""A range that is farther off, in tolerances, is just wrong: something else, or a mixed pixel."""
_INDEPENDENT = 60.0
"""What all returns together are worth, in returns of independent error: boxes that explain a scan alike stay alike likely."""
_SIDES = (0.05, 1.2)
"""Sides are drawn uniformly from these, metres; those of an open dimension end there, too."""
_STEP = 0.2
"""Moves of the six faces and of the heading, standard deviation, metres and radians."""
_SCALES = 6
"""Every move is halved up to fewer times than this: a face that is seen has to keep its place to a few millimetres, and one that
is not seen may be anywhere."""
_FARTHEST = 8.0
"""Rays that meet nothing nearer end here, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class _Returns:
    """Some returns of the scan, in an upright frame with its origin in the camera."""

    directions: Points
    """(m, 3) unit vectors."""
    ranges: Vector
    """(m,) metres."""


def possible_boxes(points: Points, up: Vector3, place: Place, count: int, *, rng: np.random.Generator) -> tuple[Box, ...]:
    """Return ``count`` equally likely boxes that explain a scan, at quantiles of their volume; in 0.1 to 0.2 s.

    Args:
        points: (n, 3) points of the scan, camera frame, metres, finite; one or more.
        up: (3,) unit vector, camera frame.
        place: Where the box stands, camera frame.
        count: How many, at most ``KEPT``.
        rng: Source of the draws.
    """
    upright = floor_to_camera(Plane(up, 0.0))[:3, :3]
    local = points[rng.choice(len(points), min(RETURNS, len(points)), replace=False)] @ upright
    ranges = np.linalg.norm(local, axis=1)
    seen, stands = _Returns(local / ranges[:, None], ranges), Place(upright.T @ place.centre, place.sigma)
    boxes = _drawn(stands, rng)
    told = np.zeros(len(boxes))  # log likelihood that the boxes are already chosen by
    for tolerance in TOLERANCES:
        kept = _resampled(_explained(boxes, seen, tolerance) - told, rng)
        boxes = _metropolis(boxes[kept], partial(_odds, seen=seen, tolerance=tolerance, place=stands), rng)
        told = _explained(boxes, seen, tolerance)
    by_volume = boxes[np.argsort(boxes[:, :3].prod(axis=1))]
    return tuple(_box(row, upright) for row in by_volume[((np.arange(count) + 0.5) / count * KEPT).astype(int)])


def _drawn(place: Place, rng: np.random.Generator) -> Array:
    """Return (n, 7) boxes from the prior: three sides, heading, centre."""
    sides, heading = rng.uniform(*_SIDES, (PARTICLES, 3)), rng.uniform(0, np.pi / 2, (PARTICLES, 1))
    return np.hstack([sides, heading, place.centre + rng.normal(0.0, place.sigma, (PARTICLES, 3))])


def _odds(boxes: Array, seen: _Returns, tolerance: float, place: Place) -> Vector:
    """Return (n,) log densities of boxes given place and scan, up to a constant."""
    allowed = ((boxes[:, :3] >= _SIDES[0]) & (boxes[:, :3] <= _SIDES[1])).all(axis=1)
    return np.where(allowed, _explained(boxes, seen, tolerance) + place.log_odds(boxes[:, 4:]), -np.inf)


def _explained(boxes: Array, seen: _Returns, tolerance: float) -> Vector:
    """Return (n,) log likelihoods: absolute range errors in tolerances, each cut off where it is just wrong."""
    wrong = np.abs(expected_ranges(boxes, seen.directions) - seen.ranges) / tolerance
    return np.asarray(-_INDEPENDENT * np.minimum(wrong, _MOST_WRONG).mean(axis=1))


def expected_ranges(boxes: Array, directions: Points) -> Array:
    """Return (n, m) ranges at which rays from the origin meet boxes or their floors; 0 from within a box.

    Args:
        boxes: (n, 7) three sides, heading about z (radians), centre, metres.
        directions: (m, 3) unit vectors, z up.
    """
    half, cos, sin = boxes[:, :3] / 2, np.cos(boxes[:, 3]), np.sin(boxes[:, 3])
    x, y, z = -boxes[:, 4:].T
    origin = (cos * x + sin * y, cos * y - sin * x, z)
    along = (
        np.outer(cos, directions[:, 0]) + np.outer(sin, directions[:, 1]),
        np.outer(cos, directions[:, 1]) - np.outer(sin, directions[:, 0]),
        np.broadcast_to(directions[:, 2], (len(boxes), len(directions))),
    )
    near, far = np.full(along[0].shape, -np.inf), np.full(along[0].shape, np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for axis in range(3):
            one, other = ((side * half[:, axis] - origin[axis])[:, None] / along[axis] for side in (-1, 1))
            near, far = np.maximum(near, np.minimum(one, other)), np.minimum(far, np.maximum(one, other))
        floor = (-half[:, 2] - z)[:, None] / along[2]
    ranges = np.where((near < far) & (near > 0), near, np.where(floor > 0, floor, _FARTHEST))
    ranges[(np.abs(origin) < half.T).all(axis=0)] = 0.0
    return np.asarray(np.minimum(ranges, _FARTHEST))


def _metropolis(boxes: Array, odds_of: Callable[[Array], Vector], rng: np.random.Generator) -> Array:
    """Return boxes after ``MOVES`` moves, each taken with the chance that the log odds there and here leave it."""
    odds = odds_of(boxes)
    for _ in range(MOVES):
        tried = _moved(boxes, rng)
        there = odds_of(tried)
        taken = np.log(rng.random(len(boxes))) < there - odds
        boxes, odds = np.where(taken[:, None], tried, boxes), np.where(taken, there, odds)
    return boxes


def _moved(boxes: Array, rng: np.random.Generator) -> Array:
    """Return boxes with one face of each moved along its normal, or the box turned a little about its centre."""
    moves = rng.normal(size=(len(boxes), 7)) * _STEP / 2.0 ** rng.integers(_SCALES, size=(len(boxes), 7))
    moves *= rng.integers(7, size=len(boxes))[:, None] == np.arange(7)
    low, high, turn = moves[:, :3], moves[:, 3:6], moves[:, 6]
    cos, sin, across = np.cos(boxes[:, 3]), np.sin(boxes[:, 3]), (high - low) / 2
    along = np.column_stack([cos * across[:, 0] - sin * across[:, 1], sin * across[:, 0] + cos * across[:, 1], across[:, 2]])
    return np.hstack([boxes[:, :3] + low + high, (boxes[:, 3] + turn)[:, None], boxes[:, 4:] + along])


def _resampled(odds: Vector, rng: np.random.Generator) -> Indices:
    """Return ``KEPT`` indices, each as often as its log odds say (systematic resampling)."""
    weights = np.exp(odds - odds.max())
    places = (np.arange(KEPT) + rng.random()) / KEPT * weights.sum()
    return np.asarray(np.minimum(np.searchsorted(np.cumsum(weights), places), len(odds) - 1))


def _box(row: Array, upright: Array) -> Box:
    """Return a row as a box in the camera's frame."""
    cos, sin = np.cos(row[3]), np.sin(row[3])
    turned = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    bottom = transform(pose(upright, np.zeros(3)), row[None, 4:] - [0.0, 0.0, row[2] / 2])[0]
    return Box(pose(upright @ turned, bottom), row[:3].copy())

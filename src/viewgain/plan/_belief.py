"""What is believed about the box before moving: a weighted set of boxes, whatever the present scan showed.

A well-seen box is one box with its covariance. A dimension that was left open is spread over its stated prior, with the seen
face held still. A mere blob on the floor is a box of the blob's size, known to a third of it.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from viewgain.arrays import Array, Pose
from viewgain.box import PARAMETERS, Box
from viewgain.camera import Sensor
from viewgain.geometry import floor_to_camera, pose
from viewgain.measure import LOOSE_PRIOR, PRIOR_EXTENT, SYSTEMATIC, BoxEstimate, Knowledge, Measurement, Rejected

SPREAD = (1, 5, 3, 2)
"""Number of boxes that stand for each open dimension, by how many are open."""
TYPICAL_EXTENT = 1.2
"""An open dimension is taken to be at most this long, metres, unless it is already longer."""


LEAST_REACH = 0.6
"""An open dimension is considered up to at least this, metres, whatever its interval says: the evidence against a longer one is
missing returns alone, and a plan that is good for longer boxes too costs little."""


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """Equally likely boxes and the knowledge that goes with each."""

    boxes: tuple[Box, ...]
    """Possible boxes, the smallest first, present camera's frame."""
    knowledge: Knowledge
    """What the scans so far say, around any of them."""
    sensor: Sensor
    """The camera."""
    noise: float
    """Its noise on this scene as a multiple of the data sheet's."""
    bounded: bool
    """Whether the scans bound every dimension."""
    guessed: bool = False
    """Whether nothing could be measured, and the box is a guess at what stands there."""

    @property
    def mean(self) -> Box:
        """The middle box: what the candidates look at."""
        return self.boxes[len(self.boxes) // 2]


@dataclass(frozen=True, slots=True)
class Outlook:
    """How well the volume is, or would be, known."""

    volume_sigma: float
    """Standard deviation of the volume, cubic metres."""
    within_tolerance: float
    """Probability that the relative volume error is under the tolerance."""


@dataclass(frozen=True, slots=True)
class Certainty:
    """What the stop rule says."""

    within_tolerance: float
    """Probability that the relative volume error is under the tolerance."""
    enough: bool
    """Whether that is as much as was asked for, of a box with every dimension bounded."""


def belief_from(estimate: BoxEstimate) -> Belief:
    """Return the belief after measuring a box: one box, or several where dimensions are open."""
    boxes = [estimate.box]
    ridge_of = np.linalg.inv(estimate.knowledge.information + LOOSE_PRIOR)
    axes = np.flatnonzero(estimate.is_open)
    steps = (np.arange(SPREAD[len(axes)]) + 0.5) / SPREAD[len(axes)]
    for axis in axes:
        interval = estimate.intervals[axis]
        value = estimate.box.extents[axis]
        low = max(interval.low, PRIOR_EXTENT[0])
        high = max(interval.high if np.isfinite(interval.high) else TYPICAL_EXTENT, LEAST_REACH, 1.5 * low)
        ridge = ridge_of[:, 6 + axis] / ridge_of[6 + axis, 6 + axis]
        lengths = low * max(high / low, 1.01) ** steps
        boxes = [box.moved(ridge * (length - value)) for length in lengths for box in boxes]
    boxes = [Box(box.box_to_camera, np.maximum(box.extents, 0.01)) for box in boxes]
    view = estimate.views[0]
    return Belief(
        tuple(sorted(boxes, key=lambda box: box.volume)), estimate.knowledge, view.sensor, view.noise, not any(estimate.is_open)
    )


def belief_from_blob(blob: Rejected, current: Measurement, sensor: Sensor) -> Belief:
    """Return the belief about an object that could not be measured: its bounding box, each number known to a third."""
    assert current.floor is not None
    placing = floor_to_camera(current.floor.plane)
    corners = blob.centre + blob.spread * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    local = (corners - placing[:3, 3]) @ placing[:3, :3]
    middle = (blob.centre - placing[:3, 3]) @ placing[:3, :3]
    reach = np.maximum(np.abs(local - middle).mean(axis=0), 0.03)
    extents = np.array([2 * reach[0], 2 * reach[1], max(middle[2] + reach[2], 0.05)])
    box = Box(placing @ pose(np.eye(3), np.array([middle[0], middle[1], 0.0])), extents)
    third = np.concatenate([np.full(2, 50.0), [0.5], np.repeat(3 / extents.mean(), 2), [20.0], 3 / extents]) ** 2
    knowledge = Knowledge(np.diag(third), np.zeros((PARAMETERS, SYSTEMATIC)))
    return Belief((box,), knowledge, sensor, current.floor.noise, bounded=False, guessed=True)


def outlook(belief: Belief, tolerance: float) -> Outlook:
    """Return how well the volume is known now.

    Several possible boxes add their own spread: the chance to be within the tolerance is then that of the most favourable
    answer, the fraction of boxes whose volume lies within the tolerance of the median's.
    """
    each = [relative_sigma(belief.knowledge, box, belief.sensor) for box in belief.boxes]
    volumes = np.array([box.volume for box in belief.boxes])
    middle = float(np.median(volumes))
    sigma = float(np.sqrt(np.mean((np.array(each) * volumes) ** 2) + np.var(volumes)))
    within = np.mean([
        normal_within(volume / middle - 1, max(spread, 1e-6), tolerance) for volume, spread in zip(volumes, each, strict=True)
    ])  # fmt: skip
    return Outlook(sigma, float(within))


def certainty(belief: Belief, *, tolerance: float, confidence: float) -> Certainty:
    """Return whether the volume is known as well as asked for: P(relative error < tolerance) > confidence, all sides bounded."""
    chance = outlook(belief, tolerance).within_tolerance
    return Certainty(chance, belief.bounded and chance > confidence)


def relative_sigma(knowledge: Knowledge, box: Box, sensor: Sensor) -> float:
    """Return the standard deviation of the volume over the volume: sqrt(g' C g) with g = 1 / extents."""
    gradient: Array = np.concatenate([np.zeros(6), 1 / box.extents])
    return float(np.sqrt(gradient @ knowledge.covariance(sensor) @ gradient))


def normal_within(mean: float, sigma: float, tolerance: float) -> float:
    """Return P(|x| < tolerance) for x ~ N(mean, sigma)."""
    return float(ndtr((tolerance - mean) / sigma) - ndtr((-tolerance - mean) / sigma))


def floor_pose(belief: Belief) -> Pose:
    """Return (4, 4) floor_to_current of the believed box's floor."""
    return floor_to_camera(belief.mean.floor)

"""What is believed about the box before moving, how well its volume is known, and the stop rule."""

from dataclasses import dataclass, field

import numpy as np
from scipy.special import ndtr

from viewgain.arrays import Array, Pose, Poses
from viewgain.box import Box
from viewgain.camera import Sensor
from viewgain.geometry import floor_to_camera
from viewgain.measure import Knowledge


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
    glimpsed: bool = False
    """Whether, of those, the boxes are what explains the scan at a place where one is known to stand."""
    cameras: Poses = field(default_factory=lambda: np.eye(4)[None])
    """(k, 4, 4) ``camera_to_current`` of the scans that showed the box; by default the present camera's."""

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


def outlook(belief: Belief, tolerance: float) -> Outlook:
    """Return how well the volume is known now.

    Several possible boxes add their own spread: the chance to be within the tolerance is then that of the most favourable
    answer, the fraction of boxes whose volume lies within the tolerance of the median's.
    """
    boxes = Box.stack(belief.boxes)
    spread, volumes = relative_sigma(belief.knowledge, boxes, belief.sensor), boxes.extents.prod(axis=1)
    sigma = float(np.sqrt(np.mean((spread * volumes) ** 2) + np.var(volumes)))
    within = normal_within(volumes / np.median(volumes) - 1, np.maximum(spread, 1e-6), tolerance)
    return Outlook(sigma, float(np.mean(within)))


def certainty(belief: Belief, *, tolerance: float, confidence: float) -> Certainty:
    """Return whether the volume is known as well as asked for: P(relative error < tolerance) > confidence, all sides bounded."""
    chance = outlook(belief, tolerance).within_tolerance
    return Certainty(chance, belief.bounded and chance > confidence)


def relative_sigma(knowledge: Knowledge, box: Box, sensor: Sensor) -> Array:
    """Return the standard deviation of the volume over the volume: sqrt(g' C g) with g = 1 / extents.

    Of a stack of n boxes (n,), with the same knowledge of all or each with its own.
    """
    gradient = 1 / box.extents[..., None]
    variance = gradient.mT @ knowledge.covariance(sensor)[..., 6:, 6:] @ gradient
    return np.sqrt(variance[..., 0, 0])


def extent_sigmas(knowledge: Knowledge, sensor: Sensor) -> Array:
    """Return the (3,) standard deviations of the extents, metres; of a stack too."""
    return np.sqrt(np.diagonal(knowledge.covariance(sensor), axis1=-2, axis2=-1)[..., 6:])


def normal_within(mean: Array | float, sigma: Array | float, tolerance: float) -> Array:
    """Return P(|x| < tolerance) for x ~ N(mean, sigma)."""
    return np.asarray(ndtr((tolerance - mean) / sigma) - ndtr((-tolerance - mean) / sigma))


def floor_pose(belief: Belief) -> Pose:
    """Return (4, 4) floor_to_current of the believed box's floor."""
    return floor_to_camera(belief.mean.floor)

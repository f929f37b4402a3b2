"""Are two measured boxes one, and which sides correspond? Decided by the extents, with what each scan knows of them.

A box is the same after a half-turn about the vertical, so of the four quarter-turns that can lie between two views two are left:
the horizontal extents correspond as they are, or swapped. The half-turn never matters to dimensions.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from viewgain.arrays import Array, Mask, Pose
from viewgain.box import Box
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.measure._result import BoxEstimate
from viewgain.measure._uncertainty import LOOSE_PRIOR

FLOOR_SIGMA = 0.004
"""Added to the standard deviation of every extent when boxes are compared, metres: what the model does not know (dents, tape,
mixed pixels); without it the sharper of two good views would refuse the other."""
SAME_BOX = 16.3
"""Chi-square of the extents up to which two boxes may be one: the 99.9 % point at three degrees of freedom."""
_OPEN_SIGMA = 10.0


@dataclass(frozen=True, slots=True, eq=False)
class Extents:
    """What one scan says about the extents of a box, in the order of its own axes."""

    values: Array
    """(3,) estimates, metres."""
    precision: Array
    """(3, 3) inverse covariance, square metres; nothing along an open extent."""
    least: Array
    """(3,) lower ends of the 90 % intervals: all that is known of an open extent, metres."""

    @property
    def is_closed(self) -> Mask:
        """(3,) whether the scan bounds the extent well enough to tell one box from another: to a tenth."""
        return np.asarray(np.diag(self.precision) * (0.1 * self.values) ** 2 > 1)

    def turned(self, quarters: int) -> "Extents":
        """Return the same as seen along axes turned by some quarter-turns about the vertical."""
        order = [1, 0, 2] if quarters % 2 else [0, 1, 2]
        return Extents(self.values[order], self.precision[np.ix_(order, order)], self.least[order])


def extents_of(estimate: BoxEstimate) -> Extents:
    """Return what an estimate says about the extents."""
    covariance = estimate.covariance[6:, 6:] + FLOOR_SIGMA**2 * np.eye(3)
    for axis in np.flatnonzero(estimate.is_open):
        covariance[axis] = covariance[:, axis] = 0.0
        covariance[axis, axis] = _OPEN_SIGMA**2
    least = np.array([interval.low for interval in estimate.intervals])
    return Extents(estimate.box.extents, np.asarray(np.linalg.inv(covariance), dtype=float), least)


@dataclass(frozen=True, slots=True, eq=False)
class Pooled:
    """The extents that several scans agree on under one hypothesis of which sides correspond."""

    values: Array
    """(3,) their weighted mean, metres."""
    misfit: float
    """Chi-square of the scans about it; an open extent adds only where its lower bound lies above."""
    log_weight: float
    """Log of the hypothesis's marginal likelihood, up to a constant."""


def pooled(parts: Sequence[Extents]) -> Pooled:
    """Return the weighted mean of at least one set of extents along the same axes, and how well they agree."""
    total = np.sum([part.precision for part in parts], axis=0)
    values = np.linalg.solve(total, np.sum([part.precision @ part.values for part in parts], axis=0))
    misfit = 0.0
    for part in parts:
        gap, short = values - part.values, np.maximum(part.least - values, 0.0)
        misfit += float(gap @ part.precision @ gap + np.sum((short / (FLOOR_SIGMA + 0.02 * part.least)) ** 2))
    return Pooled(values, misfit, -0.5 * (misfit + float(np.linalg.slogdet(total)[1])))


def correspondences(parts: Sequence[Extents], known: Sequence[int | None]) -> list[tuple[tuple[int, ...], Pooled]]:
    """Return every way in which the sides of one box in several scans may correspond, the likeliest first.

    Args:
        parts: At least one; the first gives the axes.
        known: The quarter-turns from each part's axes to the first's, where something else has settled them.

    Returns:
        For each way the quarter-turns of each part (0 for the first, 0 or 1 where not known) and what the parts agree on.
    """
    choices = [(0,), *((0, 1) if turns is None else (turns,) for turns in known[1:])]
    tried = [(way, pooled([part.turned(turn) for part, turn in zip(parts, way, strict=True)])) for way in product(*choices)]
    return sorted(tried, key=lambda pair: -pair[1].log_weight)


def quarter_turn(quarters: int) -> Pose:
    """Return the (4, 4) rotation about the vertical by some quarter-turns."""
    return pose(rotation_from_rotvec(np.array([0.0, 0.0, quarters * np.pi / 2])), np.zeros(3))


def grown(estimate: BoxEstimate, extents: Array) -> Box:
    """Return the box of an estimate with other extents, its pose following as the scan's information has it.

    The seen faces stay and the unseen ones move off (the mean of the pose given the extents).
    """
    information = estimate.knowledge.information + LOOSE_PRIOR
    change = extents - estimate.box.extents
    motion = -np.linalg.solve(information[:6, :6], information[:6, 6:] @ change)
    return estimate.box.moved(np.concatenate([motion, change]))

"""Policies: given what is believed and where the camera could go, a score for every candidate."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from viewgain.arrays import Mask, Poses, Vector
from viewgain.plan._belief import Belief, Outlook, normal_within, outlook, relative_sigma
from viewgain.plan._predict import Prediction, on_arrival, paired, predictions
from viewgain.plan._views import Seen


@dataclass(frozen=True, slots=True, eq=False)
class Assessment:
    """A policy's view of one candidate."""

    score: float
    """The higher the better; comparable within one call only."""
    outlook: Outlook | None
    """Expected knowledge of the volume after fusing the candidate, where the policy predicts it; next_view fills it in."""
    prediction: Prediction | None
    """What the candidate would show, where the policy predicts it; next_view fills it in."""
    sigma: float | None = None
    """Standard deviation of the score, where the policy gives one."""


MODEL = "model"
"""Name of :class:`CovariancePolicy`, whose scores are shares of a standard deviation."""


@runtime_checkable
class Policy(Protocol):
    """Scores candidate poses from what is believed about a box; knows nothing of the truth.

    The general protocol, for any object, is :class:`viewgain.plan.ViewPolicy`; docs/policies.md says how the two are joined.
    """

    @property
    def name(self) -> str:
        """Name for tables and JSON."""
        ...

    def assess(self, belief: Belief, candidates: Poses, tolerance: float) -> tuple[Assessment, ...]:
        """Return one assessment per candidate.

        Args:
            belief: What the scans so far say.
            candidates: (v, 4, 4) poses ``camera_to_current``.
            tolerance: Relative volume error the user accepts.
        """
        ...


@runtime_checkable
class Delegating(Protocol):
    """A policy that leaves the decision to another one, by what is believed."""

    def deciding(self, belief: Belief) -> Policy:
        """Return who decides."""
        ...


@runtime_checkable
class Selecting(Protocol):
    """A policy to which it matters which candidates can be chosen: nothing is spent on others."""

    def among(self, reachable: Mask) -> Policy:
        """Return the policy that is told (V,) which of the candidates can be reached."""
        ...


@dataclass(frozen=True, slots=True)
class CovariancePolicy:
    """The model-based policy: propagate the covariance through each candidate's expected measurement.

    For every box still possible: information now + information the candidate would add = information after, and from it the
    volume's standard deviation (docs/next_view.md). The score is the share of today's standard deviation that it removes.
    """

    pose_sigma: tuple[float, float]
    """Standard deviation of a camera pose, metres and radians per axis."""
    name: str = MODEL

    def assess(self, belief: Belief, candidates: Poses, tolerance: float) -> tuple[Assessment, ...]:
        """Return the expected outlook after each candidate."""
        now = max(outlook(belief, tolerance).volume_sigma, 1e-12)
        here, seen = paired(belief.boxes, candidates)
        predicted = predictions(seen, belief.sensor, belief.noise)
        known = belief.knowledge.plus(on_arrival(predicted.knowledge, here, seen, self.pose_sigma))
        relative = relative_sigma(known, here, belief.sensor)
        shape = len(belief.boxes), len(candidates)
        sigmas = np.sqrt(np.mean(np.reshape(relative * here.extents.prod(axis=1), shape) ** 2, axis=0))
        chances = normal_within(0.0, relative, tolerance).reshape(shape).mean(axis=0)
        middle = len(belief.boxes) // 2 * len(candidates)
        return tuple(
            Assessment(1 - sigma / now, Outlook(sigma, chance), predicted[middle + view])
            for view, (sigma, chance) in enumerate(zip(sigmas.tolist(), chances.tolist(), strict=True))
        )


@dataclass(frozen=True, slots=True)
class RandomPolicy:
    """The floor of every comparison: a uniformly random candidate."""

    rng: np.random.Generator
    name: str = "random"

    def assess(self, belief: Belief, candidates: Poses, tolerance: float) -> tuple[Assessment, ...]:
        """Return uniformly random scores."""
        return tuple(Assessment(float(score), None, None) for score in self.rng.random(len(candidates)))

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) uniformly random scores: it is a general policy too."""
        return self.rng.random(len(seen.candidates))

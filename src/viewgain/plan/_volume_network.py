"""A trained network that says how well a box's volume would be measured from each candidate, alone and with the model."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Poses, Vector
from viewgain.geometry import inverse
from viewgain.inference import PoseScorer
from viewgain.plan._adapters import OnBelief
from viewgain.plan._belief import Belief
from viewgain.plan._expected import ExpectedErrorPolicy
from viewgain.plan._opinions import weighted
from viewgain.plan._policy import Assessment
from viewgain.plan._views import Seen, ViewPolicy
from viewgain.scans import Scan

ALONE, FUSED = (0.75, 0.75), (1.0, 0.5)
"""Weights of the model where every dimension is bounded, and where one is open: of what a candidate's scan says alone
(``python -m benchmarks trust``), and of what it says together with the present one."""
NOTHING_MEASURED = 0.0
"""Its weight where no box could be measured."""


@dataclass(frozen=True, slots=True, eq=False)
class VolumeNetworkPolicy:
    """Scores candidates by a network of kind ``pose_scores`` from the last scan, whole and as the camera sees it.

    It knows no rig and measures nothing, so it answers where no box can be measured too.
    """

    scorer: PoseScorer
    """The network."""
    name: str = "network"

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) minus the expected errors; NaN without a scan whose camera's place is known."""
        here = seen.scans[-1].camera_to_world if seen.scans else None
        if here is None:
            return np.full(len(seen.candidates), np.nan)
        return self.scorer.assessed(seen.scans[-1].points, inverse(here) @ seen.candidates).scores


def trust(belief: Belief | None, *, fused: bool) -> float:
    """Return the weight of the model beside a network: most of it where a box is known, none where a blob is or nothing.

    The model is exact about a box that it knows. Of what may stand behind a scan, and of scans without a volume, the network has
    seen more; where nothing could be measured it alone knows something. Together with a scan that bounds the box no candidate is
    without a volume, and they differ by less than the network can tell. Chosen on boxes that no table uses. Boxes that explain a
    scan where one is known to stand are as good as a box with an open dimension; there is nothing to fuse a candidate with.

    Args:
        belief: What is believed about the box, if anything is.
        fused: Whether a candidate is worth what its scan and the present one say together, rather than its scan alone.
    """
    if belief is None or (belief.guessed and not belief.glimpsed):
        return NOTHING_MEASURED
    bounded, still_open = FUSED if fused and not belief.glimpsed else ALONE
    return bounded if belief.bounded else still_open


@dataclass(frozen=True, slots=True, eq=False)
class CombinedPolicy:
    """The model where a box is known, with a say for the network, and the network alone where none is (:func:`trust`).

    Both score in the same unit up to a constant: by minus the expected relative error.
    """

    model: OnBelief[ExpectedErrorPolicy]
    """The model-based policy."""
    network: ViewPolicy
    """The network."""
    name: str = "combined"

    def trust(self, belief: Belief | None) -> float:
        """Return the weight of the model beside the network (:func:`trust`)."""
        return trust(belief, fused=self.model.policy.fused)

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) weighted means; where one of the two has no opinion the other's, NaN where neither has."""
        known = self.model.measuring(seen)
        belief = self.model.belief(known)
        return weighted(self.model.scored(belief, known), self.network.scores(known), self.trust(belief))


@dataclass(frozen=True, slots=True, eq=False)
class VolumeNetworkAboutBox:
    """The network where :func:`viewgain.plan.next_view` asks about a box, alone or combined with the model.

    Scores are 1 minus the expected error after the candidate, so what next_view makes of nearly equal scores holds for them too.
    """

    scorer: PoseScorer
    """The network."""
    scan: Scan
    """The camera as it stands."""
    model: ExpectedErrorPolicy | None = None
    """The model-based policy to combine it with; None for the network alone."""

    @property
    def name(self) -> str:
        """Says who decides."""
        return "network" if self.model is None else "combined"

    def assess(self, belief: Belief, candidates: Poses, tolerance: float) -> tuple[Assessment, ...]:
        """Return one assessment per candidate, (v, 4, 4) ``camera_to_current``."""
        said = self.scorer.assessed(self.scan.points, candidates)
        scores = 1 + said.scores
        if self.model is not None:  # how sure both together are, the network alone cannot say
            by_model = np.array([each.score for each in self.model.assess(belief, candidates, tolerance)])
            both = weighted(by_model, scores, trust(belief, fused=self.model.fused))
            return tuple(Assessment(float(score), None, None) for score in both)
        sigmas = [None] * len(scores) if said.sigma is None else said.sigma.tolist()
        return tuple(Assessment(score, None, None, sigma) for score, sigma in zip(scores.tolist(), sigmas, strict=True))

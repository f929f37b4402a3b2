"""A trained network that says how well a box's volume would be measured from each candidate, alone and with the model."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from viewgain.arrays import Mask, Poses, Vector
from viewgain.geometry import inverse
from viewgain.inference import PoseScorer
from viewgain.plan._adapters import OnBelief
from viewgain.plan._belief import Belief
from viewgain.plan._expected import ExpectedErrorPolicy
from viewgain.plan._opinions import weighted
from viewgain.plan._policy import Assessment
from viewgain.plan._rehearsed import RehearsedPolicy
from viewgain.plan._views import Seen, ViewPolicy
from viewgain.scans import Scan

ALONE, FUSED = (0.75, 0.75), (1.0, 0.5)
"""Weights of the model where every dimension is bounded, and where one is open: of what a candidate's scan says alone
(``python -m benchmarks trust``), and of what it says together with the present one."""
NOTHING_MEASURED = 0.0
"""Its weight where no box could be measured."""

Model: TypeAlias = ExpectedErrorPolicy | RehearsedPolicy
"""A policy that says what error is to be expected, from what is believed about the box."""
BESIDE_NETWORK: Mapping[str, Model | None] = {
    "network": None,
    "combined": ExpectedErrorPolicy(),
    "rehearsed": RehearsedPolicy(fused=True),
}
"""The model that each of these policies has beside its network where a next view is fused with what is known; None for none."""


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


def trust_in(model: Model, belief: Belief | None) -> float:
    """Return the weight of a model beside a network: :func:`trust`, but all of it where the model rehearses.

    Who tries views out on the box that was measured finds by itself what formula and network disagree about. Chosen for a
    candidate's scan alone, on boxes that no table uses (docs/volume_nbv.md), and kept for scans that are fused.
    """
    if isinstance(model, RehearsedPolicy) and belief is not None and not belief.guessed:
        return 1.0
    return trust(belief, fused=model.fused)


@dataclass(frozen=True, slots=True, eq=False)
class CombinedPolicy:
    """The model where a box is known, with a say for the network, and the network alone where none is (:func:`trust_in`).

    Both score in the same unit up to a constant: by minus the expected relative error.
    """

    model: OnBelief[Model]
    """The model-based policy."""
    network: ViewPolicy
    """The network."""
    name: str = "combined"

    def trust(self, belief: Belief | None) -> float:
        """Return the weight of the model beside the network (:func:`trust_in`)."""
        return trust_in(self.model.policy, belief)

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) weighted means; where one of the two has no opinion the other's, NaN where neither has."""
        known = self.model.measuring(seen)
        belief = self.model.belief(known)
        return weighted(self.model.scored(belief, known), self.network.scores(known), self.trust(belief))


@dataclass(frozen=True, slots=True, eq=False)
class VolumeNetworkAboutBox:
    """The network where :func:`viewgain.plan.next_view` asks about a box, alone or combined with a model (:func:`trust_in`).

    Scores are 1 minus the expected error after the candidate, so what next_view makes of nearly equal scores holds for them too.
    """

    scorer: PoseScorer
    """The network."""
    scan: Scan
    """The camera as it stands."""
    model: Model | None = None
    """The model-based policy to combine it with; None for the network alone."""

    @property
    def name(self) -> str:
        """Says who decides, one of :data:`BESIDE_NETWORK`."""
        return next(name for name, model in BESIDE_NETWORK.items() if isinstance(self.model, type(model)))

    def among(self, reachable: Mask) -> "VolumeNetworkAboutBox":
        """Return the policy whose model rehearses, if it does, none but those (V,) candidates."""
        return replace(self, model=self.model.among(reachable)) if isinstance(self.model, RehearsedPolicy) else self

    def assess(self, belief: Belief, candidates: Poses, tolerance: float) -> tuple[Assessment, ...]:
        """Return one assessment per candidate, (v, 4, 4) ``camera_to_current``; where one of the two decides alone, its own."""
        if self.model is None:
            return self._by_network(candidates)
        weight = trust_in(self.model, belief)
        if weight == 0.0:
            return self._by_network(candidates)
        by_model = self.model.assess(belief, candidates, tolerance)
        if weight == 1.0:
            return by_model
        one, two = (np.array([each.score for each in said]) for said in (by_model, self._by_network(candidates)))
        return tuple(Assessment(score, None, None) for score in weighted(one, two, weight).tolist())  # nobody knows how sure

    def _by_network(self, candidates: Poses) -> tuple[Assessment, ...]:
        said = self.scorer.assessed(self.scan.points, candidates)
        scores = 1 + said.scores
        sigmas = [None] * len(scores) if said.sigma is None else said.sigma.tolist()
        return tuple(Assessment(score, None, None, sigma) for score, sigma in zip(scores.tolist(), sigmas, strict=True))

"""A trained network that says how well a box's volume would be measured from each candidate, and the mean of it and the model."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Poses, Vector
from viewgain.geometry import inverse
from viewgain.inference import PoseScorer
from viewgain.plan._belief import Belief
from viewgain.plan._expected import ExpectedErrorPolicy
from viewgain.plan._policy import Assessment
from viewgain.plan._views import Seen, ViewPolicy
from viewgain.scans import Scan


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


@dataclass(frozen=True, slots=True, eq=False)
class MeanPolicy:
    """The weighted mean of two policies that score in the same unit up to a constant; where one has no opinion the other decides.

    The model-based policy and a network of volumes both score by minus the expected relative error. The model is exact where the
    box was measured, and silent or a guess where it was not; the network has seen what usually stands behind such a scan.
    """

    first: ViewPolicy
    second: ViewPolicy
    weight: float = 0.5
    """Of the first."""
    name: str = "combined"

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) means of the scores that are there; NaN where none is."""
        return self.mean(self.first.scores(seen), self.second.scores(seen))

    def mean(self, one: Vector, two: Vector) -> Vector:
        """Return (V,) weighted means of (V,) numbers of the first and of the second, of one where the other's is NaN."""
        mean = self.weight * one + (1 - self.weight) * two
        return np.where(np.isnan(one), two, np.where(np.isnan(two), one, mean))


@dataclass(frozen=True, slots=True, eq=False)
class VolumeNetworkAboutBox:
    """The network where :func:`viewgain.plan.next_view` asks about a box, alone or in the mean with the model.

    Scores are 1 minus the expected error after the candidate, so what next_view makes of nearly equal scores holds for them too.
    """

    scorer: PoseScorer
    """The network."""
    scan: Scan
    """The camera as it stands."""
    model: ExpectedErrorPolicy | None = None
    """The model-based policy to take the mean with; None for the network alone."""

    @property
    def name(self) -> str:
        """Says who decides."""
        return "network" if self.model is None else "combined"

    def assess(self, belief: Belief, candidates: Poses, tolerance: float) -> tuple[Assessment, ...]:
        """Return one assessment per candidate, (v, 4, 4) ``camera_to_current``."""
        said = self.scorer.assessed(self.scan.points, candidates)
        scores = 1 + said.scores
        if self.model is not None:  # how sure the mean is, the network alone cannot say
            by_model = np.array([each.score for each in self.model.assess(belief, candidates, tolerance)])
            return tuple(Assessment(float(score), None, None) for score in (scores + by_model) / 2)
        sigmas = [None] * len(scores) if said.sigma is None else said.sigma.tolist()
        return tuple(Assessment(score, None, None, sigma) for score, sigma in zip(scores.tolist(), sigmas, strict=True))

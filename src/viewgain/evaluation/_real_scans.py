"""What policies would do next on a real scan: nobody knows the truth there, so they are held beside each other."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np

from viewgain.arrays import Mask, Vector
from viewgain.errors import ConfigError
from viewgain.evaluation._map_values import rank_correlation
from viewgain.evaluation._network_choices import kind_and_file
from viewgain.evaluation._volume_choices import is_from_file
from viewgain.inference import PoseScorer
from viewgain.measure import POSE_SIGMA, Measurement, measure
from viewgain.plan import (
    BESIDE_NETWORK,
    Candidate,
    CovariancePolicy,
    ExpectedErrorPolicy,
    NextView,
    Policy,
    RehearsedPolicy,
    VolumeNetworkAboutBox,
    next_view,
    turn_about,
)
from viewgain.scans import Scan

ABOUT_BOX: Mapping[str, Policy] = {
    "covariance": CovariancePolicy(POSE_SIGMA),
    "expected": ExpectedErrorPolicy(),
    "rehearsed": RehearsedPolicy(fused=True),
}
"""Policies without a file: the certainty of the volume after fusing, the expected error after it, and that tried out."""
NEVER_SURE = 1 - 1e-9
"""Confidence asked for: policies are compared, and where to stop would be the answer one would not try anything out."""


@dataclass(frozen=True, slots=True)
class Stand:
    """Where a candidate stands, as seen from what it looks at."""

    turn_deg: float
    """From the present camera around the vertical, positive to the camera's right."""
    elevation_deg: float
    """Over the horizon."""
    distance: float
    """Metres."""


@dataclass(frozen=True, slots=True, eq=False)
class RealRanking:
    """One scan: what was measured, and where each policy would go."""

    source: str
    """The scan's name."""
    measured: Measurement
    """Its boxes, or the reason why there is none."""
    plans: Mapping[str, NextView]
    """By policy, in the order in which they were named; of the largest box in the image."""
    foretold: NextView
    """The same candidates by their predicted covariance: what is expected of any of them, whoever chose it."""

    @property
    def reachable(self) -> Mask:
        """(V,) candidates where a camera can stand."""
        return np.array([each.reachable for each in self.foretold.candidates], dtype=bool)

    @property
    def same_best(self) -> bool | None:
        """Whether all policies take the same candidate; None with fewer than two that take one."""
        places = [plan.best for plan in self.plans.values() if plan.best is not None]
        return None if len(places) < 2 else len(set(places)) == 1

    @property
    def correlation(self) -> float | None:
        """Mean rank correlation of the scores over all pairs of policies; None where none has one."""
        scores = [_scores(plan) for plan in self.plans.values() if plan.candidates]
        pairs = [rank_correlation(one, other, self.reachable) for one, other in combinations(scores, 2)]
        known = [each for each in pairs if each is not None]
        return float(np.mean(known)) if known else None

    def sigma_after(self, place: int) -> float | None:
        """Return the predicted standard deviation of the volume after a candidate, cubic metres."""
        after = self.foretold.candidates[place].assessment.outlook
        return None if after is None else after.volume_sigma

    def to_dict(self) -> dict[str, object]:
        """Return the JSON form (docs/volume_nbv.md)."""
        return {
            "scan": self.source,
            "measured": self.measured.to_dict(),
            "policies": [self._policy_dict(name, plan) for name, plan in self.plans.items()],
            "same_best": self.same_best,
            "mean_rank_correlation": None if self.correlation is None else round(self.correlation, 4),
        }

    def _policy_dict(self, name: str, plan: NextView) -> dict[str, object]:
        order = sorted((each for each in plan.candidates if each.reachable), key=lambda each: -each.assessment.score)
        return {
            "name": name,
            "best": plan.best,
            "reason": plan.reason,
            "ranking": [each.index for each in order],
            "candidates": [self._candidate_dict(plan, each) for each in plan.candidates],
        }

    def _candidate_dict(self, plan: NextView, candidate: Candidate) -> dict[str, object]:
        where, after = stand(plan, candidate), self.sigma_after(candidate.index)
        return {
            "index": candidate.index,
            "turn_deg": round(where.turn_deg, 2),
            "elevation_deg": round(where.elevation_deg, 2),
            "distance_m": round(where.distance, 4),
            "reachable": candidate.reachable,
            "score": round(candidate.assessment.score, 5),
            "predicted_volume_sigma_m3": None if after is None else float(f"{after:.4g}"),
        }


def ranked(scan: Scan, source: str, rig: str, policies: tuple[str, ...]) -> RealRanking:
    """Return what policies would do next after one scan: it is measured once, and the rig stands around its largest box.

    Args:
        scan: The scan.
        source: What to call it.
        rig: Preset name or path of a rig file.
        policies: Names, of :func:`check_real_policies`.

    Raises:
        ConfigError: If the rig cannot be placed: one of the world's positions, and the scan has no pose.
        ModelError: If a network cannot be used.
    """
    measured = measure(scan)
    plans = {name: next_view(measured, rig, policy=_policy(name, scan), confidence=NEVER_SURE) for name in policies}
    return RealRanking(source, measured, plans, next_view(measured, rig, policy=ABOUT_BOX["covariance"]))


def check_real_policies(names: tuple[str, ...]) -> None:
    """Refuse names of policies that are not known, given twice, or none; and files that hold no network of poses.

    Raises:
        ConfigError: Saying which.
        ModelError: If a network cannot be used.
    """
    for name in names:
        if is_from_file(name, BESIDE_NETWORK):
            _network(kind_and_file(name)[1])
        elif name not in ABOUT_BOX:
            known = ", ".join([*ABOUT_BOX, *(f"{kind}:FILE" for kind in BESIDE_NETWORK)])
            raise ConfigError(f"policy {name!r} is not known, or knows no single scan; choose from {known}")
    if not names or len(set(names)) < len(names):
        raise ConfigError(f"policies: got {', '.join(names) or 'none'}, wanted one or more, each once")


def stand(plan: NextView, candidate: Candidate) -> Stand:
    """Return where a candidate of a plan stands."""
    before, after = -plan.target, candidate.camera_to_current[:3, 3] - plan.target
    distance = float(np.linalg.norm(after))
    elevation = float(np.rad2deg(np.arcsin(np.clip(after @ plan.up / distance, -1, 1))))
    return Stand(turn_about(before, after, plan.up), elevation, distance)


def _policy(name: str, scan: Scan) -> Policy:
    if name in ABOUT_BOX:
        return ABOUT_BOX[name]
    kind, file = kind_and_file(name)
    return VolumeNetworkAboutBox(_network(file), scan, BESIDE_NETWORK[kind])


@lru_cache(maxsize=4)
def _network(file: str) -> PoseScorer:
    return PoseScorer.load(file)


def _scores(plan: NextView) -> Vector:
    return np.array([each.assessment.score for each in plan.candidates])

"""The answer to where the camera should go next: the ranked candidates and the decision, and their JSON form."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Pose, Vector3
from viewgain.measure import Measurement
from viewgain.plan._policy import Assessment
from viewgain.plan._predict import MIN_FACE_PIXELS

SCHEMA = 1
"""Version of the JSON form; it grows by new keys only."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """One station of the rig and what going there would bring."""

    index: int
    """Place in rig order."""
    camera_to_current: Pose
    """(4, 4) its pose in the present camera's frame."""
    assessment: Assessment
    """The policy's view of it."""
    reachable: bool
    """Whether the rig's limits allow it."""

    @property
    def travel(self) -> float:
        """Distance from the present camera, metres."""
        return float(np.linalg.norm(self.camera_to_current[:3, 3]))

    def to_dict(self) -> dict[str, object]:
        """Return the JSON form (docs/json.md)."""
        after, prediction = self.assessment.outlook, self.assessment.prediction
        return {
            "index": self.index,
            "camera_to_current": np.round(self.camera_to_current, 6).tolist(),
            "score": round(self.assessment.score, 5),
            "score_sigma": None if self.assessment.sigma is None else float(f"{self.assessment.sigma:.4g}"),
            "volume_sigma_m3": None if after is None else float(f"{after.volume_sigma:.4g}"),
            "p_within_tolerance": None if after is None else round(after.within_tolerance, 4),
            "faces": [] if prediction is None else [
                {"name": s.name, "incidence_deg": round(float(np.rad2deg(s.incidence)), 1), "returns": round(s.returns)}
                for s in prediction.sights if s.returns >= MIN_FACE_PIXELS
            ],
            "cut": None if prediction is None else prediction.cut,
            "border_share": None if prediction is None else round(prediction.border, 4),
            "reachable": self.reachable,
        }  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class NextView:
    """The ranked candidates and the decision."""

    rig: str
    """Name of the rig."""
    policy: str
    """Name of the policy that decided."""
    current: Measurement
    """What is measured now."""
    candidates: tuple[Candidate, ...]
    """Every station, in rig order; empty if there is a reason."""
    best: int | None
    """Index of the best reachable candidate, or None."""
    stop: bool
    """Whether the volume is already known as well as asked for."""
    within_tolerance: float | None
    """Probability now that the relative volume error is under the tolerance."""
    tolerance: float
    """Relative volume error asked for."""
    confidence: float
    """Probability asked for."""
    target: Vector3
    """(3,) what the candidates look at, metres, present camera's frame; zeros if there are none."""
    up: Vector3
    """(3,) the floor's normal, present camera's frame; zeros if there is no floor."""
    reason: str | None
    """Why nothing can be planned: ``no_floor``, ``nothing_on_floor``, ``no_reachable_view``, ``abstains``, or None."""
    objective: str = "volume"
    abstention: str | None = None
    """In words why the policy, or who judges it, stands by no choice; None where they do, or are not asked."""
    nearly_best: float | None = None
    """Chance that no other view in reach is better by two points of volume error than the one that would be chosen; None where
    nobody was asked."""

    def to_dict(self) -> dict[str, object]:
        """Return the versioned JSON form (docs/json.md)."""
        return {
            "schema": SCHEMA,
            "rig": self.rig,
            "objective": self.objective,
            "policy": self.policy,
            "current": self.current.to_dict(),
            "candidates": [candidate.to_dict() for candidate in self.candidates],
            "best": self.best,
            "stop": self.stop,
            "p_within_tolerance": None if self.within_tolerance is None else round(self.within_tolerance, 4),
            "tolerance": self.tolerance,
            "confidence": self.confidence,
            "reason": self.reason,
            "abstention": self.abstention,
            "p_nearly_best": None if self.nearly_best is None else round(self.nearly_best, 4),
        }

"""The next best view: believe, place the rig, score every candidate, decide, and say whether to stop."""

from dataclasses import dataclass, replace

import numpy as np

from viewgain.arrays import Pose, Poses, Vector3
from viewgain.camera import Sensor
from viewgain.errors import ConfigError
from viewgain.geometry import inverse
from viewgain.measure import POSE_SIGMA, Measurement, fuse, measure, sensor_of
from viewgain.plan._belief import Belief, belief_from, belief_from_blob, certainty, floor_pose
from viewgain.plan._doubt import Hesitant
from viewgain.plan._policy import Assessment, CovariancePolicy, Delegating, Policy
from viewgain.plan._predict import MIN_FACE_PIXELS, predict
from viewgain.rigs import Rig, Station, Target, place, refusals
from viewgain.rigs import rig as find_rig
from viewgain.scans import Scan

SCHEMA = 1
"""Version of the JSON form; it grows by new keys only."""
STEPS_BACK = (1.0, 1.15, 1.3, 1.5, 1.75, 2.0)
"""Factors on the present distance that are tried until the box fits into the image."""
STAYING = 0.05
"""A candidate nearer to the present camera than this is the present place, metres."""
OBJECTIVES = ("volume", "coverage")
"""What can be asked for."""
INDIFFERENT = 0.03
"""Of candidates that leave a standard deviation within this share of the least, the nearest is taken."""


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
    """In words why the policy stands by no choice; None where it does, or is not asked."""

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
        }


def next_view(
    current: Scan | list[Scan] | Measurement,
    rig: str | Rig = "ring8",
    *,
    objective: str = "volume",
    policy: Policy | None = None,
    camera: str | Sensor | None = None,
    tolerance: float = 0.05,
    confidence: float = 0.95,
    pose_sigma: tuple[float, float] = POSE_SIGMA,
) -> NextView:
    """Rank the stations of a rig by how well the box's volume would be known after going there.

    Of several boxes the largest in the image is planned for. Where nothing could be measured, the largest rejected object is
    looked at as a blob of unknown size, so the question is answered when it is needed most.

    Args:
        current: A scan, several (fused, with poses or without; the last is the camera as it stands), or an earlier measurement.
        rig: Preset name, path of a rig file, or a rig.
        objective: ``volume``, or ``coverage`` with a policy that scores it (:class:`NetworkPolicy`); it never says stop.
        policy: Who scores; default the model-based :class:`CovariancePolicy`.
        camera: Preset name or sensor; default estimated from the scan. Its image is that of the scan where that has one.
        tolerance: Relative volume error asked for.
        confidence: Probability asked for: stop when P(error < tolerance) exceeds it.
        pose_sigma: Standard deviation of camera poses, metres and radians per axis.

    Returns:
        The ranking; with no candidates and a reason if there is no floor or nothing on it.

    Raises:
        ConfigError: If rig, objective, tolerance or confidence make no sense, or the last of several scans without poses shares
            no box with the others, so that nobody knows where the camera stands.
    """
    stations = find_rig(rig)
    if objective not in OBJECTIVES:
        raise ConfigError(f"objective {objective!r} is not known; choose {' or '.join(OBJECTIVES)}")
    if objective == "coverage" and policy is None:
        raise ConfigError("objective coverage wants a policy that scores it; give one, such as NetworkPolicy (--policy network)")
    if not 0 < tolerance < 1 or not 0 < confidence < 1:
        raise ConfigError(f"got tolerance {tolerance} and confidence {confidence}, wanted both between 0 and 1")
    decider = policy or CovariancePolicy(pose_sigma)
    measured = _measured(current, camera, pose_sigma)
    _require_standpoint(measured)
    believed = believe(measured, sensor_of(camera))
    if believed is None:
        nowhere, nothing = np.zeros(3), measured.reason
        return NextView(
            stations.name,
            decider.name,
            measured,
            (),
            None,
            False,
            None,
            tolerance,
            confidence,
            nowhere,
            nowhere,
            nothing,
            objective,
        )
    if isinstance(decider, Delegating):
        decider = decider.deciding(believed)
    back = _step_back(believed)
    poses = place(stations, _target(believed), floor_pose(believed), measured.camera_to_world, step_back=back)
    assessments = decider.assess(believed, poses, tolerance)
    if objective == "volume":
        assessments = _told(assessments, CovariancePolicy(pose_sigma), believed, poses, tolerance)
    candidates = tuple(
        Candidate(index, pose, assessment, reachable)
        for index, (pose, assessment, reachable) in enumerate(
            zip(poses, assessments, _reachable(poses, believed, stations, measured.camera_to_world), strict=True)
        )
    )
    for_volume = objective == "volume"
    best = _best(candidates, settle=believed.bounded and for_volume, indifferent=INDIFFERENT if for_volume else 0.0)
    sure = certainty(believed, tolerance=tolerance, confidence=confidence)
    reason, abstention = "no_reachable_view" if best is None else None, None
    if best is not None and isinstance(decider, Hesitant):
        abstention = decider.abstention(assessments, np.array([candidate.reachable for candidate in candidates]), best)
        best, reason = (best, None) if abstention is None else (None, "abstains")
    target, up = believed.mean.centre, believed.mean.floor.normal
    return NextView(
        stations.name,
        decider.name,
        measured,
        candidates,
        best,
        for_volume and sure.enough,
        sure.within_tolerance,
        tolerance,
        confidence,
        target,
        up,
        reason,
        objective,
        abstention,
    )


def _told(
    assessments: tuple[Assessment, ...], model: CovariancePolicy, belief: Belief, candidates: Poses, tolerance: float
) -> tuple[Assessment, ...]:
    """Return the assessments with what the model expects of each candidate where the policy that scored them does not say."""
    if all(each.outlook is not None for each in assessments):
        return assessments
    expected = model.assess(belief, candidates, tolerance)
    return tuple(
        replace(each, outlook=each.outlook or by_model.outlook, prediction=each.prediction or by_model.prediction)
        for each, by_model in zip(assessments, expected, strict=True)
    )


def _measured(
    current: Scan | list[Scan] | Measurement, camera: str | Sensor | None, pose_sigma: tuple[float, float]
) -> Measurement:
    if isinstance(current, Measurement):
        return current
    if isinstance(current, Scan):
        return measure(current, camera=camera)
    return fuse(current, camera=camera, pose_sigma=pose_sigma)


def _require_standpoint(measured: Measurement) -> None:
    """Refuse fused scans of which the last has no place among the others: the way from there is unknown."""
    if measured.camera_poses and measured.camera_poses[-1] is None:
        raise ConfigError(
            f"next view: {measured.scans[-1]} shares no box with the other scans, so the camera's place is unknown; give poses,"
            " or a last scan that shows the box"
        )


def believe(measured: Measurement, sensor: Sensor) -> Belief | None:
    """Return what is believed about the largest box in the image, or the largest rejected object; None without either."""
    if measured.boxes:
        return belief_from(measured.boxes[0])
    if not measured.rejected:
        return None
    blob = measured.rejected[0]
    return belief_from_blob(blob, measured, sensor) if blob.estimate is None else belief_from(blob.estimate)


def _step_back(belief: Belief) -> float:
    """Return the least factor on the present distance at which the believed box fits into the image; the largest if none does.

    A camera too near cuts the box from every side of a ring; going around at the same distance would not help.
    """
    here = Rig(name="here", stations=(Station(),))
    for factor in STEPS_BACK:
        (pose,) = place(here, _target(belief), floor_pose(belief), None, step_back=factor)
        if not predict(belief.mean, pose, belief.sensor, belief.noise).cut:
            return factor
    return STEPS_BACK[-1]


def _target(belief: Belief) -> Target:
    """Return what the candidates stand around: the middle box, in the floor's frame."""
    return Target(inverse(floor_pose(belief)) @ belief.mean.box_to_camera, belief.mean.extents)


def _reachable(poses: Poses, belief: Belief, stations: Rig, camera_to_world: Pose | None) -> tuple[bool, ...]:
    """Return which candidates the rig and the camera's least range allow, next to what has been seen: the smallest box."""
    seen = belief.boxes[0]  # its own frame has its floor at z = 0
    limits = replace(stations, min_distance=max(stations.min_distance, belief.sensor.range_min))
    world = None if camera_to_world is None else camera_to_world @ seen.box_to_camera
    cameras = inverse(seen.box_to_camera) @ poses
    return tuple(reason is None for reason in refusals(limits, cameras, Target(np.eye(4), seen.extents), floor_to_world=world))


def _best(candidates: tuple[Candidate, ...], *, settle: bool, indifferent: float = INDIFFERENT) -> int | None:
    """Return the reachable candidate with the best score, the nearest of those within a hair of it.

    Where a dimension is still open (not ``settle``) the present place is no answer to a tie: it has just failed to show it.
    """
    reachable = [candidate for candidate in candidates if candidate.reachable]
    if not reachable:
        return None
    top = max(candidate.assessment.score for candidate in reachable)
    least = top - indifferent * abs(1 - top)
    tied = [candidate for candidate in reachable if candidate.assessment.score >= least]
    elsewhere = [candidate for candidate in tied if candidate.travel > STAYING]
    return min(tied if settle or not elsewhere else elsewhere, key=lambda candidate: candidate.travel).index

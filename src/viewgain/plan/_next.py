"""The next best view: believe, place the rig, score every candidate, decide, and say whether to stop."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from viewgain.arrays import Poses
from viewgain.camera import Sensor
from viewgain.errors import ConfigError
from viewgain.geometry import inverse
from viewgain.measure import POSE_SIGMA, Measurement, fuse, measure, sensor_of
from viewgain.plan._around import reachable_of, step_back, target_of
from viewgain.plan._belief import Belief, certainty, floor_pose
from viewgain.plan._believed import believe
from viewgain.plan._doubt import Hesitant
from viewgain.plan._judge import VolumeJudge
from viewgain.plan._next_view import Candidate, NextView
from viewgain.plan._place import Place
from viewgain.plan._policy import Assessment, CovariancePolicy, Delegating, Policy, Selecting
from viewgain.rigs import Rig
from viewgain.rigs import place as stand
from viewgain.rigs import rig as find_rig
from viewgain.scans import Scan

STAYING = 0.05
"""A candidate nearer to the present camera than this is the present place, metres."""
OBJECTIVES = ("volume", "coverage")
"""What can be asked for."""
INDIFFERENT = 0.03
"""Of candidates that leave a standard deviation within this share of the least, the nearest is taken."""


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
    judge: VolumeJudge | None = None,
    place: Place | None = None,
    scan: Scan | None = None,
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
        judge: Who says how likely the choice is nearly the best, and below which chance it is not stood by; for the volume only.
        place: Where the box's centre is known to be before looking, in the world of the last scan's pose (z up); None where
            nobody knows. It chooses among the lengths of dimensions that are open, and among boxes that explain a last scan in
            which nothing can be measured; what is measured it does not change.
        scan: The last scan, where ``current`` is a measurement and there is a place. Without it, or with one of another pose,
            nothing is made of a scan in which nothing could be measured, and neither for another objective than the volume.

    Returns:
        The ranking; with no candidates and a reason if there is no floor or nothing on it, and no place and scan.

    Raises:
        ConfigError: If rig, objective, tolerance, confidence or judge make no sense, if the last of several scans without poses
            shares no box with the others, so that nobody knows where the camera stands, or a place is given and no pose.
    """
    stations = find_rig(rig)
    if objective not in OBJECTIVES:
        raise ConfigError(f"objective {objective!r} is not known; choose {' or '.join(OBJECTIVES)}")
    if objective == "coverage" and policy is None:
        raise ConfigError("objective coverage wants a policy that scores it; give one, such as NetworkPolicy (--policy network)")
    if objective != "volume" and judge is not None:
        raise ConfigError(f"objective {objective}: got a judge of choices for the volume; give none")
    if not 0 < tolerance < 1 or not 0 < confidence < 1:
        raise ConfigError(f"got tolerance {tolerance} and confidence {confidence}, wanted both between 0 and 1")
    decider = policy or CovariancePolicy(pose_sigma)
    measured = _measured(current, camera, pose_sigma)
    _require_standpoint(measured)
    scans = _scans(current, scan) if objective == "volume" else ()
    believed = believe(measured, sensor_of(camera), _before_the_camera(place, measured), scans)
    nothing = NextView(
        rig=stations.name,
        policy=decider.name,
        current=measured,
        candidates=(),
        best=None,
        stop=False,
        within_tolerance=None,
        tolerance=tolerance,
        confidence=confidence,
        target=np.zeros(3),
        up=np.zeros(3),
        reason=measured.reason,
        objective=objective,
    )
    if believed is None:
        return nothing
    if isinstance(decider, Delegating):
        decider = decider.deciding(believed)
    back = step_back(believed)
    poses = stand(stations, target_of(believed), floor_pose(believed), measured.camera_to_world, step_back=back)
    reachable = reachable_of(poses, believed, stations, measured.camera_to_world)
    for_volume = objective == "volume"
    sure = certainty(believed, tolerance=tolerance, confidence=confidence)
    stop = for_volume and sure.enough
    if isinstance(decider, Selecting):
        decider = decider.among(np.array(reachable) & (not stop))  # who stays is spared the effort
    assessments = decider.assess(believed, poses, tolerance)
    if for_volume:
        assessments = _told(assessments, CovariancePolicy(pose_sigma), believed, poses, tolerance)
    candidates = tuple(
        Candidate(index, pose, assessment, allowed)
        for index, (pose, assessment, allowed) in enumerate(zip(poses, assessments, reachable, strict=True))
    )
    best = _best(candidates, settle=believed.bounded and for_volume, indifferent=INDIFFERENT if for_volume else 0.0)
    reason, abstention, chance = "no_reachable_view" if best is None else None, None, None
    if best is not None and isinstance(decider, Hesitant):
        abstention = decider.abstention(assessments, np.array(reachable), best)
    if best is not None and judge is not None:
        chance = judge.chance(believed, poses, np.array(reachable), best)
        abstention = abstention or judge.abstention(chance, best)
    if abstention is not None:
        best, reason = None, "abstains"
    return replace(
        nothing,
        policy=decider.name,
        candidates=candidates,
        best=best,
        stop=stop,
        within_tolerance=sure.within_tolerance,
        target=believed.mean.centre,
        up=believed.mean.floor.normal,
        reason=reason,
        abstention=abstention,
        nearly_best=chance,
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


def _scans(current: Scan | list[Scan] | Measurement, scan: Scan | None) -> Sequence[Scan]:
    """Return the scans that are at hand."""
    if isinstance(current, Measurement):
        return () if scan is None else (scan,)
    return (current,) if isinstance(current, Scan) else current


def _before_the_camera(place: Place | None, measured: Measurement) -> Place | None:
    """Return a place in the world in the present camera's frame."""
    if place is None:
        return None
    if measured.camera_to_world is None:
        raise ConfigError(f"place: got {measured.scans[-1]} without a pose, wanted camera_to_world, in whose world the place is")
    return place.in_frame(inverse(measured.camera_to_world))


def _require_standpoint(measured: Measurement) -> None:
    """Refuse fused scans of which the last has no place among the others: the way from there is unknown."""
    if measured.camera_poses and measured.camera_poses[-1] is None:
        raise ConfigError(
            f"next view: {measured.scans[-1]} shares no box with the other scans, so the camera's place is unknown; give poses,"
            " or a last scan that shows the box"
        )


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

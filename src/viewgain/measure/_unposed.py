"""Several scans without camera poses, one estimate: each box gives the common frame, every camera's pose is free.

What remains open is which sides correspond. All likely answers are fitted jointly, and where they differ the estimate says so.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from viewgain.arrays import Array, Pose, Vector3
from viewgain.box import Box
from viewgain.geometry import inverse
from viewgain.measure._fit import Fit, View
from viewgain.measure._joint import UNKNOWN_POSE, estimate_of, joint_fit, seen_from
from viewgain.measure._match import Pooled, correspondences, extents_of, grown, quarter_turn
from viewgain.measure._register import Sighting, register
from viewgain.measure._result import BoxEstimate, Measurement
from viewgain.measure._uncertainty import Z90, Interval

MAX_WAYS = 4
"""At most this many ways in which sides may correspond are fitted jointly."""
LIKELY = 0.02
"""A way less probable than this is dropped."""
TEMPER = 0.25
"""Share of its log likelihood that a joint fit is believed when ways are compared: two views differ by up to twice their sigma
for reasons no model has (half the sigma is a quarter of the log)."""
_AMBIGUOUS = "the footprint is nearly square and its sides may correspond otherwise; the interval covers both"
_HALF_TURN = "camera poses come from a single box: each may be half a turn about it off, which no dimension depends on"


@dataclass(frozen=True, slots=True, eq=False)
class _Fused:
    """One fused box in the frame of one of its cameras."""

    estimate: BoxEstimate
    reference: int
    camera_to_reference: dict[int, Pose]


def fuse_without_poses(results: list[Measurement]) -> Measurement:
    """Return one measurement from at least one scan without poses.

    Args:
        results: Each scan measured alone.

    Returns:
        The boxes in the frame of the last scan that shares a box with the others, with ``camera_poses``. Boxes in one scan only
        are kept as measured; scans that share no box with the others are left out, and a note says so.
    """
    known = register(results)
    if len(known.camera_to_map) < 2:
        return _alone(results)
    frame = max(known.camera_to_map)
    fused = [_fuse_group(group, known.settled) for group in known.groups]
    wanted = [box for group, box in zip(known.groups, fused, strict=True) if _is_measured(group, box.estimate, results)]
    poses = _camera_poses(known.camera_to_map, wanted, frame)
    boxes = [box.estimate.in_frame(poses[box.reference]) for box in wanted]
    boxes.sort(key=lambda box: -box.quality.returns)
    return replace(
        results[frame],
        scans=tuple(name for result in results for name in result.scans),
        boxes=tuple(boxes),
        reason=None if boxes else results[frame].reason,
        notes=_notes(results, poses, boxes, settled=len(known.settled) == len(poses)),
        camera_poses=tuple(poses.get(k) for k in range(len(results))),
    )


def _alone(results: list[Measurement]) -> Measurement:
    """Return the last scan that shows a box, or the last scan, as it was measured."""
    shown = [k for k, result in enumerate(results) if result.boxes]
    frame = shown[-1] if shown else len(results) - 1
    poses = {frame: np.eye(4)}
    return replace(
        results[frame],
        scans=tuple(name for result in results for name in result.scans),
        notes=_notes(results, poses, [], settled=True),
        camera_poses=tuple(poses.get(k) for k in range(len(results))),
    )


def _is_measured(group: dict[int, Sighting], fused: BoxEstimate, results: list[Measurement]) -> bool:
    """Return whether a box is one in some scan, or several that each left it unbounded bound it together."""
    if any(sight.estimate is box for k, sight in group.items() for box in results[k].boxes):
        return True
    return len(group) > 1 and not any(fused.is_open) and not fused.quality.cut


def _notes(results: list[Measurement], poses: dict[int, Pose], boxes: list[BoxEstimate], *, settled: bool) -> tuple[str, ...]:
    notes = [note for result in results for note in result.notes]
    notes += [
        f"{', '.join(r.scans)}: shares no box with the other scans; left out" for k, r in enumerate(results) if k not in poses
    ]
    notes += [_AMBIGUOUS] if any("ambiguous" in box.flags for box in boxes) else []
    return (*notes, *([] if settled else [_HALF_TURN]))


def _fuse_group(group: dict[int, Sighting], settled: frozenset[int]) -> _Fused:
    """Return one box from its sightings, in the frame of the last of their cameras."""
    reference = max(group)
    if len(group) == 1:
        return _Fused(group[reference].estimate, reference, {reference: np.eye(4)})
    order = [reference, *(k for k in group if k != reference)]
    turns = [(group[k].quarters - group[reference].quarters) % 4 if {k, reference} <= settled else None for k in order]
    estimate = fuse_sightings([group[k].estimate for k in order], turns)
    poses = [np.eye(4) if v.reference_to_camera is None else inverse(v.reference_to_camera) for v in estimate.views]
    return _Fused(estimate, reference, dict(zip(order, poses, strict=True)))


def fuse_sightings(parts: list[BoxEstimate], known_turns: Sequence[int | None]) -> BoxEstimate:
    """Return one box from several scans of it, in the first one's camera frame.

    Args:
        parts: At least two estimates of the box, each in its own camera's frame.
        known_turns: Quarter-turns from each one's axes to the first's, where settled; the first entry is not looked at.
    """
    ways = _likely(correspondences([extents_of(part) for part in parts], known_turns))
    fits = [_fit(parts, way, pool) for way, pool in ways]
    weights = _normalised(TEMPER * np.array([fit.value for fit in fits]))
    best = int(np.argmax(weights))
    rivals = [fit.box.extents for k, fit in enumerate(fits) if k != best and weights[k] >= LIKELY]
    return _covering(estimate_of(seen_from(fits[best], 0), parts, None), rivals)


def _likely(ways: list[tuple[tuple[int, ...], Pooled]]) -> list[tuple[tuple[int, ...], Pooled]]:
    weights = _normalised(np.array([pool.log_weight for _, pool in ways]))
    return [way for way, weight in zip(ways, weights, strict=True) if weight >= LIKELY * weights[0]][:MAX_WAYS]


def _normalised(log_weights: Array) -> Array:
    weights = np.exp(log_weights - log_weights.max())
    return np.asarray(weights / weights.sum())


def _fit(parts: list[BoxEstimate], way: tuple[int, ...], pool: Pooled) -> Fit:
    """Return the joint fit under one correspondence, every camera but the first free to stand anywhere."""
    start = grown(parts[0], pool.values)
    views = [parts[0].views[0]]
    views += [_placed(part, turn, pool.values, start) for part, turn in zip(parts[1:], way[1:], strict=True)]
    return joint_fit([start], tuple(views))


def _placed(part: BoxEstimate, quarters: int, extents: Vector3, start: Box) -> View:
    """Return a view placed so that it sees the box where it measured it."""
    own = grown(part, extents[[1, 0, 2]] if quarters % 2 else extents)
    reference_to_camera = own.box_to_camera @ quarter_turn(-quarters) @ inverse(start.box_to_camera)
    return replace(part.views[0], reference_to_camera=reference_to_camera, pose_precision=UNKNOWN_POSE)


def _covering(estimate: BoxEstimate, rivals: list[Vector3]) -> BoxEstimate:
    """Return the estimate with intervals that hold the rivals' extents too, and a flag, where those are over a sigma away."""
    spread, intervals = estimate.covariance.copy(), list(estimate.intervals)
    sigma = np.array([interval.sigma for interval in intervals])
    far = [rival - estimate.box.extents for rival in rivals if np.any(np.abs(rival - estimate.box.extents) > sigma)]
    if not far:
        return estimate
    apart = max(far, key=lambda gap: float(np.linalg.norm(gap)))
    spread[6:, 6:] += np.outer(apart, apart)
    for axis, (value, interval) in enumerate(zip(estimate.box.extents, intervals, strict=True)):
        if np.isfinite(interval.sigma):
            sd = float(np.hypot(interval.sigma, apart[axis]))
            low, high = float(value) - Z90 * sd, float(value) + Z90 * sd
            intervals[axis] = Interval(min(interval.low, low), max(interval.high, high), sd)
    x, y, z = intervals
    return replace(estimate, covariance=spread, intervals=(x, y, z), flags=(*estimate.flags, "ambiguous"))


def _camera_poses(camera_to_map: dict[int, Pose], boxes: list[_Fused], frame: int) -> dict[int, Pose]:
    """Return the pose of each registered camera in the frame of one of them: of the joint fit of the box most views share."""
    poses = {k: inverse(camera_to_map[frame]) @ camera for k, camera in camera_to_map.items()}
    shared = [box for box in boxes if box.reference == frame]
    if shared:
        largest = max(shared, key=lambda box: (len(box.camera_to_reference), box.estimate.quality.returns))
        poses |= largest.camera_to_reference
    return poses

"""Several scans, one estimate: the likelihoods multiply, pose errors are estimated along. Without poses: ``_unposed``."""

from dataclasses import replace

import numpy as np

from viewgain.arrays import Pose
from viewgain.box import Box
from viewgain.camera import Sensor
from viewgain.errors import ConfigError
from viewgain.geometry import inverse, pose, transform
from viewgain.measure._fit import View
from viewgain.measure._joint import estimate_of, joint_fit, own_precision, seen_from
from viewgain.measure._measure import measure
from viewgain.measure._result import BoxEstimate, Measurement
from viewgain.measure._unposed import fuse_without_poses
from viewgain.scans import Scan

POSE_SIGMA = (0.003, float(np.deg2rad(0.3)))
"""Default standard deviation of a camera pose per axis: 3 mm and 0.3 degrees, a small robot arm with a hand-eye calibration."""


def fuse(
    scans: list[Scan],
    *,
    camera: str | Sensor | None = None,
    floor: Scan | None = None,
    pose_sigma: tuple[float, float] = POSE_SIGMA,
) -> Measurement:
    """Measure the boxes that several scans show, all views together.

    Each scan is measured alone; estimates of the same box are then refined jointly on all their pixels (docs/fusing.md). With
    poses, boxes are the same whose centres lie within half their size in the world (all of it where one is open), and each
    camera has six pose corrections held by ``pose_sigma``. Without poses, boxes are the same whose sizes and places on the floor
    agree, and where the cameras stood comes out of the fit.
    Objects that one scan alone leaves unbounded (``cut_by_border``) take part: together they may be bounded.

    Args:
        scans: At least one scan, all with ``camera_to_world`` or none; the last is the camera as it stands.
        camera: As in :func:`measure`.
        floor: Empty scene seen from the last camera, used for that scan.
        pose_sigma: Standard deviation of each camera pose, metres and radians per axis; not looked at without poses.

    Returns:
        A measurement in the frame of the last scan's camera. A box seen in one scan only is kept as that scan measured it.
        Without poses, in the frame of the last scan that shares a box with the others, with ``camera_poses``; scans that share
        none are left out, and a note says so.

    Raises:
        ConfigError: If there is no scan, or some have a pose and some have none.
    """
    if not scans:
        raise ConfigError("fuse: got no scan, wanted at least one")
    _require_all_or_none([(scan.source, scan.camera_to_world is not None) for scan in scans])
    results = [measure(scan, camera=camera, floor=floor if scan is scans[-1] else None) for scan in scans]
    return fuse_measurements(results, pose_sigma=pose_sigma)


def fuse_measurements(results: list[Measurement], *, pose_sigma: tuple[float, float] = POSE_SIGMA) -> Measurement:
    """Return one measurement from several single-scan ones (as :func:`fuse`, without measuring again)."""
    if not results:
        raise ConfigError("fuse: got no scan, wanted at least one")
    last = results[-1]
    if len(results) == 1:
        return last
    _require_all_or_none([(", ".join(result.scans), result.camera_to_world is not None) for result in results])
    if last.camera_to_world is None:
        return fuse_without_poses(results)
    worlds = [result.world for result in results]
    known = {id(box) for result in results for box in result.boxes}
    groups = [(group, _fused(group, worlds, pose_sigma)) for group in _same_boxes(results, worlds)]
    measured = [box for group, box in groups if any(id(b) in known for b in group.values()) or _settled(group, box)]
    boxes = tuple(sorted(measured, key=lambda box: -box.quality.returns))
    names = tuple(name for result in results for name in result.scans)
    return replace(last, scans=names, boxes=boxes, reason=None if boxes else last.reason)


def _require_all_or_none(posed: list[tuple[str, bool]]) -> None:
    """Refuse scans of which some have a camera pose and some have none, naming the first without."""
    without = [name for name, has_pose in posed if not has_pose]
    if without and len(without) < len(posed):
        raise ConfigError(
            f"{without[0]}: has no camera pose, but other scans have; give camera_to_world for all scans or for none"
        )


def _settled(group: dict[int, BoxEstimate], fused: BoxEstimate) -> bool:
    """Return whether scans that each left a box unbounded bound it together: one of them at least shows its whole outline."""
    return len(group) > 1 and not any(fused.is_open) and not fused.quality.cut


def _same_boxes(results: list[Measurement], worlds: list[Pose]) -> list[dict[int, BoxEstimate]]:
    """Return the estimates grouped by box: each group maps the index of a scan to its estimate."""
    groups: list[dict[int, BoxEstimate]] = []
    for index, result in enumerate(results):
        for box in result.candidates:
            centre = transform(worlds[index], box.box.centre)
            for group in groups:
                first = next(iter(group))
                known = transform(worlds[first], group[first].box.centre)
                share = 1.0 if any(box.is_open) or any(group[first].is_open) else 0.5
                reach = share * max(float(np.max(box.box.extents)), float(np.max(group[first].box.extents)))
                if index not in group and np.linalg.norm(centre - known) < reach:
                    group[index] = box
                    break
            else:
                groups.append({index: box})
    return groups


def _fused(group: dict[int, BoxEstimate], worlds: list[Pose], pose_sigma: tuple[float, float]) -> BoxEstimate:
    """Return one box from its estimates by scan, in the frame of the last camera."""
    reference_to_world = worlds[-1]
    best = min(
        group, key=lambda index: (any(group[index].is_open), group[index].quality.cut, np.trace(group[index].covariance[6:, 6:]))
    )
    alone = {index: estimate.box.in_frame(inverse(reference_to_world) @ worlds[index]) for index, estimate in group.items()}
    start = alone[best]
    if len(group) == 1:
        return group[best].in_frame(inverse(reference_to_world) @ worlds[best])
    views = tuple(_placed(group[index].views[0], worlds[index], reference_to_world, start, pose_sigma) for index in group)
    fit = joint_fit([*alone.values(), _around(start, list(alone.values()))], views)
    last = len(worlds) - 1
    seen = seen_from(fit, list(group).index(last) if last in group else None)
    return estimate_of(seen, list(group.values()), own_precision(inverse(seen.box.box_to_camera), pose_sigma))


def _placed(view: View, camera_to_world: Pose, reference_to_world: Pose, box: Box, pose_sigma: tuple[float, float]) -> View:
    """Return a view with its place relative to where the reference camera believes to be, and how far off it may be itself."""
    reference_to_camera = inverse(camera_to_world) @ reference_to_world
    camera_to_box = inverse(reference_to_camera @ box.box_to_camera)
    return replace(view, reference_to_camera=reference_to_camera, pose_precision=own_precision(camera_to_box, pose_sigma))


def _around(box: Box, boxes: list[Box]) -> Box:
    """Return ``box`` grown to cover ``boxes`` too: each scan may have seen another end of a box that all of them cut."""
    corners = np.concatenate([transform(inverse(box.box_to_camera), other.corners()) for other in boxes])
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle = np.array([*(low[:2] + high[:2]) / 2, 0.0])
    return Box(box.box_to_camera @ pose(np.eye(3), middle), np.array([*(high[:2] - low[:2]), high[2]]))

"""Several scans with known camera poses, one estimate: the likelihoods multiply, the pose errors are estimated along."""

from dataclasses import replace

import numpy as np

from viewgain.arrays import Array, Pose
from viewgain.box import Box, adjoint
from viewgain.camera import Sensor
from viewgain.errors import ConfigError
from viewgain.geometry import inverse, pose, transform
from viewgain.measure._fit import COARSE, FINE, Fit, View, refine
from viewgain.measure._likelihood import Evaluation
from viewgain.measure._measure import measure, with_uncertainty
from viewgain.measure._pixels import thinned
from viewgain.measure._quality import FaceView, Quality, face_views, on_faces
from viewgain.measure._result import BoxEstimate, Measurement
from viewgain.scans import Scan

POSE_SIGMA = (0.003, float(np.deg2rad(0.3)))
"""Default standard deviation of a camera pose per axis: 3 mm and 0.3 degrees, a small robot arm with a hand-eye calibration."""

_COARSE_PIXELS = 1500


def fuse(
    scans: list[Scan],
    *,
    camera: str | Sensor | None = None,
    floor: Scan | None = None,
    pose_sigma: tuple[float, float] = POSE_SIGMA,
) -> Measurement:
    """Measure the boxes that several scans with known poses show, all views together.

    Each scan is measured alone; estimates of the same box (centres within half its size in the world, or all of it where it is
    open) are then refined jointly on all their pixels, with six pose corrections per further view held by ``pose_sigma``.
    Objects that one scan alone leaves unbounded (``cut_by_border``) take part: together they may be bounded.

    Args:
        scans: At least one scan, each with ``camera_to_world``; the last is the camera as it stands.
        camera: As in :func:`measure`.
        floor: Empty scene seen from the last camera, used for that scan.
        pose_sigma: Standard deviation of each camera pose, metres and radians per axis.

    Returns:
        A measurement in the frame of the last scan's camera. A box seen in one scan only is kept as that scan measured it.

    Raises:
        ConfigError: If there is no scan, or one of several has no pose.
    """
    if not scans:
        raise ConfigError("fuse: got no scan, wanted at least one")
    if len(scans) > 1:
        for scan in scans:
            if scan.camera_to_world is None:
                raise ConfigError(f"{scan.source}: has no camera pose, and fusing needs one per scan; give camera_to_world")
    results = [measure(scan, camera=camera, floor=floor if scan is scans[-1] else None) for scan in scans]
    return fuse_measurements(results, pose_sigma=pose_sigma)


def fuse_measurements(results: list[Measurement], *, pose_sigma: tuple[float, float] = POSE_SIGMA) -> Measurement:
    """Return one measurement from several single-scan ones (as :func:`fuse`, without measuring again)."""
    last = results[-1]
    if len(results) == 1:
        return last
    worlds = [result.world for result in results]
    known = {id(box) for result in results for box in result.boxes}
    groups = [(group, _fused(group, worlds, pose_sigma)) for group in _same_boxes(results, worlds)]
    measured = [box for group, box in groups if any(id(b) in known for b in group.values()) or _settled(group, box)]
    boxes = tuple(sorted(measured, key=lambda box: -box.quality.returns))
    names = tuple(name for result in results for name in result.scans)
    return replace(last, scans=names, boxes=boxes, reason=None if boxes else last.reason)


def _settled(group: dict[int, BoxEstimate], fused: BoxEstimate) -> bool:
    """Return whether scans that each left a box unbounded bound it together: one of them at least shows its whole outline."""
    return len(group) > 1 and not any(fused.is_open) and not fused.quality.cut


def pose_precision(camera_to_box: Pose, reference_to_box: Pose, pose_sigma: tuple[float, float]) -> Array:
    """Return the (6, 6) precision of the box's apparent motion that errors of two camera poses cause, in the box's frame.

    A rotation error turns the box about the camera, so at a metre 0.3 degrees is already 5 mm; the adjoint carries that.
    """
    metres, radians = pose_sigma
    error = np.diag([max(radians, 1e-6) ** 2] * 3 + [max(metres, 1e-6) ** 2] * 3)
    total = np.zeros((6, 6))
    for to_box in (camera_to_box, reference_to_box):
        moved = adjoint(to_box)
        total += moved @ error @ moved.T
    return np.asarray(np.linalg.inv(total), dtype=float)


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
    reference_to_world = worlds[-1]
    best = min(
        group, key=lambda index: (any(group[index].is_open), group[index].quality.cut, np.trace(group[index].covariance[6:, 6:]))
    )
    alone = {index: estimate.box.in_frame(inverse(reference_to_world) @ worlds[index]) for index, estimate in group.items()}
    start = alone[best]
    if len(group) == 1:
        return replace(group[best], box=start)
    views = tuple(_placed(group[index].views[0], worlds[index], reference_to_world, start, pose_sigma) for index in group)
    fit = _joint_fit([*alone.values(), _around(start, list(alone.values()))], views)
    seen = [
        _faces(view, view.sees(fit.box, c), e) for view, e, c in zip(fit.views, fit.evaluations, fit.corrections, strict=True)
    ]
    parts = [estimate.quality for estimate in group.values()]
    quality = Quality(
        explained=min(part.explained for part in parts),
        overlap=min(part.overlap for part in parts),
        faces=_merged(seen),
        returns=sum(part.returns for part in parts),
        cut=all(part.cut for part in parts),
    )
    return with_uncertainty(fit, quality, touching=any("touching" in estimate.flags for estimate in group.values()))


def _joint_fit(starts: list[Box], views: tuple[View, ...]) -> Fit:
    """Return the box of greatest likelihood in all views, from the best of several starts."""
    few = tuple(view.with_pixels(thinned(view.pixels, _COARSE_PIXELS)) for view in views)
    rough = max((refine(start, few, COARSE, 5) for start in starts), key=lambda fit: fit.value)
    return refine(rough.box, views, FINE, 8)


def _around(box: Box, boxes: list[Box]) -> Box:
    """Return ``box`` grown to cover ``boxes`` too: each scan may have seen another end of a box that all of them cut."""
    corners = np.concatenate([transform(inverse(box.box_to_camera), other.corners()) for other in boxes])
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle = np.array([*(low[:2] + high[:2]) / 2, 0.0])
    return Box(box.box_to_camera @ pose(np.eye(3), middle), np.array([*(high[:2] - low[:2]), high[2]]))


def _placed(view: View, camera_to_world: Pose, reference_to_world: Pose, box: Box, pose_sigma: tuple[float, float]) -> View:
    """Return a view with its place relative to the reference camera; the reference itself has an exact pose."""
    if camera_to_world is reference_to_world:
        return view
    reference_to_camera = inverse(camera_to_world) @ reference_to_world
    reference_to_box = inverse(box.box_to_camera)
    precision = pose_precision(reference_to_box @ inverse(reference_to_camera), reference_to_box, pose_sigma)
    return replace(view, reference_to_camera=reference_to_camera, pose_precision=precision)


def _faces(view: View, box: Box, evaluation: Evaluation) -> tuple[FaceView, ...]:
    """Return the faces of the fused box as one view saw them."""
    sigma = view.noise * view.sensor.range_sigma(evaluation.hits.ranges, evaluation.hits.cosine)
    return face_views(box, evaluation, view.pixels, on_faces(evaluation, view.pixels, sigma))


def _merged(seen: list[tuple[FaceView, ...]]) -> tuple[FaceView, ...]:
    """Return each face as the view with the most returns saw it."""
    best: dict[str, FaceView] = {}
    for face in (face for faces in seen for face in faces):
        if face.name not in best or face.returns > best[face.name].returns:
            best[face.name] = face
    return tuple(best.values())

"""One box in several views: the joint fit, where the cameras turned out to stand, and how sure it all is.

Every camera's pose may be wrong, the reference's too, each by six numbers of its own: the fit estimates them along with the box,
and what is known of the box afterwards has them integrated out.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from viewgain.arrays import Array, Mask, Pose
from viewgain.box import PARAMETERS, Box, adjoint
from viewgain.geometry import inverse
from viewgain.measure._fit import COARSE, FINE, SHARP, Fit, View, marginal, refine
from viewgain.measure._likelihood import Evaluation
from viewgain.measure._pixels import thinned
from viewgain.measure._quality import FaceView, Quality, face_views, flags, on_faces
from viewgain.measure._result import BoxEstimate
from viewgain.measure._uncertainty import SYSTEMATIC, Knowledge, Shown, believed, correlation, extent_interval

UNKNOWN_POSE = np.diag([1e-6] * 6)
"""(6, 6) precision of the pose of a camera that could stand anywhere: 1000 rad, 1000 m."""
_COARSE_PIXELS = 1500
_CONTRADICTION = 0.99


def own_precision(camera_to_box: Pose, pose_sigma: tuple[float, float]) -> Array:
    """Return the (6, 6) precision of a box's apparent motion, in its own frame, that the error of one camera's pose causes.

    A rotation error turns the box about the camera, so at a metre 0.3 degrees is already 5 mm; the adjoint carries that.

    Args:
        camera_to_box: (4, 4) pose of the camera in the box's frame.
        pose_sigma: Standard deviation of the camera's pose per axis, metres and radians.
    """
    return np.asarray(np.linalg.inv(_own_covariance(camera_to_box, pose_sigma)), dtype=float)


def pose_precision(camera_to_box: Pose, reference_to_box: Pose, pose_sigma: tuple[float, float]) -> Array:
    """Return the (6, 6) precision of the box's apparent motion that errors of two camera poses cause, in the box's frame.

    Takes stacks of poses too.
    """
    total = _own_covariance(camera_to_box, pose_sigma) + _own_covariance(reference_to_box, pose_sigma)
    return np.asarray(np.linalg.inv(total), dtype=float)


def _own_covariance(camera_to_box: Pose, pose_sigma: tuple[float, float]) -> Array:
    metres, radians = pose_sigma
    error = np.diag([max(radians, 1e-6) ** 2] * 3 + [max(metres, 1e-6) ** 2] * 3)
    moved = adjoint(camera_to_box)
    return np.asarray(moved @ error @ moved.mT, dtype=float)


def joint_fit(starts: list[Box], views: tuple[View, ...]) -> Fit:
    """Return the box of greatest likelihood in all views, from the best of several starts."""
    few = tuple(view.with_pixels(thinned(view.pixels, _COARSE_PIXELS)) for view in views)
    rough = max((refine(start, few, COARSE, 5) for start in starts), key=lambda fit: fit.value)
    return refine(rough.box, views, FINE, 12, rough.corrections)


def seen_from(fit: Fit, reference: int | None) -> Fit:
    """Return the fit with the estimated pose errors taken into the poses, its box in the true frame of the reference camera.

    Whoever moves the box from there compares with a value that holds no price for those errors any more.

    Args:
        fit: A joint fit.
        reference: Which view is the reference camera's; None if it did not see the box and its pose is taken as given.
    """
    box = fit.box if reference is None else fit.views[reference].sees(fit.box, fit.corrections[reference])
    views = []
    for k, view in enumerate(fit.views):
        if k == reference:
            views.append(replace(view, reference_to_camera=None, pose_precision=None))
        else:
            seen = view.sees(fit.box, fit.corrections[k])
            views.append(replace(view, reference_to_camera=seen.box_to_camera @ inverse(box.box_to_camera)))
    return refine(box, tuple(views), SHARP, 0)  # no step: only its value, at the poses as they now are


def estimate_of(fit: Fit, parts: list[BoxEstimate], reference_precision: Array | None) -> BoxEstimate:
    """Return the finished estimate of a fit in the reference camera's frame (:func:`seen_from`).

    Args:
        fit: The fit.
        parts: The same box as each view alone measured it, for what the scans say beyond the fit.
        reference_precision: (6, 6) precision of the reference camera's own pose error, box frame; None where the other poses
            are relative to it.
    """
    known = _knowledge(fit, reference_precision)
    spread = known.covariance(fit.views[0].sensor)
    spread[6:, 6:] += np.diag(_disagreement(fit, parts))
    quality, bounded = _quality(fit, parts), _bounded_alone(fit, parts)
    shown = [Shown(quality.cut and not bounded[axis], quality.spans(axis), quality.reach(axis)) for axis in range(3)]
    x, y, z = (extent_interval(axis, fit, known, spread, shown[axis]) for axis in range(3))
    bare = BoxEstimate(fit.box, known, spread, (x, y, z), quality, (), fit.views)
    touching = any("touching" in part.flags for part in parts)
    return replace(bare, flags=flags(quality, is_open=any(bare.is_open), touching=touching))


def _disagreement(fit: Fit, parts: list[BoxEstimate]) -> Array:
    """Return the (3,) variance to add to each extent because views contradict each other: zero unless beyond the 99 % point.

    Then what the views' sigmas do not explain is taken for an error of each view's own (DerSimonian and Laird 1986), and the
    mean of n views carries an n-th of its variance. An open extent contradicts nothing.
    """
    values, weights = np.zeros((len(parts), 3)), np.zeros((len(parts), 3))
    for k, part in enumerate(parts):
        order = _axes_of(part, fit, k)
        values[k] = part.box.extents[order]
        weights[k] = np.where(part.is_open, 0.0, 1 / np.diag(part.covariance)[6:])[order]
    total = np.maximum(weights.sum(axis=0), 1e-12)
    misfit = np.sum(weights * (values - np.sum(weights * values, axis=0) / total) ** 2, axis=0)
    count = np.maximum((weights > 0).sum(axis=0), 1)
    between = (misfit - (count - 1)) / np.maximum(total - np.sum(weights**2, axis=0) / total, 1e-12)
    return np.where(misfit > chdtri(np.maximum(count - 1, 1), 1 - _CONTRADICTION), between / count, 0.0)


def _bounded_alone(fit: Fit, parts: list[BoxEstimate]) -> Mask:
    """Return (3,) which extents a view alone bounds: where the image's border leaves one open, another view may show its end."""
    alone = [~np.array(part.is_open)[_axes_of(part, fit, k)] for k, part in enumerate(parts)]
    return np.asarray(np.any(alone, axis=0))


def _axes_of(part: BoxEstimate, fit: Fit, k: int) -> NDArray[np.intp]:
    """Return (3,) which axis of the box as view ``k`` alone measured it is the fused box's x, y and z."""
    seen = fit.views[k].sees(fit.box, fit.corrections[k]).box_to_camera[:3, :3]
    return np.asarray(np.argmax(np.abs(part.box.box_to_camera[:3, :3].T @ seen), axis=0))


def _knowledge(fit: Fit, reference_precision: Array | None) -> Knowledge:
    """Return what the views say together.

    The other views tell of the box only as far as they tell where the reference camera is: its pose error is integrated out of
    their sum, for they share it; each one's own pose error out of each one's part (two nested Schur complements).
    """
    own, others = _nothing(), _nothing()
    for view, evaluation in zip(fit.views, fit.evaluations, strict=True):
        information, gradients = marginal(*believed(view, evaluation), view.pose_precision)
        told = own if view.pose_precision is None else others
        told[0][:] += information
        told[1][:] += gradients
    far = marginal(*others, reference_precision)
    information, gradients = own[0] + far[0], own[1] + far[1]
    return Knowledge(information, gradients, correlation(fit))


def _nothing() -> tuple[Array, Array]:
    return np.zeros((PARAMETERS, PARAMETERS)), np.zeros((PARAMETERS, SYSTEMATIC))


def _quality(fit: Fit, parts: list[BoxEstimate]) -> Quality:
    seen = [_faces(v, v.sees(fit.box, c), e) for v, e, c in zip(fit.views, fit.evaluations, fit.corrections, strict=True)]
    alone = [part.quality for part in parts]
    return Quality(
        explained=min(part.explained for part in alone),
        overlap=min(part.overlap for part in alone),
        faces=_merged(seen),
        returns=sum(part.returns for part in alone),
        border=min(part.border for part in alone),
    )


def _faces(view: View, box: Box, evaluation: Evaluation) -> tuple[FaceView, ...]:
    """Return the faces of the fused box as one view saw them."""
    sigma = view.noise * view.sensor.range_sigma(evaluation.hits.ranges, evaluation.hits.cosine)
    return face_views(box, evaluation, view.pixels, on_faces(evaluation, view.pixels, sigma))


def _merged(seen: list[tuple[FaceView, ...]]) -> tuple[FaceView, ...]:
    """Return each face as the view with the most returns saw it, with all that any view saw of its ends."""
    views: dict[str, list[FaceView]] = {}
    for face in (face for faces in seen for face in faces):
        views.setdefault(face.name, []).append(face)
    return tuple(_together(faces) for faces in views.values())


def _together(faces: list[FaceView]) -> FaceView:
    edges, reach = (np.max([getattr(face, name) for face in faces], axis=0) for name in ("edges", "reach"))
    return replace(max(faces, key=lambda face: face.returns), edges=edges, reach=reach)

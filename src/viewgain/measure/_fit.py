"""Maximum likelihood: Levenberg-Marquardt on the standing box, from blurred to sharp, over one view or several.

A step of the box lives in the box's own frame, so the information of views from different cameras simply adds. The error of a
camera's pose is a small motion of the box as that camera sees it: six nuisance parameters per further view, held by their prior.
"""

from dataclasses import dataclass, replace

import numpy as np

from viewgain.arrays import Array, Pose
from viewgain.box import PARAMETERS, PLANE_NORMALS, Box
from viewgain.camera import Sensor
from viewgain.geometry import inverse
from viewgain.measure._bare_floor import BareFloor
from viewgain.measure._likelihood import Evaluation, evaluate
from viewgain.measure._mixture import Pixels, Softness

COARSE = (Softness(4.0, 0.02, 1.0), Softness(2.0, 0.01, 1.0))
FINE = (Softness(1.0, 0.003, 0.3), Softness(0.5))
SHARP = FINE[-1:]
_MAX_STEP = np.array([0.15, 0.15, 0.15, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1])
_MIN_EXTENT = 0.01
_PINNING = 200.0
"""A face with this many range readings does not slide: its place comes from them and not from the outline."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """What one camera saw of the box, and where that camera stood."""

    pixels: Pixels
    """The pixels that speak about the box."""
    sensor: Sensor
    """The camera's noise model."""
    noise: float = 1.0
    """Noise of this scan as a multiple of the sensor's."""
    reference_to_camera: Pose | None = None
    """Pose of the reference camera in this one; None for the reference itself."""
    pose_precision: Array | None = None
    """(6, 6) inverse covariance of the pose error as a motion of the box in its own frame; None where the pose is exact."""
    bare: BareFloor | None = None
    """What this camera saw of the floor when nothing stood on it, where that is needed."""

    def sees(self, box: Box, correction: Array) -> Box:
        """Return the box (given in the reference frame) in this camera's frame, with its (6,) pose correction."""
        if self.reference_to_camera is None:
            return box
        return box.in_frame(self.reference_to_camera).moved(np.concatenate([correction, np.zeros(3)]))

    def in_frame(self, reference_to_new: Pose) -> "View":
        """Return the view of a box that is given in another camera's frame from now on.

        Args:
            reference_to_new: (4, 4) pose of the present reference camera in the new one.
        """
        there = inverse(reference_to_new)
        return replace(self, reference_to_camera=there if self.reference_to_camera is None else self.reference_to_camera @ there)

    def with_noise(self, noise: float) -> "View":
        """Return the view with another noise factor."""
        return replace(self, noise=noise)

    def with_pixels(self, pixels: Pixels) -> "View":
        """Return the view with other pixels."""
        return replace(self, pixels=pixels)


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """A box at the maximum of its likelihood."""

    box: Box
    """The estimate, in the reference camera's frame."""
    views: tuple[View, ...]
    """What it was fitted to."""
    evaluations: tuple[Evaluation, ...]
    """Likelihood and derivatives at the estimate, one per view."""
    corrections: Array
    """(views, 6) estimated pose errors; zeros where poses are exact."""
    value: float
    """Log posterior, up to a constant."""

    @property
    def softness(self) -> Softness:
        """How sharply it was looked at."""
        return self.evaluations[0].softness


def marginal(information: Array, systematic: Array, pose_precision: Array | None) -> tuple[Array, Array]:
    """Return a view's (9, 9) information and (9, k) systematic gradient with its pose error integrated out (Schur complement).

    Takes stacks too.

    Args:
        information: (9, 9) information of the view if its pose were exact.
        systematic: (9, k) systematic gradients if its pose were exact.
        pose_precision: (6, 6) prior precision of its pose error, box frame; None for an exact pose.
    """
    if pose_precision is None:
        return information, systematic
    absorbed = information[..., :6] @ np.linalg.inv(information[..., :6, :6] + pose_precision)
    return information - absorbed @ information[..., :6, :], systematic - absorbed @ systematic[..., :6, :]


def refine(
    box: Box,
    views: tuple[View, ...],
    schedule: tuple[Softness, ...],
    steps: int,
    corrections: Array | None = None,
    *,
    held: int | None = None,
) -> Fit:
    """Return the box after up to ``steps`` damped scoring steps at each level of ``schedule`` (:func:`climbed`).

    ``corrections`` are the (views, 6) pose errors to start from, zero if not given; the extent along the axis ``held`` stays.
    """
    start = _evaluated(box, np.zeros((len(views), 6)) if corrections is None else corrections, views, schedule[0])
    return climbed(start, schedule, steps, held=held)


def climbed(fit: Fit, schedule: tuple[Softness, ...], steps: int, *, held: int | None = None) -> Fit:
    """Return a fit after up to ``steps`` more damped scoring steps at each level of ``schedule``.

    The prior on each extent is log-uniform (scale-free): its pull is far below the data's wherever the data speak, and where
    nothing bounds an extent from above it leaves it at its lower bound.
    """
    for softness in schedule:
        if fit.softness != softness:
            fit = _evaluated(fit.box, fit.corrections, fit.views, softness)
        damping = 1e-3
        for _ in range(steps):
            step, promised = _step(fit, damping, held)
            if promised < softness.settled:
                break
            trial = _evaluated(
                fit.box.moved(step[:PARAMETERS]), fit.corrections + step[PARAMETERS:].reshape(-1, 6), fit.views, softness
            )
            if trial.value > fit.value:
                gain = trial.value - fit.value
                fit, damping = trial, max(damping / 5, 1e-6)
                if gain < softness.settled:
                    break
            else:
                damping *= 10
                if damping > 1e2:
                    break
    return fit


def polled(fit: Fit, reach: float) -> Box:
    """Return the likeliest of the fitted box and the boxes with one side face moved in or out by ``reach`` metres.

    Which pixels hit is a step function underneath, so the likelihood has side peaks a few pixels from an edge; a fit that
    stopped on one is taken off it here, to be refined again. Faces with many range readings stay where those put them.
    """
    best, value = fit.box, sum(evaluation.value for evaluation in fit.evaluations)
    for axis, side in _unpinned(fit):
        for distance in (-reach, reach):
            step = np.zeros(PARAMETERS)
            step[3 + axis], step[6 + axis] = side * distance, distance
            moved = fit.box.moved(step)
            if np.all(moved.extents >= _MIN_EXTENT) and (there := value_at(moved, fit)) > value:
                best, value = moved, there
    return best


def _readings(fit: Fit) -> Array:
    """Return the (6,) number of range readings on each plane, over all views."""
    return sum((evaluation.readings for evaluation in fit.evaluations), np.zeros(len(PLANE_NORMALS)))


def _unpinned(fit: Fit) -> list[tuple[int, float]]:
    """Return axis and end (-0.5 or 0.5) of the side faces that too few ranges hold in place."""
    ends = ((0, 0.5), (0, -0.5), (1, 0.5), (1, -0.5))  # in the order of the faces
    return [end for end, count in zip(ends, _readings(fit), strict=False) if count < _PINNING]


def value_at(box: Box, fit: Fit) -> float:
    """Return the log likelihood of the views of ``fit`` at another box, looked at as sharply, their pose corrections held."""
    return sum(evaluation.value for evaluation in _of_views(box, fit.corrections, fit.views, fit.softness))


def estimate_noise(fit: Fit) -> tuple[float, ...]:
    """Return each view's noise as a multiple of its sensor's: the robust spread of its residuals away from the outline."""
    return tuple(_noise(view, evaluation) for view, evaluation in zip(fit.views, fit.evaluations, strict=True))


def _noise(view: View, evaluation: Evaluation) -> float:
    residual = evaluation.residual[np.abs(evaluation.inside) > 2]
    residual = np.abs(residual[np.isfinite(residual)])
    residual = residual[residual < 6]
    if len(residual) < 30:
        return view.noise
    return float(np.clip(view.noise * 1.4826 * np.median(residual), 0.05, 20.0))


def _evaluated(box: Box, corrections: Array, views: tuple[View, ...], softness: Softness) -> Fit:
    evaluations = _of_views(box, corrections, views, softness)
    value = sum(evaluation.value for evaluation in evaluations) - float(np.log(box.extents).sum())
    for view, correction in zip(views, corrections, strict=True):
        if view.pose_precision is not None:
            value -= 0.5 * float(correction @ view.pose_precision @ correction)
    return Fit(box, views, evaluations, corrections, value)


def _of_views(box: Box, corrections: Array, views: tuple[View, ...], softness: Softness) -> tuple[Evaluation, ...]:
    return tuple(
        evaluate(view.sees(box, correction), view.pixels, view.sensor, view.noise, softness, view.bare)
        for view, correction in zip(views, corrections, strict=True)
    )


def _step(fit: Fit, damping: float, held: int | None) -> tuple[Array, float]:
    """Return the damped step of the box (9) and of every view's pose correction (6 each), and the gain it promises."""
    size = PARAMETERS + 6 * len(fit.views)
    gradient, information = np.zeros(size), np.zeros((size, size))
    own = slice(0, PARAMETERS)
    for k, (view, evaluation) in enumerate(zip(fit.views, fit.evaluations, strict=True)):
        found = evaluation.derivatives
        gradient[own] += found.gradient
        information[own, own] += found.information
        pose = slice(PARAMETERS + 6 * k, PARAMETERS + 6 * k + 6)
        if view.pose_precision is None:
            information[pose, pose] = np.eye(6)
            continue
        gradient[pose] = found.gradient[:6] - view.pose_precision @ fit.corrections[k]
        information[pose, pose] = found.information[:6, :6] + view.pose_precision
        information[own, pose] = found.information[:, :6]
        information[pose, own] = found.information[:6]
    gradient[6:PARAMETERS] -= 1 / fit.box.extents
    information[range(6, PARAMETERS), range(6, PARAMETERS)] += 1 / fit.box.extents**2
    if held is not None:
        gradient[6 + held] = information[6 + held] = information[:, 6 + held] = 0.0
        information[6 + held, 6 + held] = 1.0
    step = np.linalg.solve(information + damping * np.diag(np.diag(information) + 1.0), gradient)
    step *= min(1.0, float(np.min(_MAX_STEP / np.maximum(np.abs(step[own]), 1e-12))))
    step[6:PARAMETERS] = np.maximum(step[6:PARAMETERS], _MIN_EXTENT - fit.box.extents)
    return np.asarray(step), 0.5 * float(gradient @ step)

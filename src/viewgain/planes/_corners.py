"""Corners where three orthogonal planes meet (stage 8A): three points of evidence, then a fit with exact right angles."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Points, Rotation, Vector, Vector3
from viewgain.geometry import nearest_rotation, rotation_from_rotvec
from viewgain.planes._cloud import Cloud
from viewgain.planes._settings import Settings

_FEWEST_NEAR = 5
_STEPS = 8
"""At most so many steps, as published; without convergence there is no corner."""
_TOLERANCE = 1e-6
"""Relative change of the cost that counts as convergence."""


@dataclass(frozen=True, slots=True, eq=False)
class Corner:
    """A point where three orthogonal planes meet."""

    position: Vector3
    """(3,) metres, camera frame."""
    axes: Rotation
    """(3, 3) rows: the planes' normals, right-handed."""


def meeting_point(normals: Rotation, offsets: Vector3) -> Vector3:
    """Return the (3,) point where three planes, rows of (3, 3) ``normals`` with (3,) ``offsets``, meet."""
    return np.asarray(-np.linalg.solve(normals, offsets))


def refined_corner(normals: Rotation, offsets: Vector3, cloud: Cloud, settings: Settings) -> Corner | None:
    """Return the corner of three nearly orthogonal planes, fitted to the points around it; None without enough of them.

    Args:
        normals: (3, 3) one unit normal per row.
        offsets: (3,) metres.
        cloud: The points; those within ``corner_radius`` of where the planes meet count.
        settings: ``gate`` says which plane a point is evidence for; each needs one.
    """
    near = np.linalg.norm(cloud.points - meeting_point(normals, offsets), axis=1) < settings.corner_radius
    points = cloud.points[near]
    facing = np.abs(cloud.normals[near] @ normals.T) > settings.gate
    first = facing & (np.cumsum(facing, axis=1) == 1)
    if len(points) < _FEWEST_NEAR or not first.any(axis=0).all():
        return None
    handed = np.array([1.0, 1.0, np.sign(np.linalg.det(normals))])
    return fitted_corner(nearest_rotation(normals * handed[:, None]), offsets * handed, points)


def fitted_corner(axes: Rotation, offsets: Vector3, points: Points) -> Corner | None:
    """Return the corner that minimises the squared distances of points from the nearest of its three planes.

    The planes are R p + d = 0 with a rotation R, so right angles hold exactly; steps are w on R (R <- exp(w) R) and on d.
    Levenberg-Marquardt; None unless it converges within eight steps.
    """
    damping = 1e-4
    cost = _cost(axes, offsets, points)
    for _ in range(_STEPS):
        jacobian, residual = _linearised(axes, offsets, points)
        hessian = jacobian.T @ jacobian
        step = -np.linalg.solve(hessian + damping * np.diag(np.diag(hessian)) + 1e-12 * np.eye(6), jacobian.T @ residual)
        turned, shifted = rotation_from_rotvec(np.asarray(step[:3], dtype=float)) @ axes, offsets + step[3:]
        tried = _cost(turned, shifted, points)
        if tried > cost:
            damping *= 10
            continue
        axes, offsets, change, cost, damping = turned, shifted, cost - tried, tried, damping / 10
        if change <= _TOLERANCE * (cost + 1e-15):
            return Corner(-axes.T @ offsets, axes)
    return None


def _nearest(axes: Rotation, offsets: Vector3, points: Points) -> tuple[Array, Array]:
    distances = points @ axes.T + offsets
    return distances, np.argmin(np.abs(distances), axis=1)


def _cost(axes: Rotation, offsets: Vector3, points: Points) -> float:
    return float(np.sum(np.min(np.abs(points @ axes.T + offsets), axis=1) ** 2))


def _linearised(axes: Rotation, offsets: Vector3, points: Points) -> tuple[Array, Vector]:
    """Return the (n, 6) derivatives of the distances by turn and shift, and the distances."""
    distances, nearest = _nearest(axes, offsets, points)
    rows = np.arange(len(points))
    unit = np.eye(3)[nearest]
    turn = np.cross(points @ axes.T, unit)  # e . (w x q) = w . (q x e)
    return np.concatenate([turn, unit], axis=1), distances[rows, nearest]

"""Planes lose what no point supports (stage 6), and all of them are fitted together (stage 7)."""

import numpy as np

from viewgain.arrays import Array, Indices, Points, Vector
from viewgain.planes._cloud import Cloud
from viewgain.planes._parallel import Planes
from viewgain.planes._settings import Settings
from viewgain.planes._votes import tangents

_STEPS = 10
_TOLERANCE = 1e-4
"""Relative change of the cost that ends the refinement, as published."""


def assigned(planes: Planes, cloud: Cloud, settings: Settings) -> tuple[Indices, Vector]:
    """Return each point's plane and its signed distance: the nearest whose normal is within the gate; -1 beyond ``band``."""
    if len(planes) == 0:
        return np.full(len(cloud), -1), np.full(len(cloud), np.inf)
    heights = planes.heights(cloud.points)
    facing = (np.abs(cloud.normals @ planes.normals.T) >= settings.gate)[:, planes.direction]
    nearest = np.argmin(np.where(facing, np.abs(heights), np.inf), axis=1)
    rows = np.arange(len(cloud))
    distance = heights[rows, nearest]
    belongs = facing[rows, nearest] & (np.abs(distance) < settings.band)
    return np.where(belongs, nearest, -1), distance


def filtered(planes: Planes, cloud: Cloud, settings: Settings) -> Planes:
    """Return the planes with enough points, of the directions with the most; every point counts for one plane."""
    step = max(1, settings.stride // 2)
    plane, _ = assigned(planes, cloud.every(step), settings)
    inliers = step * np.bincount(plane[plane >= 0], minlength=len(planes))
    kept = inliers >= settings.min_inliers
    if settings.max_directions is not None:
        support = np.bincount(planes.direction, inliers * kept, minlength=len(planes.normals))
        rank = np.argsort(np.argsort(-support, kind="stable"))
        kept &= (rank < settings.max_directions)[planes.direction]
    return planes.kept(kept)


def refined(planes: Planes, cloud: Cloud, settings: Settings) -> Planes:
    """Return the planes that minimise, over all normals and offsets at once, distances and right angles.

        sum_p min(n . p + d, band)^2  +  lambda N sum_edges (n . n')^2

    Each of N points goes to its plane of :func:`assigned`, anew at every step. Gauss-Newton; a step that does not lower
    the sum is not taken. The published program hands the same sum to a general solver.
    """
    if len(planes) == 0 or len(cloud) == 0:
        return planes
    plane, distance = assigned(planes, cloud, settings)
    cost = _cost(planes, plane, distance, settings)
    for _ in range(_STEPS):
        proposed = _stepped(planes, cloud, plane, distance, settings)
        plane, distance = assigned(proposed, cloud, settings)
        before, cost = cost, _cost(proposed, plane, distance, settings)
        if cost > before:
            break
        planes = proposed
        if before - cost <= _TOLERANCE * before:
            break
    return planes


def _cost(planes: Planes, plane: Indices, distance: Vector, settings: Settings) -> float:
    data = np.where(plane >= 0, distance, settings.band)
    return float(data @ data + settings.orthogonality * len(data) * np.sum(_edge_cosines(planes) ** 2))


def _edge_cosines(planes: Planes) -> Vector:
    one, other = planes.normals[planes.edges].transpose(1, 0, 2)
    return np.asarray(np.einsum("ek,ek->e", one, other))


def _stepped(planes: Planes, cloud: Cloud, plane: Indices, distance: Vector, settings: Settings) -> Planes:
    """Return the planes after one Gauss-Newton step: two tangents per direction, one offset per plane."""
    used = plane >= 0
    weight = np.sqrt(settings.orthogonality * len(plane))
    jacobian = np.concatenate([
        _point_rows(planes, cloud.points[used], plane[used]), weight * _edge_rows(planes)
    ])  # fmt: skip
    residual = np.concatenate([distance[used], weight * _edge_cosines(planes)])
    hessian = jacobian.T @ jacobian + 1e-9 * np.eye(jacobian.shape[1])
    step = -np.linalg.solve(hessian, jacobian.T @ residual)
    turns, shifts = step[: 2 * len(planes.normals)].reshape(-1, 2), step[2 * len(planes.normals) :]
    u, v = tangents(planes.normals)
    normals = planes.normals + turns[:, :1] * u + turns[:, 1:] * v
    return Planes(
        normals / np.linalg.norm(normals, axis=1, keepdims=True), planes.direction, planes.offsets + shifts, planes.edges
    )


def _point_rows(planes: Planes, points: Points, plane: Indices) -> Array:
    """Return the derivatives of the points' distances from their planes."""
    u, v = tangents(planes.normals)
    direction, turns = planes.direction[plane], 2 * len(planes.normals)
    rows, at = np.zeros((len(points), turns + len(planes))), np.arange(len(points))
    rows[at, 2 * direction] = np.einsum("nk,nk->n", points, u[direction])
    rows[at, 2 * direction + 1] = np.einsum("nk,nk->n", points, v[direction])
    rows[at, turns + plane] = 1.0
    return rows


def _edge_rows(planes: Planes) -> Array:
    """Return the derivatives of the cosines between orthogonal directions."""
    u, v = tangents(planes.normals)
    rows, at = np.zeros((len(planes.edges), 2 * len(planes.normals) + len(planes))), np.arange(len(planes.edges))
    for one, other in (planes.edges.T, planes.edges.T[::-1]):
        rows[at, 2 * one] = np.einsum("ek,ek->e", u[one], planes.normals[other])
        rows[at, 2 * one + 1] = np.einsum("ek,ek->e", v[one], planes.normals[other])
    return rows

"""Things on a floor that are no boxes, ray cast by their own formulas: spheres, cylinders, cones."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tests.oracles.rays import corners_of
from viewgain.box import Box
from viewgain.camera import Sensor
from viewgain.meshes import TriangleMesh
from viewgain.scans import Scan

Array = NDArray[np.float64]
Shape = Callable[[Array, Array], Array]
"""From a camera centre (3,) and (n, 3) unit rays, both in the world, to (n,) ranges; inf for a miss."""


def sphere(radius: float) -> Shape:
    """Return a ball that touches the floor at the world's origin."""
    centre = np.array([0.0, 0.0, radius])

    def cast(origin: Array, rays: Array) -> Array:
        return _nearest(
            np.ones(len(rays)), rays @ (origin - centre), np.full(len(rays), (origin - centre) @ (origin - centre) - radius**2)
        )

    return cast


def cylinder(radius: float, height: float) -> Shape:
    """Return an upright cylinder at the world's origin."""

    def cast(origin: Array, rays: Array) -> Array:
        flat, start = rays[:, :2], origin[:2]
        side = _nearest(np.sum(flat**2, axis=1), flat @ start, np.full(len(rays), start @ start - radius**2))
        at = origin[2] + np.where(np.isfinite(side), side, 0.0) * rays[:, 2]
        side = np.where((at >= 0) & (at <= height), side, np.inf)
        with np.errstate(divide="ignore"):
            lid = (height - origin[2]) / rays[:, 2]
        on_lid = np.linalg.norm(start + np.where(np.isfinite(lid), lid, 1e3)[:, None] * flat, axis=1) <= radius
        return np.minimum(side, np.where(on_lid & (lid > 0), lid, np.inf))

    return cast


def cone(radius: float, height: float) -> Shape:
    """Return an upright cone on the floor at the world's origin."""

    def cast(origin: Array, rays: Array) -> Array:
        slope = (radius / height) ** 2
        apex = np.array([*origin[:2], origin[2] - height])
        signs = np.array([1.0, 1.0, -slope])
        roots = _roots(rays**2 @ signs, rays @ (signs * apex), np.full(len(rays), apex**2 @ signs))
        at = origin[2] + np.where(np.isfinite(roots), roots, 0.0) * rays[:, 2]
        return np.where((at >= 0) & (at <= height), roots, np.inf).min(axis=0)  # not the cone's mirror image above its apex

    return cast


def scan_of(shape: Shape, camera_to_world: Array, camera: Sensor, *, rng: np.random.Generator) -> Scan:
    """Return a scan of one shape on the floor z = 0, with the camera's range noise at head-on incidence and no losses."""
    intrinsics = camera.intrinsics
    directions = np.dstack([intrinsics.rays(), np.ones((intrinsics.height, intrinsics.width))]).reshape(-1, 3)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    rays, origin = directions @ camera_to_world[:3, :3].T, camera_to_world[:3, 3]
    with np.errstate(divide="ignore"):
        floor = np.where(rays[:, 2] < 0, -origin[2] / rays[:, 2], np.inf)
    ranges = np.minimum(floor, shape(origin, rays))
    sigma = camera.range_sigma(np.minimum(ranges, camera.range_max), np.ones(len(ranges)))
    ranges = np.where(ranges < camera.range_max, ranges + sigma * rng.standard_normal(len(ranges)), 0.0)
    return Scan.from_range(ranges.reshape(intrinsics.height, intrinsics.width), intrinsics, camera_to_world=camera_to_world)


def _nearest(a: Array, half_b: Array, c: Array) -> Array:
    """Return the nearest positive root of a t^2 + 2 half_b t + c = 0; inf where there is none."""
    return np.asarray(_roots(a, half_b, c).min(axis=0))


def _roots(a: Array, half_b: Array, c: Array) -> Array:
    """Return (2, n): the positive roots, inf in place of the others."""
    root = half_b**2 - a * c
    with np.errstate(invalid="ignore", divide="ignore"):
        both = np.stack([(-half_b - np.sqrt(root)) / a, (-half_b + np.sqrt(root)) / a])
    return np.where(np.isfinite(both) & (both > 1e-9), both, np.inf)


def box_mesh(box: Box) -> TriangleMesh:
    """Return the twelve triangles of a box, in the frame that the box is given in."""
    quads = [(1, 3, 7, 5), (0, 4, 6, 2), (2, 6, 7, 3), (0, 1, 5, 4), (4, 5, 7, 6), (0, 2, 3, 1)]
    faces = [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]
    return TriangleMesh(corners_of(box), np.array(faces, dtype=np.int32), "box")

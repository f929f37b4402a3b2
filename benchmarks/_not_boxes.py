"""Scenes without a box, and boxes that are not quite: all drawn from a generator, so a seed gives the same scene again."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from viewgain.arrays import Pose
from viewgain.box import Box
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.meshes import TriangleMesh
from viewgain.scenes import FLOOR, Scene, orbit_pose, standing_box, wall
from viewgain.shapes import procedural

Array = NDArray[np.float64]


def bare_floor(rng: np.random.Generator) -> Scene:
    """Return nothing but the floor."""
    del rng
    return Scene()


def wall_corner(rng: np.random.Generator) -> Scene:
    """Return a floor and two walls at a right angle, each 0.3 to 1 m behind the world's origin."""
    azimuth = rng.uniform(0, 2 * np.pi)
    return Scene(planes=(FLOOR, wall(azimuth, rng.uniform(0.3, 1.0)), wall(azimuth + np.pi / 2, rng.uniform(0.3, 1.0))))


def cylinder(rng: np.random.Generator) -> Scene:
    """Return a cylinder, radius 0.05 to 0.25 m and length 0.1 to 0.6 m; three of ten lie on their side."""
    radius, length = rng.uniform(0.05, 0.25), rng.uniform(0.1, 0.6)
    mesh = tube(radius, length)
    if rng.random() < 0.3:
        mesh = turned(mesh, np.array([np.pi / 2, 0.0, 0.0]))
    return Scene(meshes=(turned(mesh, np.array([0, 0, rng.uniform(0, 2 * np.pi)])).standing(),))


def bag(rng: np.random.Generator) -> Scene:
    """Return a lumpy convex sack, 0.15 to 0.6 m long: a superellipsoid with bumps, flat where it lies on the floor."""
    around = np.array([0, 0, rng.uniform(0, 2 * np.pi)])
    return Scene(meshes=(turned(sack(rng), around).standing(),))


def mug(rng: np.random.Generator) -> Scene:
    """Return a mug with its handle, life-size."""
    return Scene(meshes=(_upright("mug", rng),))


def chair(rng: np.random.Generator) -> Scene:
    """Return a chair, life-size."""
    return Scene(meshes=(_upright("chair", rng),))


KINDS: Mapping[str, Callable[[np.random.Generator], Scene]] = MappingProxyType(
    {"bare floor": bare_floor, "wall corner": wall_corner, "cylinder": cylinder, "bag": bag, "mug": mug, "chair": chair}
)
"""The six kinds of scene without a box."""
DISTANCES: Mapping[str, tuple[float, float]] = MappingProxyType({"mug": (0.4, 1.0), "chair": (1.3, 2.5)})
"""From the camera to the object, metres, where it is not 0.7 to 1.6 m."""


def view_of(scene: Scene, kind: str, rng: np.random.Generator) -> Pose:
    """Return camera_to_world that looks at the object, or into the corner of walls, from 15 to 60 degrees above the horizon."""
    low, high = scene.meshes[0].bounds if scene.meshes else (np.zeros(3), np.array([0.0, 0.0, 0.2]))
    azimuth = rng.uniform(0, 2 * np.pi)
    if len(scene.planes) == 3:
        normal = -sum((plane.normal for plane in scene.planes[1:]), np.zeros(3))
        azimuth = float(np.arctan2(normal[1], normal[0])) + np.pi + np.deg2rad(rng.uniform(-35, 35))
    elevation, roll = np.deg2rad(rng.uniform(15, 60)), np.deg2rad(rng.normal(0, 3))
    target = (low + high) / 2 + rng.normal(0, 0.05, 3)
    return orbit_pose(target, float(azimuth), float(elevation), rng.uniform(*DISTANCES.get(kind, (0.7, 1.6))), float(roll))


def tube(radius: float, length: float, sides: int = 48) -> TriangleMesh:
    """Return a closed upright cylinder about the z axis."""
    around = np.arange(sides) * 2 * np.pi / sides
    ring = radius * np.stack([np.cos(around), np.sin(around)], axis=1)
    corners = np.vstack([np.column_stack([ring, np.zeros(sides)]), np.column_stack([ring, np.full(sides, length)])])
    return hull_mesh(corners, "cylinder")


def sack(rng: np.random.Generator, count: int = 300) -> TriangleMesh:
    """Return the convex hull of a superellipsoid of exponent 2 to 4 whose surface points are moved in and out by up to 12 %."""
    directions = rng.normal(size=(count, 3))
    power = rng.uniform(2.0, 4.0)
    directions /= np.sum(np.abs(directions) ** power, axis=1, keepdims=True) ** (1 / power)
    waves = np.sum(rng.uniform(0.5, 1.0, 3) * np.sin(directions * rng.uniform(2, 5, 3) + rng.uniform(0, 2 * np.pi, 3)), axis=1)
    length = rng.uniform(0.15, 0.6)
    points = directions * (1 + 0.04 * waves[:, None]) * length / 2 * np.array([1.0, rng.uniform(0.5, 1.0), rng.uniform(0.3, 0.8)])
    bottom = points[:, 2].min() * rng.uniform(0.6, 0.85)
    points[:, 2] = np.maximum(points[:, 2], bottom)
    return hull_mesh(points, "bag")


def hull_mesh(points: Array, name: str) -> TriangleMesh:
    """Return the convex hull of (n, 3) points as a mesh."""
    hull = ConvexHull(points)
    return TriangleMesh(points, hull.simplices.astype(np.int32), name)


def turned(mesh: TriangleMesh, rotvec: Array) -> TriangleMesh:
    """Return the mesh turned about the origin."""
    return mesh.moved(pose(rotation_from_rotvec(rotvec), np.zeros(3)))


def _upright(category: str, rng: np.random.Generator) -> TriangleMesh:
    return turned(procedural(category, rng=rng), np.array([0, 0, rng.uniform(0, 2 * np.pi)])).standing()


def bulged_box(box: Box, depth: float, *, axis: int = 0, side: int = 1, cells: int = 24) -> TriangleMesh:
    """Return a box one of whose side faces bulges by ``depth`` metres in its middle (sine arch both ways), nothing at its edges.

    Args:
        box: The box, in the world.
        depth: How far the middle stands out; negative for a dent.
        axis: 0 or 1: which pair of sides.
        side: 1 or -1: which of the two.
        cells: Cells of the face's grid per side.
    """
    u, v = (part.ravel() for part in np.mgrid[0 : cells + 1, 0 : cells + 1] / cells)
    local = np.zeros((len(u), 3))
    local[:, axis] = side * (box.extents[axis] / 2 + depth * np.sin(np.pi * u) * np.sin(np.pi * v))
    local[:, 1 - axis], local[:, 2] = (u - 0.5) * box.extents[1 - axis], v * box.extents[2]
    i, j = np.mgrid[0:cells, 0:cells].reshape(2, -1)
    corner = i * (cells + 1) + j
    grid = np.concatenate(
        [np.stack([corner, corner + 1, corner + cells + 2], 1), np.stack([corner, corner + cells + 2, corner + cells + 1], 1)]
    )
    shell = _box_quads(box, without=(axis, side))
    return _joined([(local, grid), *shell], box, "bulged box")


def flapped_box(box: Box, angle: float, *, length: float = 0.5, axis: int = 0) -> TriangleMesh:
    """Return a box whose two outer flaps stand open at ``angle`` from closed (0) over upright (pi / 2) to hanging (pi).

    The inner flaps are closed, so there is a top face.

    Args:
        box: The box, in the world.
        angle: Opening angle of both flaps, radians.
        length: Length of a flap as a share of the box's extent along ``axis`` (half: they meet when closed).
        axis: 0 or 1: the flaps hinge on the top edges at both ends of this axis.
    """
    parts = _box_quads(box, without=None)
    reach, half, top = length * box.extents[axis], box.extents[1 - axis] / 2, box.extents[2]
    for side in (1, -1):
        hinge, end = side * box.extents[axis] / 2, side * (box.extents[axis] / 2 - reach * np.cos(angle))
        points = np.zeros((4, 3))
        points[:, axis] = [hinge, hinge, end, end]
        points[:, 1 - axis] = [-half, half, half, -half]
        points[:, 2] = [top, top, top + reach * np.sin(angle), top + reach * np.sin(angle)]
        parts.append((points, np.array([[0, 1, 2], [0, 2, 3]])))
    return _joined(parts, box, "box with flaps")


def _box_quads(box: Box, without: tuple[int, int] | None) -> list[tuple[Array, Array]]:
    """Return the six faces of a box in its own frame, or five of them."""
    parts = []
    for axis in range(3):
        for side in (1, -1):
            if without == (axis, side):
                continue
            others = [k for k in range(3) if k != axis]
            points = np.zeros((4, 3))
            points[:, axis] = side * 0.5
            points[:, others[0]], points[:, others[1]] = [-0.5, 0.5, 0.5, -0.5], [-0.5, -0.5, 0.5, 0.5]
            points = (points + np.array([0, 0, 0.5])) * box.extents
            parts.append((points, np.array([[0, 1, 2], [0, 2, 3]])))
    return parts


def _joined(parts: list[tuple[Array, Array]], box: Box, name: str) -> TriangleMesh:
    starts = np.cumsum([0, *(len(points) for points, _ in parts)])
    faces = np.concatenate([index + start for (_, index), start in zip(parts, starts[:-1], strict=True)])
    return TriangleMesh(np.concatenate([points for points, _ in parts]), faces.astype(np.int32), name).moved(box.box_to_camera)


__all__ = ["KINDS", "bulged_box", "flapped_box", "hull_mesh", "sack", "standing_box", "tube", "turned", "view_of"]

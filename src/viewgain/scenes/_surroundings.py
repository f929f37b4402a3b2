"""More than one box on a bare floor: stacked and touching boxes, walls, clutter, and how much light each gives back."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Pose, Vector3
from viewgain.box import Box
from viewgain.geometry import Plane, pose, rotation_from_rotvec, transform
from viewgain.meshes import TriangleMesh
from viewgain.scenes._random import SceneRanges, random_box, standing_box
from viewgain.scenes._scene import FLOOR, Scene, wall
from viewgain.shapes import random_object

_TRIES = 40
"""Places tried for a body before it is left out."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """Distributions of what stands around the first box: numbers are uniform between the two bounds, both included."""

    boxes: tuple[int, int] = (1, 1)
    """How many boxes there are in all."""
    stacked: float = 0.3
    """Chance that a further box stands on one that nothing stands on yet, its sides 50 to 70 % of the lower one's shorter side,
    turned against it by up to 20 degrees."""
    touching: float = 0.3
    """Chance that it stands flush against a side of the first, parallel to it."""
    spread: float = 0.9
    """What neither is stacked nor touches stands within this distance of the first box, clear of everything, metres."""
    clutter: tuple[int, int] = (0, 0)
    """How many procedural objects stand around."""
    clutter_diagonal: tuple[float, float] = (0.15, 0.4)
    """Diagonal of their bounding boxes, metres."""
    walls: tuple[int, int] = (0, 0)
    """How many walls, at right angles to each other, at a uniform azimuth."""
    wall_gap: tuple[float, float] = (0.0, 0.8)
    """Between a wall and the body nearest to it, metres."""
    reflectivity: tuple[float, float] = (0.5, 0.5)
    """Share of light that each body gives back."""


@dataclass(frozen=True, slots=True, eq=False)
class _Disc:
    """The place on the floor that a body takes up."""

    x: float
    y: float
    radius: float

    def clear_of(self, others: list["_Disc"]) -> bool:
        """Return whether it overlaps none of the others."""
        return all(np.hypot(self.x - o.x, self.y - o.y) > self.radius + o.radius for o in others)


def random_scene(rng: np.random.Generator, ranges: SceneRanges | None = None, surroundings: Surroundings | None = None) -> Scene:
    """Return a random scene: a first box at the origin as :func:`random_box` makes it, and what ``surroundings`` adds.

    A body that finds no place in 40 tries is left out, so there may be fewer than drawn. A camera behind a wall sees through it.

    Args:
        rng: Source of all randomness.
        ranges: Sizes and turns of the boxes.
        surroundings: What else there is; default nothing.
    """
    ranges, around = ranges or SceneRanges(), surroundings or Surroundings()
    boxes, places, free = [random_box(rng, ranges)], [], [0]
    places.append(_disc(boxes[0]))
    for _ in range(int(rng.integers(around.boxes[0], around.boxes[1], endpoint=True)) - 1):
        kind = rng.random()
        if kind < around.stacked and free:
            lower = free.pop(int(rng.integers(len(free))))
            boxes.append(_on(boxes[lower], rng, ranges))
            free.append(len(boxes) - 1)
            continue
        draw = _beside if kind < around.stacked + around.touching else _apart
        for _ in range(_TRIES):
            box = draw(boxes[0], rng, ranges, around.spread)
            if _disc(box).clear_of(places[1:] if draw is _beside else places):
                free.append(len(boxes))
                boxes.append(box)
                places.append(_disc(box))
                break
    clutter = _clutter(rng, around, places)
    planes = (FLOOR, *_walls(rng, around, places))
    count = len(boxes) + len(clutter) + len(planes)
    return Scene(tuple(boxes), clutter, planes, tuple(rng.uniform(*around.reflectivity, count).tolist()))


def _disc(box: Box) -> _Disc:
    x, y, _ = box.box_to_camera[:3, 3]
    return _Disc(float(x), float(y), float(np.hypot(*box.extents[:2])) / 2)


def _on(lower: Box, rng: np.random.Generator, ranges: SceneRanges) -> Box:
    side = float(lower.extents[:2].min())
    extents = np.append(side * rng.uniform(0.5, 0.7, 2), rng.uniform(*ranges.extent))
    turn = pose(
        rotation_from_rotvec(np.array([0.0, 0.0, rng.uniform(-1, 1) * np.deg2rad(20)])), np.array([0.0, 0.0, lower.extents[2]])
    )
    return Box(lower.box_to_camera @ turn, extents)


def _beside(first: Box, rng: np.random.Generator, ranges: SceneRanges, spread: float) -> Box:
    """Return a box flush against one of the four sides of the first, shifted along it by up to half of the shorter of the two."""
    del spread
    extents = rng.uniform(*ranges.extent, 3)
    axis, sign = int(rng.integers(2)), float(rng.choice([-1.0, 1.0]))
    place: Vector3 = np.zeros(3)
    place[axis] = sign * (first.extents[axis] + extents[axis]) / 2
    place[1 - axis] = rng.uniform(-0.5, 0.5) * min(first.extents[1 - axis], extents[1 - axis])
    to_world: Pose = first.box_to_camera.copy()
    to_world[:3, 3] = transform(first.box_to_camera, place)
    return Box(to_world, extents)


def _apart(first: Box, rng: np.random.Generator, ranges: SceneRanges, spread: float) -> Box:
    del first
    yaw = float(np.deg2rad(rng.uniform(*ranges.yaw_deg)))
    return standing_box(rng.uniform(*ranges.extent, 3), yaw=yaw, at=_somewhere(rng, spread))


def _somewhere(rng: np.random.Generator, spread: float) -> tuple[float, float]:
    """Return a uniform point of a disc."""
    radius, angle = spread * np.sqrt(rng.random()), rng.uniform(0, 2 * np.pi)
    return float(radius * np.cos(angle)), float(radius * np.sin(angle))


def _clutter(rng: np.random.Generator, around: Surroundings, places: list[_Disc]) -> tuple[TriangleMesh, ...]:
    meshes = []
    for _ in range(int(rng.integers(around.clutter[0], around.clutter[1], endpoint=True))):
        mesh = random_object(rng=rng).normalised(float(rng.uniform(*around.clutter_diagonal)))
        mesh = mesh.moved(pose(rotation_from_rotvec(np.array([0.0, 0.0, rng.uniform(0, 2 * np.pi)])), np.zeros(3)))
        radius = float(np.hypot(*mesh.extents[:2])) / 2
        for _ in range(_TRIES):
            at = _somewhere(rng, around.spread)
            place = _Disc(*at, radius)
            if place.clear_of(places):
                places.append(place)
                meshes.append(mesh.standing(at))
                break
    return tuple(meshes)


def _walls(rng: np.random.Generator, around: Surroundings, places: list[_Disc]) -> list[Plane]:
    count = int(rng.integers(around.walls[0], around.walls[1], endpoint=True))
    azimuth = rng.uniform(0, 2 * np.pi)
    walls = []
    for quarter in range(count):
        angle = float(azimuth + quarter * np.pi / 2)
        nearest = max(p.x * np.cos(angle) + p.y * np.sin(angle) + p.radius for p in places)
        walls.append(wall(angle, float(nearest + rng.uniform(*around.wall_gap))))
    return walls

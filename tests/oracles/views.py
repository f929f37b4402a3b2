"""One candidate view of one box at a time: what it teaches and shows, and the error to expect, in plain steps on plain arrays.

The package works on stacks of boxes, where every view has the same number of samples; here those that do not count are dropped,
and every number is the sum, maximum or minimum over a list.
"""

from dataclasses import dataclass

import numpy as np

from tests.oracles.perceptron import corrected_slowly
from viewgain.box import (
    PLANE_NORMALS,
    Box,
    EdgeDistances,
    Hits,
    box_hits,
    clearance,
    constraints,
    edge_cosines,
    edge_distances,
    edge_jacobian,
    edges_shown,
    floor_hits,
    outline,
    range_jacobian,
)
from viewgain.camera import Sensor
from viewgain.geometry import inverse
from viewgain.measure import (
    MAX_SLENDER,
    MIN_EDGE_SHOWN,
    OPEN_SHARE,
    SPANNING,
    SPANNING_POINTS,
    Knowledge,
    common_shift,
    marginal,
    pose_precision,
)
from viewgain.plan import ErrorModel, Outcome
from viewgain.plan._floor_in_view import FloorInView, floor_in_view

ENDS = ((0, 1), (2, 3), (4, 4))
CELLS = (np.arange(6) + 0.5) / 6 - 0.5
ALONG = (np.arange(12) + 0.5) / 12


@dataclass(frozen=True)
class View:
    """What one camera shows of one box and teaches about it."""

    knowledge: Knowledge
    returns: np.ndarray
    incidence: np.ndarray
    border: float
    edges: np.ndarray
    corners: float
    clearance: float
    distance: float
    elevation: float
    floor: FloorInView


def seen_slowly(box: Box, sensor: Sensor, noise: float) -> View:
    """Return what a sensor sees of a box in its own frame."""
    camera = sensor.intrinsics
    size = (camera.width, camera.height)

    def to_pixels(image: np.ndarray) -> np.ndarray:
        return camera.project(np.column_stack([image, np.ones(len(image))]))

    knowledge, returns = Knowledge(np.zeros((9, 9)), np.zeros((9, 5))), np.zeros(5)
    incidence, border = np.full(5, np.nan), 1.0
    edges, corners, outermost = np.zeros((5, 5)), 0.0, -0.3
    if box.corners()[:, 2].min() >= 0.05:
        as_seen = constraints(box, to_pixels, size)
        incidence, border = as_seen.incidence, as_seen.border
        knowledge, returns = taught(box, sensor, noise)
    if returns.any():
        edges = edges_shown(box, to_pixels, size)
        inside = clearance(camera.project(box.corners()), size)
        corners, outermost = float(np.mean(inside >= 0.5)), float(np.clip(inside.min() / camera.fx, -0.3, 0.3))
    distance = max(float(np.linalg.norm(box.centre)), 0.05)
    elevation = float(np.arcsin(np.clip(-box.box_to_camera[:3, 2] @ box.centre / distance, -1, 1)))
    floor = floor_in_view(box, sensor)
    return View(knowledge, returns, incidence, border, edges, corners, outermost, distance, elevation, floor)


def taught(box: Box, sensor: Sensor, noise: float) -> tuple[Knowledge, np.ndarray]:
    """Return (9, 9) information and (9, 5) gradients, and (5,) returns, of a box in front of the camera."""
    information, systematic, returns = np.zeros((9, 9)), np.zeros((9, 5)), np.zeros(5)
    faces, ground = on_faces(box, sensor), on_floor(box, sensor)
    for face, (_, _, weight) in enumerate(faces):
        returns[face] = weight.sum()
    believed = [(rays, hits, weight * (1 - sensor.loss(hits.cosine))) for rays, hits, weight in faces]
    for rays, hits, weight in (*believed, ground):
        rows = range_jacobian(box, rays, hits)
        weighted = rows.T * (weight / (noise * sensor.range_sigma(hits.ranges, hits.cosine)) ** 2)
        information += weighted @ rows
        systematic[:, :4] += weighted @ sensor.systematic_shapes(hits.ranges)
    shape = outline(box)
    for edge, cosine in enumerate(edge_cosines(box, shape)):
        rows, weight = along_edge(box, edge, sensor, noise)
        pull, precision = weight @ rows, weight.sum()
        sigma = sensor.edge_sigma(np.array([cosine]))
        information += (rows.T * weight) @ rows - np.outer(pull, pull) / (precision + 1 / max(float(sigma[0]), 1e-6) ** 2)
        systematic[:, 4] += common_shift(pull[None], np.array([precision]), sigma)
    return Knowledge(information, systematic), returns


def on_faces(box: Box, sensor: Sensor) -> list[tuple[np.ndarray, Hits, np.ndarray]]:
    """Return for each face the rays that meet it, where, and how many pixels each stands for."""
    samples = []
    for face, normal in enumerate(PLANE_NORMALS[:5]):
        across = np.flatnonzero(normal == 0)
        grid = np.tile(normal / 2, (36, 1))
        grid[:, across] = [(x, y) for y in CELLS for x in CELLS]
        points = (grid * box.extents + [0, 0, box.extents[2] / 2]) @ box.box_to_camera[:3, :3].T + box.box_to_camera[:3, 3]
        ranges = np.linalg.norm(points, axis=1)
        rays = points / ranges[:, None]
        cosine = -rays @ (box.box_to_camera[:3, :3] @ normal)
        area = np.prod(box.extents[across]) / 36
        pixels = area * np.maximum(cosine, 0) / ranges**2 * sensor.intrinsics.fx * sensor.intrinsics.fy
        weight = pixels / np.maximum(rays[:, 2], 0.1) ** 3 * (1 - sensor.loss(cosine)) * imaged(rays, ranges, sensor)
        used = (cosine > 0.02) & (weight > 0)
        hits = Hits(ranges[used], np.full(used.sum(), face), cosine[used])
        samples.append((rays[used], hits, weight[used]))
    return samples


def on_floor(box: Box, sensor: Sensor) -> tuple[np.ndarray, Hits, np.ndarray]:
    """Return the same of the floor around the box."""
    camera = sensor.intrinsics
    last = (camera.width - 1, camera.height - 1)
    corners = np.clip(camera.project(box.corners()), 0, last)
    low, high = np.maximum(corners.min(axis=0) - 16, 0), np.minimum(corners.max(axis=0) + 16, last)
    u, v = np.meshgrid(np.linspace(low[0], high[0], 12), np.linspace(low[1], high[1], 12))
    image = camera.undistort(np.column_stack([(u.ravel() - camera.cx) / camera.fx, (v.ravel() - camera.cy) / camera.fy]))
    rays = directed(image)
    hits = floor_hits(box, rays)
    beside = edge_distances(outline(box), image).distance < 0
    weight = np.prod(high - low) / 144 * beside * (1 - sensor.loss(hits.cosine)) * (hits.ranges < sensor.range_max)
    used = np.flatnonzero(weight > 0)
    return rays[used], hits.take(used), weight[used]


def along_edge(box: Box, edge: int, sensor: Sensor, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Return (12, 9) derivatives along an edge of the outline, and how much each counts."""
    shape = outline(box)
    start, end = shape.vertices[edge], shape.vertices[(edge + 1) % len(shape.vertices)]
    image = start + ALONG[:, None] * (end - start)
    rays = directed(image)
    near, far = box_hits(box, directed(image + 1e-4 * (shape.vertices.mean(axis=0) - image))), floor_hits(box, rays)
    with np.errstate(over="ignore"):
        sigma = noise * sensor.range_sigma(np.minimum(near.ranges, 10), near.cosine)
        gap = np.clip((far.ranges - near.ranges) / sigma, 0, 50)
    pixels = np.linalg.norm(end - start) / 12 * sensor.intrinsics.fx
    weight = 0.7 * 1.81 / 0.5 * pixels * (1 - np.exp(-(gap**2) / 8)) * imaged(rays, near.ranges, sensor)
    places = EdgeDistances(np.zeros(12), np.full(12, edge), ALONG)
    return edge_jacobian(box, shape, places) * sensor.intrinsics.fx, weight


def imaged(rays: np.ndarray, ranges: np.ndarray, sensor: Sensor) -> np.ndarray:
    camera, seen = sensor.intrinsics, np.zeros(len(rays), dtype=bool)
    for index, (ray, distance) in enumerate(zip(rays, ranges, strict=True)):
        if ray[2] > 0.05 and sensor.range_min < distance < sensor.range_max:
            u, v = camera.project(ray[None])[0]
            seen[index] = 0 < u < camera.width - 1 and 0 < v < camera.height - 1
    return seen


def directed(image: np.ndarray) -> np.ndarray:
    rays = np.column_stack([image, np.ones(len(image))])
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))


def spanned(view: View) -> np.ndarray:
    """Return (3,) axes that are shown from end to end."""
    found = np.zeros(3, dtype=bool)
    for axis, ends in enumerate(ENDS):
        along = [face for face in SPANNING[axis] if view.returns[face] >= SPANNING_POINTS]
        found[axis] = bool(along) and all(
            view.returns[end] >= SPANNING_POINTS or any(view.edges[face, end] >= MIN_EDGE_SHOWN for face in along) for end in ends
        )
    return found


def ends_shown(view: View) -> np.ndarray:
    """Return (3, 2) how well the ends of each axis are shown."""
    shown = np.zeros((3, 2))
    for axis, ends in enumerate(ENDS):
        along = [face for face in SPANNING[axis] if view.returns[face] >= 25]
        for place, end in enumerate(ends):
            by_edges = max((view.edges[face, end] for face in along), default=0.0)
            shown[axis, place] = max(0.5 * min(view.returns[end] / SPANNING_POINTS, 1.0), by_edges)
    return shown


def added_slowly(view: View, here: Box, there: Box, pose_sigma: tuple[float, float]) -> Knowledge:
    """Return what is left of a view's knowledge under errors of two poses."""
    precision = pose_precision(inverse(there.box_to_camera), inverse(here.box_to_camera), pose_sigma)
    return Knowledge(*marginal(view.knowledge.information, view.knowledge.systematic, precision))


def relative_slowly(known: Knowledge, box: Box, sensor: Sensor) -> float:
    gradient = np.concatenate([np.zeros(6), 1 / box.extents])
    return float(np.sqrt(gradient @ known.covariance(sensor) @ gradient))


def expected_slowly(box: Box, known: Knowledge, views: list[View], sensor: Sensor, model: ErrorModel) -> float:
    """Return the error to expect of a box where the views say together what is known."""
    if not any(view.returns.any() for view in views):
        return 1.0
    sigma = np.sqrt(np.diag(known.covariance(sensor))[6:])
    still_open = 1 - 1 / (1 + max(sigma / (OPEN_SHARE * box.extents)) ** 3)
    few = 1 - 1 / (1 + 100 / max(1.0, *(view.returns.sum() for view in views)))
    slender = 0.8 if box.extents[2] > MAX_SLENDER * max(box.extents[:2]) else 0.0
    cut = 0.0
    if all(view.border > 0 for view in views):
        cut = 0.03 if np.any([spanned(view) for view in views], axis=0).all() else 0.99
    missed = 1 - (1 - still_open) * (1 - cut) * (1 - few) * (1 - slender)
    relative = relative_slowly(known, box, sensor)
    guess = Outcome(float(missed), min(np.sqrt(2 / np.pi) * relative, 1.0))
    missed, off = corrected_slowly(model, guess, circumstances_slowly(box, sigma, relative, views, sensor))
    return float(missed + (1 - missed) * off)


def circumstances_slowly(box: Box, sigma: np.ndarray, relative: float, views: list[View], sensor: Sensor) -> np.ndarray:
    """Return (39,) the numbers that the error model goes by."""
    order = [0, 1, 2] if box.extents[0] >= box.extents[1] else [1, 0, 2]
    extents = box.extents[order]
    ends = np.max([ends_shown(view) for view in views], axis=0)[order]
    faces = np.max([view.returns for view in views], axis=0)
    sides = [faces[2 * axis : 2 * axis + 2] for axis in order[:2]]
    returns = [max(view.returns.sum() for view in views), faces[4], *map(max, sides), *map(min, sides)]
    borders, corners, distances, elevations = (
        [getattr(view, name) for view in views] for name in ("border", "corners", "distance", "elevation")
    )
    return np.array([
        *np.log(extents), *np.log(np.clip([*sigma[order] / extents, relative], 1e-4, 10)),
        *np.any([spanned(view) for view in views], axis=0)[order], *ends.min(axis=1), *ends.max(axis=1),
        max(corners), min(corners), np.sqrt(min(borders)), np.sqrt(max(borders)), min(borders) > 0, max(borders) > 0,
        *np.log(np.maximum(returns, 1)), np.log(min(distances)), np.log(max(distances)), min(elevations), max(elevations),
        len(views) - 1, np.log(extents[2] / extents[0] / MAX_SLENDER),
        np.log(sensor.intrinsics.fx), np.log(sensor.range_sigma(np.array([min(distances)]), np.ones(1))[0]),
        np.log(max(1.0, *(view.floor.returns for view in views))), np.log(max(0.01, *(view.floor.share for view in views))),
        max(view.clearance for view in views),
    ])  # fmt: skip

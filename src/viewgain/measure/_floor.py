"""The floor, from the cloud itself: the largest plane with nothing beneath it that faces up as a camera sees up."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Indices, Points
from viewgain.camera import Sensor
from viewgain.geometry import Plane, fit_plane
from viewgain.measure._bare_floor import BareFloor
from viewgain.measure._range_image import RangeImage

_HYPOTHESES = 200
_SAMPLE = 1000
_REFINING = 4000
_NORMAL_GATE = np.cos(np.deg2rad(15.0))
_MAX_BELOW = 0.05
_MIN_SUPPORT = 0.05
_WIDE, _NARROW = (0.03, 0.015, 0.01), (0.015, 0.01, 0.007)
"""How near points have to lie to take part in each fit, metres at half a metre, more farther off."""
_CLOSE, _BENEATH = 0.004, 0.02
"""What lies so near counts as on a plane, and what lies so far under it as beneath; metres as above."""
_CLEARLY = 1.1
"""How much more has to lie close to a rival."""
_RIVALS, _RIVAL_SCORE = 11, 0.5
"""How many are tried, and the share of the best score that they need."""
_ALIKE, _ALIKE_M, _SAME_WAY = np.cos(np.deg2rad(0.8)), 0.015, np.cos(np.deg2rad(10.0))
"""Hypotheses are alike within both of the first, and lean the same way within the last; cosines and metres."""


@dataclass(frozen=True, slots=True, eq=False)
class Floor:
    """The floor plane and how well the scan fixes it."""

    plane: Plane
    """Camera frame; the camera is on its positive side."""
    spread: float
    """Robust standard deviation of the floor points about the plane, metres."""
    noise: float
    """Pixel-to-pixel noise of the range on it, as a multiple of the sensor's."""
    bare: BareFloor | None = None
    """What an empty scene showed of it, where the scan itself shows too little."""


def find_floors(image: RangeImage, sensor: Sensor) -> list[Floor]:
    """Return up to three planes of a scan that can be a floor, the best first; none where no plane can be one.

    One-point RANSAC on smoothed pixel normals (seeded by the data's own size, so the same scan gives the same floor), support
    weighed by metric area so that a near box top does not outvote a far floor; then least squares on all its points. A plane
    can be a floor only if at most 5 % of the area seen lies beneath it; one that faces up in the image is preferred to a wall.

    A plane that slants through the floor and the top of a large flat box has as much support as either. So where another plane
    that leans about the same way has clearly more area close to it, that one is the floor.
    """
    points, normals, area = _oriented_samples(image)
    if len(points) < 50:
        return []
    rng = np.random.default_rng(len(points))
    sample = rng.choice(len(points), min(_SAMPLE, len(points)), replace=False)
    seeds = rng.choice(len(points), min(_HYPOTHESES, len(points)), replace=False)
    directions, offsets = normals[seeds], -np.sum(normals[seeds] * points[seeds], axis=1)
    height = points[sample] @ directions.T + offsets
    tolerance = (0.01 + 0.01 * np.linalg.norm(points[sample], axis=1))[:, None]
    aligned = normals[sample] @ directions.T > _NORMAL_GATE
    weight = area[sample] / area[sample].sum()
    support = weight @ ((np.abs(height) < tolerance) & aligned)
    below = weight @ (height < -3 * tolerance)
    score = support * _upness(directions) * (below < _MAX_BELOW) * (support > _MIN_SUPPORT) * (offsets > 0.1)
    blocks = _Blocks(points, np.linalg.norm(points, axis=1), area / area.sum())
    floors: list[Floor] = []
    order = np.argsort(-score)
    for place, best in enumerate(order):
        if score[best] <= 0 or len(floors) == 3:
            break
        if all(directions[best] @ known.plane.normal < 0.9 for known in floors):
            nearly = order[place:][score[order[place:]] >= _RIVAL_SCORE * score[best]]
            planes = [Plane(directions[k], float(offsets[k])) for k in _apart(directions, offsets, nearly)]
            floors.append(_refined(image, planes, blocks, sensor))
    return floors


@dataclass(frozen=True, slots=True, eq=False)
class _Blocks:
    """Means over blocks of pixels, on which noise is small beside the height of a flat box."""

    points: Points
    ranges: Array
    area: Array
    """(n,) share of the area seen."""

    def closeness(self, plane: Plane) -> float:
        """Return the share of the area that lies within millimetres of a plane; 0 if too much lies beneath it for a floor."""
        height, reach = plane.height(self.points), 0.5 + self.ranges
        beneath = float(self.area @ (height < -_BENEATH * reach))
        facing = float(_upness(plane.normal[None])[0])
        return float(self.area @ (np.abs(height) < _CLOSE * reach)) * facing * (beneath < _MAX_BELOW)

    def best_of(self, planes: list[Plane]) -> Plane:
        """Return the plane that has most close to it, each fitted to the blocks near it."""
        return max((_fitted(plane, self.points, self.ranges, _NARROW) for plane in planes), key=self.closeness)


def _apart(directions: Points, offsets: Array, candidates: Indices) -> list[int]:
    """Return the first candidate and up to ``_RIVALS`` later ones that lean as it does within ten degrees, no two alike."""
    chosen = [int(candidates[0])]
    for each in candidates[1:]:
        cosine = directions[chosen] @ directions[each]
        alike = (cosine > _ALIKE) & (np.abs(offsets[chosen] - offsets[each]) < _ALIKE_M)
        if cosine[0] > _SAME_WAY and not alike.any():
            chosen.append(int(each))
            if len(chosen) > _RIVALS:
                break
    return chosen


def _upness(normals: Points) -> Array:
    """Return (n,) weights in [0.05, 1]: 1 for planes that face up in the image (-y) or straight back (-z, overhead views)."""
    return np.clip(-normals[:, 1] - 0.5 * normals[:, 2], 0.05, 1.0)


def _oriented_samples(image: RangeImage) -> tuple[Points, Points, Array]:
    """Return points, normals towards the camera and metric areas of the blocks of pixels that see one smooth surface.

    Block means are what makes one-point hypotheses good enough: at 1 % range noise single pixels tilt a normal by tens of
    degrees, means over 4 x 4 of them with a baseline of four blocks by two.
    """
    side = max(3, round(image.ranges.shape[1] / 56))
    means = _block_means(image.points, side)
    if min(means.shape[:2]) < 5:
        return np.empty((0, 3)), np.empty((0, 3)), np.empty(0)
    rows, columns = np.mgrid[2 : means.shape[0] - 2, 2 : means.shape[1] - 2].reshape(2, -1)
    centre = means[rows, columns]
    across = means[rows, columns + 2] - means[rows, columns - 2]
    down = means[rows + 2, columns] - means[rows - 2, columns]
    bend = (
        means[rows, columns + 2] + means[rows, columns - 2] - 2 * centre,
        means[rows + 2, columns] + means[rows - 2, columns] - 2 * centre,
    )
    normals = np.cross(down, across)
    length = np.linalg.norm(normals, axis=1)
    distance = np.linalg.norm(centre, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        normals = normals / length[:, None]
        off_plane = np.maximum(np.abs(np.sum(bend[0] * normals, axis=1)), np.abs(np.sum(bend[1] * normals, axis=1)))
        good = (length > 1e-12) & (off_plane < 0.01 + 0.015 * distance)
    centre, normals, distance = centre[good], normals[good], distance[good]
    normals *= np.where(np.sum(normals * centre, axis=1) > 0, -1.0, 1.0)[:, None]
    cosine = np.maximum(-np.sum(normals * centre, axis=1) / distance, 0.1)
    return centre, normals, np.asarray(distance**2 / cosine)


def _block_means(points: Array, side: int) -> Array:
    """Return the (h // side, w // side, 3) means over square blocks; NaN where less than half of a block has returns."""
    rows, columns = points.shape[0] // side, points.shape[1] // side
    blocks = points[: rows * side, : columns * side].reshape(rows, side, columns, side, 3)
    present = np.isfinite(blocks[..., 2])
    count = present.sum(axis=(1, 3))
    total = np.where(present[..., None], blocks, 0.0).sum(axis=(1, 3))
    return np.where((count >= side * side / 2)[..., None], total / np.maximum(count, 1)[..., None], np.nan)


def _refined(image: RangeImage, planes: list[Plane], blocks: _Blocks, sensor: Sensor) -> Floor:
    """Return the floor of the first plane, or of the one of the others that has clearly more close to it."""
    at = np.flatnonzero(image.valid)
    at = at[:: max(1, len(at) // _REFINING)]
    ranges = image.ranges.ravel()[at]
    points = image.directions.reshape(-1, 3)[at] * ranges[:, None]
    plane = _fitted(planes[0], points, ranges, _WIDE)
    needed = _CLEARLY * blocks.closeness(plane)
    if len(planes) > 1 and needed < 1:
        rival = blocks.best_of(planes[1:])
        if blocks.closeness(rival) > needed:
            plane = _fitted(rival, points, ranges, _NARROW)
    residual = plane.height(points)
    near_residual = residual[np.abs(residual) < 0.03]
    spread = 1.4826 * float(np.median(np.abs(near_residual))) if len(near_residual) else 0.01
    return Floor(plane, max(spread, 1e-4), _pixel_noise(image, plane, sensor))


def _fitted(plane: Plane, points: Points, ranges: Array, tolerances: tuple[float, ...]) -> Plane:
    """Return the plane of least squares on what lies near one, nearer from step to step."""
    for tolerance in tolerances:
        near = points[np.abs(plane.height(points)) < tolerance * (0.5 + ranges)]
        if len(near) < 50:
            break
        plane = fit_plane(near)
    return plane


def _pixel_noise(image: RangeImage, plane: Plane, sensor: Sensor) -> float:
    """Return the white noise of the floor's pixels over the sensor's, from second differences along the rows (a bend cancels)."""
    ranges, directions = image.ranges, image.directions
    bend = ranges[:, 2:] - 2 * ranges[:, 1:-1] + ranges[:, :-2]
    with np.errstate(invalid="ignore"):
        on_floor = np.abs(plane.height(image.points))[:, 1:-1] < 0.03
        used = on_floor & (np.abs(bend) < 0.15)
    if used.sum() < 50:
        return 1.0
    cosine = np.abs(directions[:, 1:-1][used] @ plane.normal)
    sigma = sensor.range_sigma(ranges[:, 1:-1][used], cosine)
    return float(np.clip(1.4826 * np.median(np.abs(bend[used]) / sigma) / np.sqrt(6.0), 0.05, 20.0))

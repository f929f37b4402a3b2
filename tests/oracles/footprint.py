"""What a pixel makes of its whole footprint, sub-ray by sub-ray and for every pixel; and where an edge of flipped pixels lies."""

import cmath
import math

import numpy as np
from numpy.typing import NDArray

from tests.oracles.rays import QUADS, corners_of, hit_polygon
from viewgain.box import Box
from viewgain.camera import Sensor
from viewgain.scenes import Scene

Array = NDArray[np.float64]
Piece = tuple[list[list[float]] | None, Array, float, float]
"""Corners of a polygon (None for an infinite plane), unit normal, offset (n.x + offset = 0), reflectivity."""

Return = tuple[float, float, int]
"""Range, strength and which piece was met (-1 for none)."""


def footprint_image(scene: Scene, camera_to_world: Array, sensor: Sensor, per_side: int) -> Array:
    """Return the (h * w,) ranges of a pinhole camera whose every pixel looks through per_side^2 sub-rays; inf for nothing.

    What a sub-ray meets is continued as a plane to the pixel's own ray, by what two pixels make on a slope of 81 degrees, so that
    a slope is no mixture. Time of flight adds phasors; the phase is counted from the strongest return. A pattern takes the middle
    range on the surface that most sub-rays see.
    """
    pieces = [piece for k, box in enumerate(scene.boxes) for piece in _faces(box, float(scene.body_reflectivity[k]))]
    first_plane = len(scene.boxes) + len(scene.meshes)
    for k, plane in enumerate(scene.planes):
        pieces.append((None, plane.normal, plane.offset, float(scene.body_reflectivity[first_plane + k])))
    camera, eye, turn = sensor.intrinsics, camera_to_world[:3, 3], camera_to_world[:3, :3]
    steps = [((k + 0.5) / per_side - 0.5) * sensor.footprint_px for k in range(per_side)]
    image = np.full((camera.height, camera.width), np.inf)
    for row in range(camera.height):
        for column in range(camera.width):
            centre = turn @ _unit((column - camera.cx) / camera.fx, (row - camera.cy) / camera.fy)
            returns = []
            for down in steps:
                for right in steps:
                    ray = turn @ _unit((column + right - camera.cx) / camera.fx, (row + down - camera.cy) / camera.fy)
                    returns.append(_return(pieces, eye, ray, centre, min(2 * 6.3 / camera.fx, 0.5)))
            image[row, column] = _phasors(returns, sensor.wavelength) if sensor.kind == "tof" else _middle(returns)
    return image.ravel()


def _faces(box: Box, reflectivity: float) -> list[Piece]:
    corners = corners_of(box)
    faces: list[Piece] = []
    for quad in QUADS.values():
        around = [corners[k] for k in quad]
        normal = np.cross(around[1] - around[0], around[2] - around[1])
        normal = normal / np.linalg.norm(normal)
        faces.append(([c.tolist() for c in around], normal, -float(normal @ around[0]), reflectivity))
    return faces


def _unit(x: float, y: float) -> Array:
    return np.array([x, y, 1.0]) / math.sqrt(x * x + y * y + 1)


def _return(pieces: list[Piece], eye: Array, ray: Array, centre: Array, bend: float) -> Return:
    """Return the range, continued to the centre's ray, the strength and the index of what one sub-ray meets."""
    best, chosen = math.inf, -1
    for index, piece in enumerate(pieces):
        corners, normal, offset, _ = piece
        if corners is None:
            approach, height = -float(normal @ ray), float(normal @ eye) + offset
            distance = height / approach if approach > 1e-12 and height > 0 else math.inf  # seen from its front only
        else:
            distance, _ = hit_polygon([tuple(c) for c in corners], tuple(eye.tolist()), tuple(ray.tolist()))  # type: ignore[misc]
        if distance < best:
            best, chosen = distance, index
    if chosen < 0:
        return math.inf, 0.0, -1
    _, normal, _, reflectivity = pieces[chosen]
    factor = float(normal @ ray) / float(normal @ centre)
    factor = 2.0 if factor < 0 else factor  # the pixel's own ray never meets that plane
    return best * min(max(factor, 1 - bend), 1 + bend), reflectivity * abs(float(normal @ ray)) / best**2, chosen


def _phasors(returns: list[Return], wavelength: float) -> float:
    strongest, weight, _ = max(returns, key=lambda each: each[1])
    if weight == 0:
        return math.inf
    total = sum(w * cmath.exp(2j * math.pi * (r - strongest) / wavelength) for r, w, _ in returns if w > 0)
    return strongest + cmath.phase(total) * wavelength / (2 * math.pi)


def _middle(returns: list[Return]) -> float:
    seen = [piece for _, _, piece in returns]
    most = max(seen, key=seen.count)
    on_it = sorted(r for r, _, piece in returns if piece == most)
    return on_it[(len(on_it) - 1) // 2]


def flipped_edges(sigma: float, rows: int, rng: np.random.Generator, *, sigma_beyond: float | None = None) -> Array:
    """Return (rows, 2): how many pixels of a row see the near side of an edge, and where the last of them is.

    Every pixel of a row looks aside by its own normal displacement, of ``sigma`` on the near side and ``sigma_beyond`` on the far
    one; the edge crosses each row at a place of its own, which is taken off.
    """
    edge = rng.uniform(-0.5, 0.5, rows)
    pixels = np.arange(-12, 13)
    size = np.where(pixels < edge[:, None], sigma, sigma if sigma_beyond is None else sigma_beyond)
    near = pixels + size * rng.standard_normal((rows, len(pixels))) < edge[:, None]
    return np.column_stack([near.sum(axis=1) - edge, [np.flatnonzero(row).max() for row in near] - edge])

"""The state of practice in measuring a box, as a comparison: floor, height of the top, smallest rectangle about the top.

Written after the description of the baseline that others were measured against; it is no product and no part of the package.
"""

import numpy as np
from numpy.typing import NDArray

from viewgain.scans import Scan

Array = NDArray[np.float64]

_HYPOTHESES = 200
_NEAR = 0.015
_REGION = 0.75
_CELL = 0.005


def practice_dimensions(scan: Scan, *, seed: int = 0) -> Array | None:
    """Return (3,) length >= width >= height of the box in the middle of the image, metres; None without a floor or a top.

    RANSAC on three points gives the floor; the highest plateau above it, 5 mm cells of height, is the top face; of its points
    laid on the floor the smallest rectangle is taken, whose ends move in to where the density of points halves.
    """
    rng = np.random.default_rng(seed)
    middle = np.median(scan.points[np.argsort(np.linalg.norm(scan.points[:, :2] / scan.points[:, 2:], axis=1))[:25]], axis=0)
    points = scan.points[np.linalg.norm(scan.points - middle, axis=1) < _REGION]
    floor = _floor(points, rng)
    if floor is None:
        return None
    height = points @ floor[:3] + floor[3]
    top = _plateau(height[height > 0.05])
    if top is None:
        return None
    face = points[np.abs(height - top) < 2 * _NEAR]
    across = np.linalg.svd(floor[None, :3])[2][1:]
    sides = _rectangle(face @ across.T)
    return None if sides is None else -np.sort(-np.array([*sides, top]))


def _floor(points: Array, rng: np.random.Generator) -> Array | None:
    """Return (4,) normal and offset of the plane with the most points that has next to nothing below it."""
    best, most = None, 0.0
    sample = points[rng.choice(len(points), min(3000, len(points)), replace=False)]
    for corners in points[rng.integers(len(points), size=(_HYPOTHESES, 3))]:
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        if np.linalg.norm(normal) < 1e-9:
            continue
        normal /= np.linalg.norm(normal)
        normal *= -np.sign(normal @ corners[0]) or 1.0
        height = (sample - corners[0]) @ normal
        support = float(np.mean(np.abs(height) < _NEAR))
        if support > most and np.mean(height < -3 * _NEAR) < 0.05:
            best, most = np.append(normal, -normal @ corners[0]), support
    if best is None:
        return None
    near = points[np.abs(points @ best[:3] + best[3]) < _NEAR]
    centre = near.mean(axis=0)
    normal = np.linalg.eigh(np.cov((near - centre).T))[1][:, 0]
    normal *= -np.sign(normal @ centre)
    return np.append(normal, -normal @ centre)


def _plateau(height: Array) -> float | None:
    """Return the mean height of the points in and about the fullest 2 cm of height; None with fewer than 50 points."""
    if len(height) < 50:
        return None
    count = np.convolve(np.bincount((height / _CELL).astype(int)), np.ones(4), mode="same")
    level = (float(np.argmax(count)) + 0.5) * _CELL
    return float(np.median(height[np.abs(height - level) < _NEAR]))


def _rectangle(points: Array) -> tuple[float, float] | None:
    """Return the sides of the smallest rectangle about (n, 2) points, each moved in to half the density of points."""
    if len(points) < 50:
        return None
    best, least = 0.0, np.inf
    for angle in np.deg2rad(np.arange(0.0, 90.0, 0.5)):
        sides = [_extent(points @ direction) for direction in _axes(angle)]
        if sides[0] * sides[1] < least:
            best, least = angle, sides[0] * sides[1]
    return tuple(_extent(points @ direction) for direction in _axes(best))  # type: ignore[return-value]


def _axes(angle: float) -> Array:
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def _extent(along: Array) -> float:
    """Return the distance between the positions where the density of points passes half its median."""
    low = along.min() - 4 * _CELL
    blur = np.exp(-0.5 * (np.arange(-4, 5) / 1.5) ** 2)
    density = np.convolve(np.bincount(((along - low) / _CELL).astype(int), minlength=12), blur / blur.sum(), mode="same")
    full = density[density > 0.1 * density.max()]
    dense = np.flatnonzero(density >= np.median(full) / 2)
    return float((dense[-1] - dense[0] + 1) * _CELL)

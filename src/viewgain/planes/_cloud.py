"""What the method works on: points with normals, in the part of the scan that is looked at."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Points, Vector3
from viewgain.planes._normals import cloud_normals, image_normals
from viewgain.planes._settings import Settings
from viewgain.scans import Scan


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """Points with unit normals; the camera is at the origin and the normals turn towards it."""

    points: Points
    """(n, 3), metres, camera frame."""
    normals: Points
    """(n, 3)."""

    def __len__(self) -> int:
        return len(self.points)

    def every(self, stride: int) -> "Cloud":
        """Return every ``stride``-th point."""
        return Cloud(self.points[::stride], self.normals[::stride])


def cloud_of(scan: Scan, settings: Settings) -> Cloud:
    """Return the points of a scan's region with the scan's own normals, or with estimated ones where it has none.

    A wide image is averaged over blocks first, unless it brings normals. The cloud may be empty.
    """
    if scan.normals is not None:
        points, normals = scan.points, scan.normals
    elif scan.shape is None:
        points = _cropped(scan.points, middle_of(scan), settings.region)
        normals = cloud_normals(points, settings.normal_radius) if len(points) else points
    else:
        image = block_means(scan.organised(), round(scan.shape[1] / settings.image_width))
        image = _framed(image, middle_of(scan), settings.region)
        normals = image_normals(image, settings.normal_radius, blocks=settings.block_normals).reshape(-1, 3)
        points = image.reshape(-1, 3)
    kept = np.isfinite(normals[:, 0]) & np.isfinite(points[:, 0])
    if settings.region is not None:
        kept &= np.linalg.norm(points - middle_of(scan), axis=1) < settings.region
    points, normals = points[kept], normals[kept]
    away = np.einsum("nk,nk->n", points, normals) > 0
    return Cloud(points, np.where(away[:, None], -normals, normals))


def middle_of(scan: Scan) -> Vector3:
    """Return the median of the points about the middle of the image, or of an unorganised cloud's own directions."""
    if scan.shape is None or scan.pixels is None:
        directions = scan.points / np.linalg.norm(scan.points, axis=1, keepdims=True)
        off = np.linalg.norm(directions - np.median(directions, axis=0), axis=1)
    else:
        row, column = np.divmod(scan.pixels, scan.shape[1])
        off = np.maximum(np.abs(row - (scan.shape[0] - 1) / 2), np.abs(column - (scan.shape[1] - 1) / 2))
    nearest = np.argpartition(off, min(24, len(off) - 1))[:25]
    return np.asarray(np.median(scan.points[nearest], axis=0))


def block_means(image: Array, side: int) -> Array:
    """Return the means over square blocks of an (h, w, 3) image, of the points each block has; NaN where it has none."""
    if side < 2:
        return image
    rows, columns = image.shape[0] // side, image.shape[1] // side
    blocks = image[: rows * side, : columns * side].reshape(rows, side, columns, side, 3)
    present = np.isfinite(blocks[..., :1])
    count = present.sum(axis=(1, 3))
    total = np.where(present, blocks, 0.0).sum(axis=(1, 3))
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _cropped(points: Points, middle: Vector3, region: float | None) -> Points:
    if region is None:
        return points
    return np.asarray(points[np.linalg.norm(points - middle, axis=1) < region])


def _framed(image: Array, middle: Vector3, region: float | None) -> Array:
    """Return the image without the points outside the region, cut to the rows and columns that keep any."""
    if region is None:
        return image
    with np.errstate(invalid="ignore"):
        inside = np.linalg.norm(image - middle, axis=-1) < region
    rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
    if rows.size == 0:
        return image[:0]
    framed = np.where(inside[..., None], image, np.nan)
    return np.asarray(framed[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1])

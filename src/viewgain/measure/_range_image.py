"""The working form of a scan: one ray and one range per pixel, with a grid for neighbours, whatever the scan came as.

An organised scan keeps its own grid. An unorganised cloud is still a camera's, seen from the origin, so its points fall into a
grid of its own angular pitch; each keeps its exact direction, and empty cells are unknown, not missing.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from viewgain.arrays import Array, Image, Mask, Points, Points2
from viewgain.camera import Intrinsics
from viewgain.scans import Scan

_POLYNOMIAL_DEGREE = 5


@dataclass(frozen=True, slots=True, eq=False)
class RangeImage:
    """Rays, ranges and the pixel grid of one scan."""

    ranges: Image
    """(h, w) radial range, metres; NaN where nothing came back."""
    directions: Array
    """(h, w, 3) unit viewing directions, camera frame."""
    known: Mask
    """(h, w): False where it is unknown whether the camera looked there (empty cells of an unorganised cloud)."""
    intrinsics: Intrinsics
    """The camera, or a fitted or virtual one; maps directions to pixels."""
    lens: "LensMap | None"
    """Stands in for the intrinsics where an organised scan came without."""
    organised: bool
    """Whether the grid is the camera's own."""

    @property
    def points(self) -> Array:
        """(h, w, 3) points, metres, camera frame; NaN where nothing came back."""
        return np.asarray(self.directions * self.ranges[..., None])

    @property
    def valid(self) -> Mask:
        """(h, w) mask of pixels with a return."""
        return np.isfinite(self.ranges)

    @property
    def pitch(self) -> float:
        """Size of a pixel in normalised image coordinates."""
        return 2.0 / (self.intrinsics.fx + self.intrinsics.fy)

    def to_pixels(self, image: Points2) -> Points2:
        """Return the (n, 2) pixel coordinates (u, v) of (n, 2) normalised image points."""
        if self.lens is not None:
            return self.lens.to_pixels(image)
        return self.intrinsics.project(np.column_stack([image, np.ones(len(image))]))


@dataclass(frozen=True, slots=True, eq=False)
class LensMap:
    """A smooth map between pixels and viewing directions, fitted to an organised cloud that came without intrinsics."""

    forward: Array
    """(21, 2) polynomial coefficients, scaled pixels to normalised image points."""
    backward: Array
    """(21, 2) polynomial coefficients, normalised image points to scaled pixels."""
    shape: tuple[int, int]
    """(height, width)."""

    def to_image(self, pixels: Points2) -> Points2:
        """Return the (n, 2) normalised image points of (n, 2) pixels."""
        return np.asarray(_monomials(self._scaled(pixels)) @ self.forward)

    def to_pixels(self, image: Points2) -> Points2:
        """Return the (n, 2) pixels of (n, 2) normalised image points."""
        height, width = self.shape
        return np.asarray((_monomials(image) @ self.backward + 1) / 2 * (width - 1, height - 1))

    def _scaled(self, pixels: Points2) -> Points2:
        height, width = self.shape
        return np.asarray(pixels) * 2.0 / (max(width - 1, 1), max(height - 1, 1)) - 1.0


def range_image(scan: Scan) -> RangeImage:
    """Return the working form of ``scan``; points behind the camera (z <= 0) are left out."""
    if scan.shape is None:
        return _from_cloud(scan.points)
    height, width = scan.shape
    ranges = np.full(height * width, np.nan)
    ranges[scan.pixels] = np.where(scan.points[:, 2] > 0, np.linalg.norm(scan.points, axis=1), np.nan)
    lens = None if scan.intrinsics is not None else _fit_lens(scan)
    if scan.intrinsics is not None:
        image, camera = scan.intrinsics.rays(), scan.intrinsics
    else:
        assert lens is not None
        u, v = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
        image = lens.to_image(np.column_stack([u.ravel(), v.ravel()])).reshape(height, width, 2)
        camera = _pinhole_like(image)
    directions = _unit(image.reshape(-1, 2))
    measured = np.isfinite(ranges)
    own = scan.points[measured[scan.pixels]]
    directions[measured] = own / np.linalg.norm(own, axis=1, keepdims=True)
    return RangeImage(
        ranges.reshape(height, width), directions.reshape(height, width, 3), np.ones((height, width), dtype=bool), camera, lens, True
    )


def _from_cloud(points: Points) -> RangeImage:
    points = points[points[:, 2] > 1e-6]
    image = points[:, :2] / points[:, 2:]
    low, high = np.quantile(image, [0.001, 0.999], axis=0)
    margin = 0.02 * (high - low)
    inside = np.all((image >= low - margin) & (image <= high + margin), axis=1)
    points, image = points[inside], image[inside]
    low = image.min(axis=0)
    pitch = max(_angular_pitch(image), float((image.max(axis=0) - low).max()) / 1500)
    column, row = np.round((image - low) / pitch).astype(int).T
    width, height = int(column.max()) + 1, int(row.max()) + 1
    focal = 1 / pitch
    camera = Intrinsics(width=width, height=height, fx=focal, fy=focal, cx=-low[0] * focal, cy=-low[1] * focal)
    directions = _unit(camera.rays().reshape(-1, 2))
    ranges = np.full(height * width, np.nan)
    distance = np.linalg.norm(points, axis=1)
    far_first = np.argsort(-distance)
    cell = (row * width + column)[far_first]
    ranges[cell] = distance[far_first]
    directions[cell] = points[far_first] / distance[far_first, None]
    shape = (height, width)
    ranges = ranges.reshape(shape)
    return RangeImage(ranges, directions.reshape(*shape, 3), np.isfinite(ranges), camera, None, False)


def _angular_pitch(image: Points2) -> float:
    """Return the pixel pitch of an unorganised cloud in the normalised image: the root of the area each point has to itself."""
    neighbours = 12
    sample = image[:: max(1, len(image) // 2000)]
    distance, _ = cKDTree(image).query(sample, k=neighbours + 1)
    return max(float(np.median(distance[:, -1])) * float(np.sqrt(np.pi / neighbours)), 1e-4)


def _fit_lens(scan: Scan) -> LensMap:
    assert scan.shape is not None
    assert scan.pixels is not None
    height, width = scan.shape
    ahead = np.flatnonzero(scan.points[:, 2] > 0)
    chosen = ahead[:: max(1, len(ahead) // 4000)]
    image = scan.points[chosen, :2] / scan.points[chosen, 2:]
    row, column = np.divmod(scan.pixels[chosen], width)
    lens = LensMap(np.empty((0, 2)), np.empty((0, 2)), (height, width))
    scaled = lens._scaled(np.column_stack([column, row]))
    forward = np.linalg.lstsq(_monomials(scaled), image, rcond=1e-10)[0]
    backward = np.linalg.lstsq(_monomials(image), scaled, rcond=1e-10)[0]
    return LensMap(forward, backward, (height, width))


def _pinhole_like(image: Array) -> Intrinsics:
    height, width = image.shape[:2]
    row, column = height // 2, width // 2
    fx = 1 / abs(float(np.median(np.diff(image[row, :, 0])))) if width > 1 else 1.0
    fy = 1 / abs(float(np.median(np.diff(image[:, column, 1])))) if height > 1 else 1.0
    return Intrinsics(width=width, height=height, fx=fx, fy=fy, cx=(width - 1) / 2, cy=(height - 1) / 2)


def _monomials(points: Points2) -> Array:
    x, y = np.asarray(points, dtype=float).T
    return np.stack([x**i * y**j for i in range(_POLYNOMIAL_DEGREE + 1) for j in range(_POLYNOMIAL_DEGREE + 1 - i)], axis=1)


def _unit(image: Points2) -> Points:
    rays = np.column_stack([image, np.ones(len(image))])
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))

"""The working form of a scan: one ray and one range per pixel, with a grid for neighbours, whatever the scan came as.

An organised scan keeps its own grid. An unorganised cloud is still a camera's, seen from the origin, so its points fall into a
grid of its own angular pitch; each keeps its exact direction, and empty cells are unknown, not missing.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from viewgain.arrays import Array, Image, Indices, Mask, Points, Points2
from viewgain.camera import Intrinsics, Sensor
from viewgain.scans import MIN_POINTS, Scan

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

    def whole_camera(self) -> Intrinsics:
        """Return the camera that took the scan, as far as it shows.

        An unorganised cloud may be a crop: its camera is taken to see as far to the left as to the right of the optical axis,
        and as far up as down.
        """
        if self.organised:
            return self.intrinsics
        camera = self.intrinsics
        half_width = max(camera.cx, camera.width - 1 - camera.cx)
        half_height = max(camera.cy, camera.height - 1 - camera.cy)
        width, height = round(2 * half_width) + 1, round(2 * half_height) + 1
        return replace(camera, width=width, height=height, cx=(width - 1) / 2, cy=(height - 1) / 2)

    def corrected(self, sensor: Sensor) -> "RangeImage":
        """Return the image without the known range error of ``sensor``."""
        return replace(self, ranges=sensor.true_ranges(self.ranges))

    @property
    def plane(self) -> "ImagePlane":
        """Where directions fall in the image, and where it ends."""
        height, width = self.ranges.shape
        return ImagePlane(self.intrinsics, self.lens, (width, height))


@dataclass(frozen=True, slots=True, eq=False)
class ImagePlane:
    """Where directions fall in an image, and where the image ends."""

    intrinsics: Intrinsics
    """The camera."""
    lens: "LensMap | None"
    """Stands in for the intrinsics where an organised scan came without."""
    size: tuple[int, int]
    """(width, height), pixels."""

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
        return np.asarray(_monomials(_scaled(pixels, self.shape)) @ self.forward)

    def to_pixels(self, image: Points2) -> Points2:
        """Return the (n, 2) pixels of (n, 2) normalised image points."""
        height, width = self.shape
        return np.asarray((_monomials(image) @ self.backward + 1) / 2 * (width - 1, height - 1))

    def pinhole(self) -> Intrinsics:
        """Return the pinhole camera that agrees with the lens at the centre of the image."""
        height, width = self.shape
        cx, cy = (width - 1) / 2, (height - 1) / 2
        right, left, below, above = self.to_image(np.array([[cx + 1, cy], [cx - 1, cy], [cx, cy + 1], [cx, cy - 1]]))
        fx, fy = 2 / max(abs(right[0] - left[0]), 1e-6), 2 / max(abs(below[1] - above[1]), 1e-6)
        return Intrinsics(width=width, height=height, fx=float(fx), fy=float(fy), cx=cx, cy=cy)


def range_image(scan: Scan) -> RangeImage:
    """Return the working form of ``scan``; points behind the camera are left out, and if few remain the image is empty."""
    if scan.shape is None or scan.pixels is None:
        return _from_cloud(scan.points)
    height, width = scan.shape
    ahead = scan.points[:, 2] > 0
    own, at = scan.points[ahead], scan.pixels[ahead]
    distance = np.linalg.norm(own, axis=1)
    ranges, directions = np.full(height * width, np.nan), np.empty((height * width, 3))
    ranges[at], directions[at] = distance, own / distance[:, None]
    empty = np.flatnonzero(np.isnan(ranges))
    pixels = np.stack(np.divmod(empty, width)[::-1], axis=1)
    if scan.intrinsics is not None:
        camera, lens = scan.intrinsics, None
        directions[empty] = _unit(camera.rays().reshape(-1, 2)[empty])
    else:
        lens = _fit_lens(own, at, scan.shape)
        camera = lens.pinhole()
        directions[empty] = _unit(lens.to_image(pixels))
    grid = (height, width)
    return RangeImage(ranges.reshape(grid), directions.reshape(*grid, 3), np.ones(grid, dtype=bool), camera, lens, True)


def _from_cloud(points: Points) -> RangeImage:
    points = points[points[:, 2] > 1e-6]
    if len(points) < MIN_POINTS:
        nothing = Intrinsics(width=1, height=1, fx=1.0, fy=1.0, cx=0.0, cy=0.0)
        return RangeImage(
            np.full((1, 1), np.nan), np.array([[[0.0, 0.0, 1.0]]]), np.zeros((1, 1), dtype=bool), nothing, None, False
        )
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


def _fit_lens(points: Points, pixels: Indices, shape: tuple[int, int]) -> LensMap:
    chosen = slice(None, None, max(1, len(points) // 4000))
    image = points[chosen, :2] / points[chosen, 2:]
    row, column = np.divmod(pixels[chosen], shape[1])
    scaled = _scaled(np.column_stack([column, row]), shape)
    forward = np.linalg.lstsq(_monomials(scaled), image, rcond=1e-10)[0]
    backward = np.linalg.lstsq(_monomials(image), scaled, rcond=1e-10)[0]
    return LensMap(np.asarray(forward, dtype=float), np.asarray(backward, dtype=float), shape)


def _scaled(pixels: Points2, shape: tuple[int, int]) -> Points2:
    """Return pixel coordinates scaled to [-1, 1] over the image."""
    return np.asarray(pixels) * 2.0 / (max(shape[1] - 1, 1), max(shape[0] - 1, 1)) - 1.0


def _monomials(points: Points2) -> Array:
    x, y = np.asarray(points, dtype=float).T
    return np.stack([x**i * y**j for i in range(_POLYNOMIAL_DEGREE + 1) for j in range(_POLYNOMIAL_DEGREE + 1 - i)], axis=1)


def _unit(image: Points2) -> Points:
    rays = np.column_stack([image, np.ones(len(image))])
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))

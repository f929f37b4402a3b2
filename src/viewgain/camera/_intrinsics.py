"""The pinhole camera with lens distortion: pixels to rays and back. Pixel (0, 0) is the centre of the top-left pixel."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from viewgain.arrays import Array, Points, Points2
from viewgain.errors import ConfigError

MOST_PIXELS = 50_000_000
"""More than any depth camera has; beyond it a slip of the keyboard fills the memory."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Intrinsics:
    """A pinhole camera with Brown or rational lens distortion (OpenCV's coefficient order)."""

    width: int
    """Image width, pixels."""
    height: int
    """Image height, pixels."""
    fx: float
    """Focal length along x, pixels."""
    fy: float
    """Focal length along y, pixels."""
    cx: float
    """Principal point, pixels; (width - 1) / 2 for a centred lens."""
    cy: float
    """Principal point, pixels; (height - 1) / 2 for a centred lens."""
    distortion: tuple[float, ...] = ()
    """(k1, k2, p1, p2[, k3[, k4, k5, k6]]): 4 or 5 numbers are Brown's model, 8 the rational one; empty is none."""

    def __post_init__(self) -> None:
        if self.width < 1 or self.height < 1:
            raise ConfigError(f"intrinsics: got an image of {self.width} x {self.height} pixels, wanted at least 1 x 1")
        if self.width * self.height > MOST_PIXELS:
            raise ConfigError(
                f"intrinsics: got an image of {self.width} x {self.height} pixels, wanted at most {MOST_PIXELS:,} in all"
            )
        numbers = (self.fx, self.fy, self.cx, self.cy, *self.distortion)
        if not np.all(np.isfinite(numbers)) or self.fx <= 0 or self.fy <= 0:
            raise ConfigError(f"intrinsics: got fx={self.fx}, fy={self.fy}, wanted finite numbers and positive focal lengths")
        if len(self.distortion) not in (0, 4, 5, 8):
            raise ConfigError(f"intrinsics: got {len(self.distortion)} distortion coefficients, wanted 0, 4, 5 or 8")

    @classmethod
    def from_field_of_view(cls, width: int, height: int, horizontal: float, vertical: float) -> "Intrinsics":
        """Return a centred pinhole of ``width`` x ``height`` pixels that spans the two full angles (radians)."""
        return cls(
            width=width,
            height=height,
            fx=width / 2 / np.tan(horizontal / 2),
            fy=height / 2 / np.tan(vertical / 2),
            cx=(width - 1) / 2,
            cy=(height - 1) / 2,
        )

    def rays(self) -> Array:
        """Return the (height, width, 2) viewing directions (x/z, y/z) of all pixel centres, distortion removed."""
        u, v = np.meshgrid(np.arange(self.width, dtype=float), np.arange(self.height, dtype=float))
        return self.undistort(np.stack([(u - self.cx) / self.fx, (v - self.cy) / self.fy], axis=-1))

    def directions(self) -> Array:
        """Return the (height, width, 3) unit directions of all pixel centres, camera frame; shared, not to be written to."""
        return _directions(self)

    def project(self, points: Points) -> Points2:
        """Return the (..., 2) pixel coordinates (u, v) of (..., 3) camera-frame points with z > 0."""
        distorted = self.distort(points[..., :2] / points[..., 2:])
        return np.asarray(distorted * (self.fx, self.fy) + (self.cx, self.cy))

    def distort(self, directions: Points2) -> Points2:
        """Return where the lens images (..., 2) undistorted directions (x/z, y/z), in normalised coordinates."""
        if not self.distortion:
            return directions
        k1, k2, p1, p2, k3, k4, k5, k6 = (*self.distortion, *[0.0] * (8 - len(self.distortion)))
        x, y = directions[..., 0], directions[..., 1]
        r2 = x * x + y * y
        radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
        dx = 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
        dy = p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
        return np.stack([x * radial + dx, y * radial + dy], axis=-1)

    def undistort(self, directions: Points2) -> Points2:
        """Return the inverse of :meth:`distort`, by Newton's method: under 1e-9 wherever the lens does not fold back on itself.

        Where it does, nothing is imaged there; the input comes back, and :meth:`distort` does not lead to it.
        """
        if not self.distortion:
            return directions
        estimate, small = np.asarray(directions, dtype=float), 1e-6
        with np.errstate(all="ignore"):
            for _ in range(12):
                error = self.distort(estimate) - directions
                right, down = (self.distort(estimate + step) - self.distort(estimate - step) for step in small * np.eye(2))
                a, c, b, d = *np.moveaxis(right / (2 * small), -1, 0), *np.moveaxis(down / (2 * small), -1, 0)
                inverse = np.stack([d * error[..., 0] - b * error[..., 1], a * error[..., 1] - c * error[..., 0]], axis=-1)
                estimate = estimate - inverse / (a * d - b * c)[..., None]
            unfolded = (a * d - b * c > 0) & (a > 0) & np.all(np.isfinite(estimate), axis=-1)
        return np.where(unfolded[..., None], estimate, directions)


@lru_cache(maxsize=16)
def _directions(camera: Intrinsics) -> Array:
    rays = camera.rays()
    directions = np.dstack([rays, np.ones(rays.shape[:2])])
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    directions.setflags(write=False)
    return directions

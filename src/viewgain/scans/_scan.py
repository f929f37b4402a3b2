"""One depth scan as a value: points in the camera frame and, where the file had one, the image they came from."""

from dataclasses import dataclass, field, replace

import numpy as np

from viewgain.arrays import Array, Image, Indices, Points, Pose
from viewgain.camera import Intrinsics
from viewgain.errors import ScanError
from viewgain.geometry import require_rigid

MIN_POINTS = 100
"""Fewer valid points than this carry no measurable box."""


@dataclass(frozen=True, slots=True)
class Dropped:
    """How many returns were left out of a scan, and why."""

    not_a_number: int = 0
    infinite: int = 0
    zero: int = 0
    weak: int = 0
    """Valid returns under the reader's ``min_amplitude``."""

    @property
    def total(self) -> int:
        """All returns left out."""
        return self.not_a_number + self.infinite + self.zero + self.weak


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scan:
    """One depth scan: valid points (metres, camera frame: x right, y down, z forward) and what is known about them."""

    points: Points
    """(n, 3) valid returns, metres, camera frame; n >= 100, all finite, none at the origin."""
    pixels: Indices | None = None
    """(n,) row-major pixel index of each point in an organised scan; None for an unorganised cloud."""
    shape: tuple[int, int] | None = None
    """(height, width) of the image of an organised scan."""
    intrinsics: Intrinsics | None = None
    """The camera, where the file named it; an organised cloud may come without."""
    normals: Points | None = None
    """(n, 3) unit normals, where the file had them."""
    amplitude: Image | None = None
    """(height, width) signal strength in the camera's own units, where the file had it."""
    camera_to_world: Pose | None = None
    """Pose of the camera in the world (z up), where known."""
    source: str = "array"
    """Where the scan came from, for messages."""
    dropped: Dropped = Dropped()
    """Returns left out while reading."""
    notes: tuple[str, ...] = field(default=())
    """What the reader decided (units, axes), in sentences a user can check."""

    def __post_init__(self) -> None:
        points = np.ascontiguousarray(self.points, dtype=float)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ScanError(f"{self.source}: got points of shape {np.shape(self.points)}, wanted (n, 3)")
        if len(points) < MIN_POINTS:
            raise ScanError(f"{self.source}: {len(points)} valid points, wanted at least {MIN_POINTS}; is the scene in range?")
        if not np.all(np.isfinite(points)):
            raise ScanError(f"{self.source}: some points are not finite; make the scan with viewgain.Scan.from_array")
        object.__setattr__(self, "points", points)
        if (self.pixels is None) != (self.shape is None) or (self.pixels is not None and len(self.pixels) != len(points)):
            raise ScanError(f"{self.source}: an organised scan needs its image shape and one pixel index per point")
        if self.normals is not None and np.shape(self.normals) != points.shape:
            raise ScanError(f"{self.source}: got normals of shape {np.shape(self.normals)}, wanted {points.shape}")
        if self.camera_to_world is not None:
            object.__setattr__(self, "camera_to_world", require_rigid(self.camera_to_world, "camera_to_world"))

    @classmethod
    def from_array(
        cls,
        array: Array,
        *,
        intrinsics: Intrinsics | None = None,
        normals: Points | None = None,
        amplitude: Image | None = None,
        camera_to_world: Pose | None = None,
        source: str = "array",
        notes: tuple[str, ...] = (),
    ) -> "Scan":
        """Return a scan from (n, 3) unorganised or (h, w, 3) organised points in metres, camera frame.

        Returns that are NaN, infinite or at the origin (depth zero) are dropped and counted.

        Args:
            array: Points, metres, camera frame; (h, w, 3) keeps the image.
            intrinsics: The camera, if known; its size must be the image's.
            normals: Unit normals of the same shape as ``array``.
            amplitude: (h, w) signal strength, for organised scans.
            camera_to_world: (4, 4) pose of the camera, if known.
            source: Name for messages.
            notes: Decisions of the reader to carry along.

        Raises:
            ScanError: If the shape is wrong or fewer than 100 valid points remain.
        """
        array = np.asarray(array, dtype=float)
        if array.ndim not in (2, 3) or array.shape[-1] != 3:
            raise ScanError(f"{source}: got an array of shape {array.shape}, wanted (n, 3) or (h, w, 3) points")
        flat = array.reshape(-1, 3)
        # Column by column: a reduction along an axis of length 3 takes several times as long.
        x, y, z = flat.T
        not_a_number = np.isnan(x) | np.isnan(y) | np.isnan(z)
        finite = np.isfinite(x) & np.isfinite(y) & np.isfinite(z)
        zero = (np.abs(x) < 1e-9) & (np.abs(y) < 1e-9) & (np.abs(z) < 1e-9)
        infinite = ~finite & ~not_a_number
        valid = finite & ~zero
        organised = array.ndim == 3
        if intrinsics is not None and (not organised or array.shape[:2] != (intrinsics.height, intrinsics.width)):
            raise ScanError(
                f"{source}: got points of shape {array.shape} with intrinsics of {intrinsics.width} x {intrinsics.height} pixels;"
                " wanted the image of that camera"
            )
        return cls(
            points=flat[valid],
            pixels=np.flatnonzero(valid) if organised else None,
            shape=(array.shape[0], array.shape[1]) if organised else None,
            intrinsics=intrinsics,
            normals=None if normals is None else np.asarray(normals, dtype=float).reshape(-1, 3)[valid],
            amplitude=amplitude,
            camera_to_world=camera_to_world,
            source=source,
            dropped=Dropped(int(not_a_number.sum()), int(infinite.sum()), int(zero.sum())),
            notes=notes,
        )

    @classmethod
    def from_range(
        cls,
        ranges: Image,
        intrinsics: Intrinsics,
        *,
        amplitude: Image | None = None,
        camera_to_world: Pose | None = None,
        source: str = "array",
    ) -> "Scan":
        """Return a scan from an (h, w) image of radial ranges, metres along each pixel's ray; 0, NaN or infinite is no return.

        Raises:
            ScanError: If the image is not the camera's, or fewer than 100 pixels have a return.
        """
        flat = np.asarray(ranges, dtype=float).ravel()
        if np.shape(ranges) != (intrinsics.height, intrinsics.width):
            raise ScanError(
                f"{source}: got an image of shape {np.shape(ranges)} with intrinsics of {intrinsics.width} x {intrinsics.height}"
                " pixels; wanted the image of that camera"
            )
        not_a_number, infinite, zero = np.isnan(flat), np.isinf(flat), np.abs(flat) < 1e-9
        pixels = np.flatnonzero(~(not_a_number | infinite | zero))
        return cls(
            points=intrinsics.directions().reshape(-1, 3)[pixels] * flat[pixels, None],
            pixels=pixels,
            shape=(intrinsics.height, intrinsics.width),
            intrinsics=intrinsics,
            amplitude=amplitude,
            camera_to_world=camera_to_world,
            source=source,
            dropped=Dropped(int(not_a_number.sum()), int(infinite.sum()), int(zero.sum())),
        )

    def posed(self, camera_to_world: Pose) -> "Scan":
        """Return the same scan with another pose of the camera."""
        return replace(self, camera_to_world=camera_to_world)

    def organised(self) -> Array:
        """Return the (h, w, 3) image of points with NaN where there was no return.

        Raises:
            ScanError: If the cloud is unorganised.
        """
        if self.shape is None or self.pixels is None:
            raise ScanError(f"{self.source}: an unorganised cloud has no image")
        image = np.full((self.shape[0] * self.shape[1], 3), np.nan)
        image[self.pixels] = self.points
        return image.reshape(*self.shape, 3)

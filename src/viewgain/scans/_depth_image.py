"""Depth images: 16-bit PNGs with a camera file, and the step from depth to points that the other readers share."""

import io
import struct
from pathlib import Path
from typing import Any

import numpy as np

from viewgain.arrays import Array, Image, Mask
from viewgain.camera import Intrinsics
from viewgain.errors import ScanError
from viewgain.scans._intrinsics_file import DepthCamera, resolve_camera
from viewgain.scans._raw import RawScan, one_line, require_magic

_SATURATED = 65535
"""The largest count, which cameras use for "too far" or "too bright"; read as infinite."""
_LARGEST_EXPANSION = 1100
"""Deflate packs at most 1032 bytes into one, so an image header that claims more lies."""
_LARGEST_IMAGE = 2**26
"""Pixels; more than any depth camera has, and few enough for Pillow to say nothing."""
_END = b"IEND\xaeB`\x82"
_KINDS = {"L": "an 8-bit grey", "P": "a palette", "1": "a black-and-white", "RGB": "a colour", "RGBA": "a colour"}


def read_depth_png(path: Path, data: bytes, camera: Intrinsics | Path | None) -> RawScan:
    """Return the points of a 16-bit depth PNG; 0 is no return and 65535 an infinite one.

    Without ``camera`` the JSON file beside the image is taken: ``<stem>.json``, then ``intrinsics.json``.

    Raises:
        ScanError: If it is no whole 16-bit grey PNG, or no camera file is given or found.
        ConfigError: If the camera file makes no sense or is for another image size.
    """
    counts, mode = decode_png(path, data)
    if not mode.startswith("I"):
        raise ScanError(
            f"{path}: is {_KINDS.get(mode, 'a ' + mode)} image, wanted a 16-bit grey depth image;"
            " export the raw depth, not a picture of it"
        )
    notes: tuple[str, ...] = ()
    if camera is None:
        camera = _beside(path)
        notes = (f"camera: taken from {camera} beside the image",)
    camera_file = resolve_camera(camera, (counts.shape[1], counts.shape[0]), path)
    depth = np.where(counts >= _SATURATED, np.inf, counts.astype(float))
    points, depth_notes = depth_to_points(depth, camera_file)
    return RawScan(
        points=points,
        scale=camera_file.scale or 0.001,
        scale_note=camera_file.scale_note or "read as one millimetre per count (no depth_scale given)",
        from_depth=True,
        intrinsics=camera_file.intrinsics,
        camera_to_world=camera_file.camera_to_world,
        notes=notes + depth_notes,
    )


def _beside(path: Path) -> Path:
    for candidate in (path.with_suffix(".json"), path.with_name("intrinsics.json")):
        if candidate.is_file():
            return candidate
    beside = f"put {path.stem}.json or intrinsics.json beside it"
    raise ScanError(f"{path}: a depth image needs its camera; give intrinsics=<file.json> or {beside}")


def decode_png(path: Path, data: bytes) -> tuple[Array, str]:
    """Return the pixels of a PNG as they are stored, (h, w) or (h, w, channels), and Pillow's name of their type.

    Raises:
        ScanError: If it is no PNG, is truncated or damaged, or claims more pixels than the file can hold.
    """
    from PIL import Image as Pillow
    from PIL import UnidentifiedImageError

    require_magic(path, data, "PNG", b"\x89PNG")
    if _END not in data:
        raise ScanError(f"{path}: the PNG is truncated (no end mark); export it again")
    width, height = struct.unpack(">II", data[16:24])
    if width * height > min(_LARGEST_EXPANSION * len(data), _LARGEST_IMAGE):
        raise ScanError(f"{path}: the PNG claims {width} x {height} pixels in {len(data)} bytes; it is damaged; export it again")
    try:
        with Pillow.open(io.BytesIO(data), formats=["PNG"]) as image:
            return np.asarray(image), image.mode
    except UnidentifiedImageError as error:
        raise ScanError(f"{path}: the PNG header is damaged; export it again") from error
    except Exception as error:
        raise ScanError(f"{path}: the PNG is truncated or damaged ({one_line(error)}); export it again") from error


def depth_to_points(depth: Image, camera: DepthCamera) -> tuple[Array, tuple[str, ...]]:
    """Return (h, w, 3) points, in the units of the (h, w) ``depth``, camera frame, and notes.

    Depth 0 gives the origin and NaN or infinite depth such a point, so that they are counted as what they are. Pixels outside the
    range where the lens model can be inverted are NaN.
    """
    rays, outside = _rays(camera.intrinsics)
    directions: Any = np.dstack([rays, np.ones(rays.shape[:2])])
    if camera.kind == "range":
        directions = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    finite = np.isfinite(depth)
    points = np.where(finite[..., None], directions * np.where(finite, depth, 0.0)[..., None], depth[..., None])
    outside &= depth != 0
    points[outside] = np.nan
    lost = np.count_nonzero(outside)
    return points, (f"lens: {lost} returns lie where the distortion model cannot be inverted; dropped as NaN",) if lost else ()


def _rays(intrinsics: Intrinsics) -> tuple[Array, Mask]:
    """Return the (h, w, 2) rays and the (h, w) mask of pixels whose ray does not project back to within half a pixel of them."""
    with np.errstate(all="ignore"):  # outside the range of the lens model the iteration runs away
        rays = intrinsics.rays()
        back = intrinsics.distort(rays) * (intrinsics.fx, intrinsics.fy) + (intrinsics.cx, intrinsics.cy)
    u, v = np.meshgrid(np.arange(intrinsics.width), np.arange(intrinsics.height))
    outside = ~(np.hypot(back[..., 0] - u, back[..., 1] - v) < 0.5)
    return np.where(outside[..., None], 0.0, rays), outside


def decode_amplitude(path: Path, data: bytes) -> Image:
    """Return an (h, w) amplitude image from an 8-bit or 16-bit grey PNG.

    Raises:
        ScanError: If it is no grey PNG.
    """
    pixels, mode = decode_png(path, data)
    if mode != "L" and not mode.startswith("I"):
        raise ScanError(f"{path}: is {_KINDS.get(mode, 'a ' + mode)} image, wanted an 8-bit or 16-bit grey amplitude image")
    return pixels.astype(float)

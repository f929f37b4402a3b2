"""What a format reader hands back before units, axes and amplitude are settled, and the checks that all readers share."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np

from viewgain.arrays import Array, Image, Points, Pose
from viewgain.camera import Intrinsics
from viewgain.errors import ScanError
from viewgain.errors import one_line as one_line
from viewgain.errors import printable as printable

PathLike: TypeAlias = str | os.PathLike[str]

LARGEST_FILE = 2**30
"""Bytes; no depth scan comes near, so a larger file (or a header that claims more) is refused before it is read."""

MAGIC = {b"ply": ".ply", b"# .PCD": ".pcd", b"VERSION": ".pcd", b"\x93NUMPY": ".npy", b"PK\x03\x04": ".npz", b"\x89PNG": ".png"}
"""First bytes of each binary format, and the extension that it goes by."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RawScan:
    """Points as the file has them: its units, its axes, invalid returns still in place."""

    points: Array
    """(n, 3), or (h, w, 3) for an image."""
    scale: float | None = None
    """Metres per unit of ``points`` where the file says so; None leaves it to the units rule."""
    scale_note: str = ""
    """How ``scale`` is known, for the notes."""
    from_depth: bool = False
    """Whether the points were made from a depth image, so that the axes are known to be the camera's."""
    normals: Points | None = None
    """Same shape as ``points``."""
    amplitude: Image | None = None
    """(h, w) signal strength."""
    intrinsics: Intrinsics | None = None
    """The camera, where the file or its sidecar names it."""
    camera_to_world: Pose | None = None
    """Pose in the file's axes."""
    pose_in_file_units: bool = False
    """Whether the translation of the pose is in the units of the points (else metres)."""
    notes: tuple[str, ...] = ()
    """Decisions of the reader."""


def load_bytes(path: Path) -> bytes:
    """Return the content of a scan file.

    Raises:
        ScanError: If there is no such file, it is not a regular file, it is empty or over 1 GiB.
    """
    if not path.exists():
        raise ScanError(f"{path}: no such file; check the path")
    if not path.is_file():
        raise ScanError(f"{path}: is a folder, not a scan; give one file" if path.is_dir() else f"{path}: is not a regular file")
    size = path.stat().st_size
    if size == 0:
        raise ScanError(f"{path}: the file is empty (0 bytes); export the scan again")
    if size > LARGEST_FILE:
        raise ScanError(f"{path}: {size / 1e9:.1f} GB is larger than any depth scan (limit 1.07 GB); is this the right file?")
    return path.read_bytes()


def require_magic(path: Path, data: bytes, kind: str, *magics: bytes) -> None:
    """Refuse ``data`` that does not begin like a file of this ``kind`` ("PLY"), naming what it looks like."""
    if data.startswith(magics):
        return
    other = next((extension for magic, extension in MAGIC.items() if data.startswith(magic)), None)
    looks = f"it looks like a {other} file; rename it" if other else "its first bytes are something else; export the scan again"
    raise ScanError(f"{path}: is not a {kind} file: {looks}")


def require_room(path: Path, claimed: int, available: int, what: str) -> None:
    """Refuse a header that claims more bytes than the file holds, before anything is allocated."""
    if claimed > available:
        raise ScanError(
            f"{path}: the header claims {what} ({claimed} bytes) but only {available} bytes follow;"
            " the file is truncated or its header is wrong; export the scan again"
        )


def grid(values: Points, pixels: Array, shape: tuple[int, int]) -> Array:
    """Return the (h, w, 3) image that has ``values`` (n, 3) at row-major ``pixels`` (n,) and NaN elsewhere."""
    image = np.full((shape[0] * shape[1], 3), np.nan)
    image[pixels.astype(np.intp)] = values
    return image.reshape(*shape, 3)

"""Writing scans as PLY, NPZ or depth PNG: whole files or none (a temporary file in the same folder, then a rename)."""

import contextlib
import io
import json
import os
import secrets
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Indices, Points, Pose
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError, ScanError
from viewgain.scans._raw import PathLike, one_line, printable
from viewgain.scans._scan import Scan

_LARGEST_COUNT = 65534
"""The last count of a 16-bit depth image; 65535 is read as infinite."""


def write_scan(scan: Scan, path: PathLike, *, depth_scale: float = 0.001, depth_kind: str = "z") -> None:
    """Write a scan; the extension decides the format. :func:`read_scan` gives the same points in the same order back.

    ``.ply``: binary, points and normals in float64, with image, pose and units in comments. ``.npz``: all that a scan has but its
    notes. ``.png``: the depth image with the camera, depth scale and pose in ``<stem>.json`` beside it; needs an organised scan
    with intrinsics whose points lie on their pixels' rays, and rounds to ``depth_scale``.

    Args:
        scan: The scan.
        path: Where to; an existing file is replaced.
        depth_scale: Metres per count of the PNG, from 1e-6 to 0.01.
        depth_kind: "z" or "range", for the PNG.

    Raises:
        ScanError: If the folder is missing, full or not writable (nothing is left behind), or the scan does not fit the format.
        ConfigError: If ``depth_scale`` or ``depth_kind`` makes no sense.
    """
    path = Path(path)
    writers = {
        ".ply": lambda: {path: _ply(scan)},
        ".npz": lambda: {path: _npz(scan)},
        ".png": lambda: _png(scan, path, depth_scale, depth_kind),
    }
    if path.suffix.lower() not in writers:
        raise ScanError(f"{path}: cannot write '{path.suffix}' files; wanted one of {' '.join(writers)}")
    write_files(writers[path.suffix.lower()]())


def write_files(files: dict[Path, bytes]) -> None:
    """Write all files or none, each at once in place of an old one (of several files, the last is the one that counts).

    Raises:
        ScanError: If one cannot be written; temporary files are removed and replaced files are put back, also on Ctrl-C.
    """
    token = secrets.token_hex(4)
    temporary = {path: path.with_name(f".{path.name}.{token}.tmp") for path in files}
    undo: dict[Path, bytes | None] = {}
    path = next(iter(files))
    try:
        for path, content in files.items():
            with temporary[path].open("xb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        for path in files:
            old = path.read_bytes() if len(files) > 1 and path.exists() else None
            os.replace(temporary[path], path)  # noqa: PTH105 - os.replace is what the tests break
            undo[path] = old
    except BaseException as error:
        _take_back(temporary.values(), undo)
        if not isinstance(error, OSError):
            raise
        reason = error.strerror or one_line(error)
        raise ScanError(printable(f"{path}: cannot be written ({reason}); check the folder and its free space")) from error


def _take_back(temporary: Iterable[Path], undo: dict[Path, bytes | None]) -> None:
    """Remove temporary files (which makes room), then put every replaced file back as it was."""
    for path in temporary:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)
    for path, old in undo.items():
        with contextlib.suppress(OSError):
            if old is None:
                path.unlink(missing_ok=True)
            else:
                path.write_bytes(old)


def _ply(scan: Scan) -> bytes:
    columns: dict[str, NDArray[Any]] = {name: scan.points[:, axis] for axis, name in enumerate("xyz")}
    comments = ["comment viewgain units m"]
    if scan.normals is not None:
        columns |= {name: scan.normals[:, axis] for axis, name in enumerate(("nx", "ny", "nz"))}
    if scan.shape is not None and scan.pixels is not None:
        columns["pixel"] = scan.pixels
        comments.append(f"comment viewgain image {scan.shape[0]} {scan.shape[1]}")
    if scan.camera_to_world is not None:
        numbers = " ".join(repr(float(number)) for number in scan.camera_to_world.flat)
        comments.append(f"comment viewgain camera_to_world {numbers}")
    types = {name: "int" if name == "pixel" else "double" for name in columns}
    table = np.zeros(len(scan.points), dtype=[(name, "<i4" if kind == "int" else "<f8") for name, kind in types.items()])
    for name, column in columns.items():
        table[name] = column
    properties = [f"property {kind} {name}" for name, kind in types.items()]
    header = ["ply", "format binary_little_endian 1.0", *comments, f"element vertex {len(table)}", *properties, "end_header", ""]
    return "\n".join(header).encode() + table.tobytes()


def _npz(scan: Scan) -> bytes:
    organised = scan.shape is not None
    arrays: dict[str, Any] = {"points": scan.organised() if organised else scan.points, "units": np.array("m")}
    if scan.normals is not None:
        arrays["normals"] = scan.normals
        if scan.shape is not None and scan.pixels is not None:
            normals = np.full((scan.shape[0] * scan.shape[1], 3), np.nan)
            normals[scan.pixels] = scan.normals
            arrays["normals"] = normals.reshape(*scan.shape, 3)
    if scan.intrinsics is not None:
        camera = scan.intrinsics
        arrays |= {"K": np.array([camera.fx, camera.fy, camera.cx, camera.cy]), "distortion": np.array(camera.distortion)}
    arrays |= {name: value for name in ("amplitude", "camera_to_world") if (value := getattr(scan, name)) is not None}
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()


def _png(scan: Scan, path: Path, depth_scale: float, depth_kind: str) -> dict[Path, bytes]:
    from PIL import Image as Pillow

    if not 1e-6 <= depth_scale <= 0.01 or depth_kind not in ("z", "range"):
        raise ConfigError(f"got depth_scale {depth_scale} and depth_kind {depth_kind!r}, wanted 1e-6 to 0.01 and 'z' or 'range'")
    if scan.shape is None or scan.pixels is None or scan.intrinsics is None:
        raise ScanError(f"{path}: a depth image needs an organised scan with intrinsics; write .ply or .npz instead")
    _require_on_rays(path, scan.points, scan.pixels, scan.intrinsics)
    depth = scan.points[:, 2] if depth_kind == "z" else np.linalg.norm(scan.points, axis=1)
    counts = np.rint(depth / depth_scale)
    if counts.min() < 1 or counts.max() > _LARGEST_COUNT:
        reach = f"{depth.min():.4g} to {depth.max():.4g} m"
        raise ScanError(f"{path}: depths of {reach} do not fit 16 bits at {depth_scale} m per count; choose another depth_scale")
    image = np.zeros(scan.shape[0] * scan.shape[1], dtype=np.uint16)
    image[scan.pixels] = counts
    buffer = io.BytesIO()
    Pillow.fromarray(image.reshape(scan.shape)).save(buffer, format="PNG")
    sidecar = _sidecar(scan.intrinsics, scan.camera_to_world, depth_scale, depth_kind)
    return {path.with_suffix(".json"): sidecar, path: buffer.getvalue()}


def _require_on_rays(path: Path, points: Points, pixels: Indices, camera: Intrinsics) -> None:
    if np.any(points[:, 2] <= 0):
        raise ScanError(f"{path}: some points lie behind the camera, which a depth image cannot hold; write .npz instead")
    wanted = np.column_stack([pixels % camera.width, pixels // camera.width])
    off = float(np.median(np.linalg.norm(camera.project(points) - wanted, axis=1)))
    if off > 0.5:
        raise ScanError(f"{path}: the points lie {off:.1f} pixels off their rays, which a depth image loses; write .npz instead")


def _sidecar(camera: Intrinsics, pose: Pose | None, depth_scale: float, depth_kind: str) -> bytes:
    content: dict[str, Any] = {"width": int(camera.width), "height": int(camera.height)}
    content |= {name: float(getattr(camera, name)) for name in ("fx", "fy", "cx", "cy")}
    content |= {"distortion": list(map(float, camera.distortion)), "depth_scale": depth_scale, "depth_kind": depth_kind}
    if pose is not None:
        content["camera_to_world"] = pose.tolist()
    return (json.dumps(content, indent=2) + "\n").encode()

"""NPY and NPZ scans: point arrays and depth images. Headers are checked against the file's size before any array is made."""

import io
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy_format
from numpy.typing import NDArray

from viewgain.arrays import Pose
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError, ScanError
from viewgain.geometry import pose, require_rigid
from viewgain.scans._camera_keys import camera_matrix
from viewgain.scans._depth_image import depth_to_points
from viewgain.scans._intrinsics_file import DepthCamera, resolve_camera
from viewgain.scans._raw import LARGEST_FILE, RawScan, one_line, require_magic, require_room

POINT_KEYS = ("points", "cloud", "xyz", "pts", "vertices")
DEPTH_KEYS = ("z", "depth")
RANGE_KEYS = ("range", "ranges", "range_u16")
AMPLITUDE_KEYS = ("amplitude", "intensity", "ir", "infrared")
POSE_KEYS = ("camera_to_world", "cam2root", "pose")
_LARGEST_EXPANSION = 1100
"""Deflate packs at most 1032 bytes into one."""

Arrays = dict[str, NDArray[Any]]


def read_npy(path: Path, data: bytes, camera: Intrinsics | Path | None) -> RawScan:
    """Return the scan of an NPY file: (n, 3) or (h, w, 3) points, or with ``camera`` an (h, w) depth image.

    Raises:
        ScanError: If it is no NPY file, is truncated, holds no plain numbers, or has another shape.
        ConfigError: If the camera file makes no sense or is for another image size.
    """
    array = _load_npy(path, data, str(path))
    is_depth = array.ndim == 2 and (array.shape[1] != 3 or camera is not None)
    return _scan(path, {"depth" if is_depth else "points": array}, camera)


def read_npz(path: Path, data: bytes, camera: Intrinsics | Path | None) -> RawScan:
    """Return the scan of an NPZ file; docs/formats.md lists the keys.

    Raises:
        ScanError: If it is no NPZ file, is truncated, or has none of the known keys.
        ConfigError: If its camera or the camera file makes no sense.
    """
    require_magic(path, data, "NPZ", b"PK\x03\x04", b"PK\x05\x06")
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
            arrays = {name: _load_member(path, archive, info) for name, info in members.items() if name in _KNOWN}
            if len(members) == 1 and not arrays:
                only = next(iter(members.values()))
                return read_npy(path, _member_bytes(path, archive, only), camera)
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError) as error:
        raise ScanError(f"{path}: the NPZ is truncated or damaged ({one_line(error)}); save it again") from error
    if not {*POINT_KEYS, *DEPTH_KEYS, *RANGE_KEYS} & set(arrays):
        wanted = "points, cloud or xyz (points), z or depth (depth image), range (radial)"
        raise ScanError(f"{path}: the NPZ has the keys {', '.join(members)[:80] or 'none'}; wanted one of {wanted}")
    return _scan(path, arrays, camera)


_KNOWN = {
    *(*POINT_KEYS, *DEPTH_KEYS, *RANGE_KEYS, *AMPLITUDE_KEYS, *POSE_KEYS),
    *("K", "f", "R", "eye", "distortion", "normals", "units"),
}


def _member_bytes(path: Path, archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> bytes:
    if info.file_size > min(_LARGEST_EXPANSION * info.compress_size + 1024, LARGEST_FILE):
        sizes = f"{info.file_size} bytes in {info.compress_size} packed ones"
        raise ScanError(f"{path}: the archive claims {sizes} for {info.filename}; it is damaged or no scan; save it again")
    return archive.read(info)


def _load_member(path: Path, archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> NDArray[Any]:
    return _load_npy(path, _member_bytes(path, archive, info), f"{path}: {info.filename}")


def _load_npy(path: Path, data: bytes, name: str) -> NDArray[Any]:
    require_magic(path, data, "NPY", b"\x93NUMPY")
    content = io.BytesIO(data)
    try:
        version = npy_format.read_magic(content)
        read_header = npy_format.read_array_header_1_0 if version == (1, 0) else npy_format.read_array_header_2_0
        shape, _, dtype = read_header(content)
    except (ValueError, EOFError, SyntaxError, TypeError) as error:
        raise ScanError(f"{name}: the NPY header is truncated or damaged ({one_line(error)}); save it again") from error
    if dtype.kind not in ("U" if name.endswith("units.npy") else "fiu"):
        raise ScanError(f"{name}: holds {str(dtype)[:40]}, wanted plain numbers; save it as a float array")
    if any(length < 0 for length in shape):
        raise ScanError(f"{name}: the NPY header claims the impossible shape {shape}; save it again")
    claimed = int(np.prod(np.array(shape, dtype=object), initial=1)) * dtype.itemsize
    require_room(path, claimed, len(data) - content.tell(), f"an array of shape {shape}")
    return np.asarray(np.load(io.BytesIO(data), allow_pickle=False))


def _first(arrays: Arrays, keys: tuple[str, ...]) -> tuple[str, NDArray[Any]] | None:
    return next(((key, arrays[key]) for key in keys if key in arrays), None)


def _scan(path: Path, arrays: Arrays, camera: Intrinsics | Path | None) -> RawScan:
    amplitude = _first(arrays, AMPLITUDE_KEYS)
    common: dict[str, Any] = {
        "amplitude": None if amplitude is None else amplitude[1].astype(float),
        "normals": arrays["normals"].astype(float) if "normals" in arrays else None,
        "camera_to_world": _pose(path, arrays),
    }
    if "units" in arrays and str(arrays["units"]) in ("m", "mm"):
        scale = 1.0 if str(arrays["units"]) == "m" else 0.001
        common |= {"scale": scale, "scale_note": f"{'metres' if scale == 1 else 'millimetres'}, as the file says"}
    found = _first(arrays, POINT_KEYS)
    if found is None:
        return _depth_scan(path, arrays, camera, common)
    points = found[1].astype(float)
    if points.ndim not in (2, 3) or points.shape[-1] != 3:
        raise ScanError(f"{path}: got an array of shape {points.shape}, wanted (n, 3) or (h, w, 3) points")
    if common["normals"] is not None and common["normals"].shape != points.shape:
        raise ScanError(f"{path}: got normals of shape {common['normals'].shape} for points of shape {points.shape}")
    intrinsics = None
    if camera is None and points.ndim == 3:
        own = _camera(path, arrays, (points.shape[1], points.shape[0]))
        intrinsics = own.intrinsics if own else None
    return RawScan(points=points, intrinsics=intrinsics, **common)


def _depth_scan(path: Path, arrays: Arrays, camera: Intrinsics | Path | None, common: dict[str, Any]) -> RawScan:
    key, depth = _first(arrays, DEPTH_KEYS + RANGE_KEYS) or ("", np.zeros(0))
    if depth.ndim != 2:
        raise ScanError(f"{path}: got {key} of shape {depth.shape}, wanted an (h, w) depth image or (n, 3) points")
    size = (depth.shape[1], depth.shape[0])
    own = resolve_camera(camera, size, path) if camera is not None else _camera(path, arrays, size)
    if own is None:
        raise ScanError(f"{path}: a depth image of {size[0]} x {size[1]} pixels needs its camera; give intrinsics=<file.json>")
    if key != "depth":
        own = replace(own, kind="range" if key in RANGE_KEYS else "z")
    if key == "range_u16":
        common |= {"scale": 1e-4, "scale_note": "0.1 mm per count (key range_u16)"}
    elif own.scale is not None and depth.dtype.kind in "iu":
        common |= {"scale": own.scale, "scale_note": own.scale_note}
    if common["camera_to_world"] is None:
        common["camera_to_world"] = own.camera_to_world
    points, notes = depth_to_points(depth.astype(float), own)
    return RawScan(points=points, from_depth=True, intrinsics=own.intrinsics, notes=notes, **common)


def _camera(path: Path, arrays: Arrays, size: tuple[int, int]) -> DepthCamera | None:
    """Return the camera of the keys K (fx, fy, cx, cy or 3x3) or f (fx, fy of a centred lens), None without."""
    width, height = size
    if "K" in arrays:
        fx, fy, cx, cy = camera_matrix(arrays["K"], f"{path}: K")
    elif "f" in arrays and arrays["f"].shape == (2,):
        (fx, fy), cx, cy = map(float, arrays["f"]), (width - 1) / 2, (height - 1) / 2
    else:
        return None
    lens = tuple(float(number) for number in arrays.get("distortion", np.zeros(0)).reshape(-1))
    try:
        intrinsics = Intrinsics(width=width, height=height, fx=fx, fy=fy, cx=cx, cy=cy, distortion=lens)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from error
    return DepthCamera(intrinsics=intrinsics, source=str(path))


def _pose(path: Path, arrays: Arrays) -> Pose | None:
    """Return camera_to_world (metres), or the one of boxbench's R (rows are the camera's axes in the world) and eye."""
    found = _first(arrays, POSE_KEYS)
    if found is not None:
        return require_rigid(found[1], f"{path}: {found[0]}")
    if "R" in arrays and "eye" in arrays and arrays["R"].shape == (3, 3) and arrays["eye"].shape == (3,):
        return require_rigid(pose(arrays["R"].astype(float).T, arrays["eye"].astype(float)), f"{path}: R and eye")
    return None

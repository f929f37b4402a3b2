"""Camera poses from JSON or text files: a 4x4 matrix, alone or under one of the usual keys."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from viewgain.arrays import Array, Pose
from viewgain.errors import ConfigError
from viewgain.geometry import inverse, require_rigid
from viewgain.scans._raw import PathLike, one_line

POSE_KEYS = ("cameratoworld", "camtoworld", "cam2world", "camera2world", "cam2root", "pose", "extrinsic")
"""Accepted keys, in lower case without underscores."""

_LARGEST_SIDECAR = 10_000_000
"""Bytes; a camera or pose file is a few kilobytes."""


def plain_key(name: Any) -> str:
    """Return a key in lower case without underscores, dashes and blanks, so that every spelling of it is one."""
    return str(name).lower().translate(str.maketrans("", "", "_- "))


def load_sidecar(path: Path, what: str) -> str:
    """Return the text of a small file; ``what`` ("intrinsics") names it in messages.

    Raises:
        ConfigError: If it is missing, no regular file, over 10 MB, unreadable or not text.
    """
    try:
        if not path.is_file():
            raise ConfigError(f"{path}: no such {what} file; check the path")
        if path.stat().st_size > _LARGEST_SIDECAR:
            raise ConfigError(f"{path}: over 10 MB is too large for an {what} file; is this the right file?")
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror or one_line(error)}); check its permissions") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: is not a text file, wanted a JSON {what} file") from error


def load_json(path: Path, what: str) -> Any:
    """Return the content of a JSON file.

    Raises:
        ConfigError: As :func:`load_sidecar`, and if it is not JSON.
    """
    try:
        return json.loads(load_sidecar(path, what))
    except (ValueError, RecursionError) as error:
        if isinstance(error, ConfigError):
            raise
        raise ConfigError(f"{path}: is not valid JSON ({one_line(error)}); wanted a JSON {what} file") from error


def read_pose(source: PathLike | Array) -> Pose:
    """Return a (4, 4) camera_to_world (metres) from a matrix, a JSON file or a text file of 16 (or 12) numbers.

    Raises:
        ConfigError: If the file is missing or holds no rigid 4x4 matrix.
    """
    if not isinstance(source, (str, Path)) and not hasattr(source, "__fspath__"):
        try:
            return require_rigid(np.asarray(source, dtype=float), "camera_to_world")
        except (TypeError, ValueError) as error:
            raise ConfigError(f"camera_to_world: {one_line(error).removeprefix('camera_to_world: ')}") from error
    path = Path(source)
    if path.suffix.lower() == ".json":
        content = load_json(path, "pose")
        pose = find_pose(content, path) if isinstance(content, dict) else as_pose(content, str(path))
        if pose is None:
            raise ConfigError(f"{path}: has no pose; wanted a 4x4 matrix under camera_to_world, cam2root, pose or extrinsic")
        return pose
    words = load_sidecar(path, "pose").replace(",", " ").split()
    try:
        return as_pose([float(word) for word in words], str(path))
    except ValueError as error:
        if isinstance(error, ConfigError):
            raise
        raise ConfigError(f"{path}: {one_line(error)}; wanted 16 numbers, the 4x4 camera_to_world, row by row") from error


def find_pose(content: dict[str, Any], path: Path, *, beside_camera: bool = False) -> Pose | None:
    """Return the pose under one of the known keys of a JSON object, None if there is none.

    Open3D's PinholeCameraParameters store the inverse (world to camera) under ``extrinsic``; it is turned round. Beside a
    camera's intrinsics any other ``extrinsic`` is left alone: there it is the way to the colour camera.
    """
    inverted = content.get("class_name") == "PinholeCameraParameters"
    plain = {plain_key(key): (key, value) for key, value in content.items()}
    names = POSE_KEYS[:-1] if beside_camera and not inverted else POSE_KEYS
    key, value = next((plain[name] for name in names if name in plain), (None, None))
    if value is None:
        return None
    pose = as_pose(value, f"{path}: {key}")
    return inverse(pose) if inverted and plain_key(key) == "extrinsic" else pose


def as_pose(value: Any, name: str) -> Pose:
    """Return a rigid (4, 4) matrix from nested rows or a flat list (row by row, or column by column where only that is rigid).

    Raises:
        ConfigError: If it is not 3x4 or 4x4 numbers, or no rigid motion.
    """
    try:
        matrix = np.array(value, dtype=float)
    except (ValueError, TypeError, OverflowError, RecursionError):
        raise ConfigError(f"{name}: is not a matrix of numbers; wanted a 4x4 camera_to_world") from None
    if matrix.size == 12:
        matrix = np.vstack([matrix.reshape(3, 4), [0.0, 0.0, 0.0, 1.0]])
    if matrix.size != 16:
        raise ConfigError(f"{name}: got {matrix.size} numbers, wanted a 4x4 camera_to_world")
    by_columns = matrix.ndim == 1 and not np.allclose(matrix[12:15], 0) and np.allclose(matrix[[3, 7, 11]], 0)
    matrix = matrix.reshape(4, 4)
    return require_rigid(matrix.T if by_columns else matrix, name)

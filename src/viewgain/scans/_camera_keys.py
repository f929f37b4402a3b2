"""The keys that camera files use for the same few numbers: ours, RealSense, Azure Kinect, Orbbec, ROS and Open3D."""

from pathlib import Path
from typing import Any

import numpy as np

from viewgain.errors import ConfigError
from viewgain.scans._pose_file import plain_key

_BLOCKS = (
    *("calibration", "camera", "intrinsic", "intrinsics", "distortion", "resolution"),
    *("depth", "depthcamera", "depthintrinsic", "depthintrinsics", "depthdistortion"),
)
"""Nested objects that are looked into; the depth camera's beat the general ones, and top-level keys beat both."""
_FOCAL = {"fx": ("fx",), "fy": ("fy",), "cx": ("cx", "ppx"), "cy": ("cy", "ppy")}
_MATRICES = ("intrinsicmatrix", "cameramatrix", "k")
_SIZES = {"width": ("width", "imagewidth", "resolutionwidth", "w"), "height": ("height", "imageheight", "resolutionheight", "h")}
_COEFFICIENTS = ("distortion", "coeffs", "distortioncoefficients", "distcoeffs", "d")
_SINGLE_COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
_OTHER_MODELS = ("inverse", "modified", "kannala", "fisheye", "equidistant", "ftheta")


def flatten(content: dict[Any, Any], levels: int = 3) -> dict[str, Any]:
    """Return the plain values of a JSON object and of the known blocks in it, under plain keys."""
    plain = {plain_key(key): value for key, value in content.items()}
    flat: dict[str, Any] = {}
    for name in _BLOCKS:
        block = plain.get(name)
        if isinstance(block, dict) and levels:
            flat |= flatten(block, levels - 1)
    own = {key: value["data"] if isinstance(value, dict) and "data" in value else value for key, value in plain.items()}
    return flat | {key: value for key, value in own.items() if not isinstance(value, dict)}


def number(value: Any, name: str, path: Path) -> float:
    """Return a finite JSON number as float; text and booleans raise ConfigError."""
    try:
        result = float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else np.nan
    except OverflowError:
        result = np.nan
    if not np.isfinite(result):
        raise ConfigError(f"{path}: got {str(value)[:40]!r} for {name}, wanted a finite number")
    return float(result)


def _first(flat: dict[str, Any], names: tuple[str, ...]) -> Any:
    return next((flat[name] for name in names if flat.get(name) is not None), None)


def focal(flat: dict[str, Any], path: Path) -> tuple[float, float, float, float]:
    """Return (fx, fy, cx, cy), pixels."""
    matrix = _first(flat, _MATRICES)
    if matrix is not None and "fx" not in flat:
        return camera_matrix(matrix, str(path))
    found = {name: _first(flat, aliases) for name, aliases in _FOCAL.items()}
    missing = [name for name, value in found.items() if value is None]
    if missing:
        keys = ", ".join(sorted(flat))[:80] or "nothing"
        raise ConfigError(
            f"{path}: lacks {', '.join(missing)}; wanted fx, fy, cx, cy (or ppx, ppy, or intrinsic_matrix), found {keys!r}"
        )
    fx, fy, cx, cy = (number(value, name, path) for name, value in found.items())
    return fx, fy, cx, cy


def camera_matrix(value: Any, name: str) -> tuple[float, float, float, float]:
    """Return (fx, fy, cx, cy) from those four numbers, a 3x3 matrix, or its 9 numbers by rows (ROS) or columns (Open3D)."""
    try:
        matrix = np.array(value, dtype=float)
    except (ValueError, TypeError, OverflowError):
        matrix = np.array([])
    if matrix.shape == (4,):
        return float(matrix[0]), float(matrix[1]), float(matrix[2]), float(matrix[3])
    if matrix.size != 9:
        raise ConfigError(f"{name}: the camera matrix is not 3x3 numbers (or fx, fy, cx, cy)")
    matrix = matrix.reshape(3, 3)
    if np.any(matrix[2, :2]) and not np.any(matrix[:2, 2]):
        matrix = matrix.T
    return float(matrix[0, 0]), float(matrix[1, 1]), float(matrix[0, 2]), float(matrix[1, 2])


def image_size(flat: dict[str, Any], path: Path, size: tuple[int, int] | None) -> tuple[int, int]:
    """Return (width, height), pixels; ``size`` stands in where the file says neither."""
    numbers = [_first(flat, aliases) for aliases in _SIZES.values()]
    if numbers == [None, None] and size is not None:
        return size
    if None in numbers:
        raise ConfigError(f"{path}: lacks width or height; add the size of the image in pixels")
    width, height = (number(value, name, path) for value, name in zip(numbers, _SIZES, strict=True))
    if width != int(width) or height != int(height):
        raise ConfigError(f"{path}: got an image of {width} x {height} pixels, wanted whole numbers")
    return int(width), int(height)


def distortion(flat: dict[str, Any], path: Path) -> tuple[float, ...]:
    """Return the lens coefficients in OpenCV's order, from a list or from k1 ... k6, p1, p2."""
    listed = _first(flat, _COEFFICIENTS)
    if listed is None:
        listed = [flat.get(name, 0.0) for name in _SINGLE_COEFFICIENTS]
    if not isinstance(listed, list):
        raise ConfigError(f"{path}: got distortion {str(listed)[:40]!r}, wanted a list of coefficients k1, k2, p1, p2, k3, ...")
    coefficients = [number(value, "a distortion coefficient", path) for value in listed]
    return lens(coefficients, _first(flat, ("distortionmodel", "model")), path)


def lens(coefficients: list[float], model: Any, path: Path) -> tuple[float, ...]:
    """Return OpenCV's coefficients padded to 4, 5 or 8; empty if all are zero."""
    while coefficients and coefficients[-1] == 0:
        coefficients = coefficients[:-1]
    if coefficients and any(name in plain_key(model) for name in _OTHER_MODELS):
        name = str(model)[:40]
        raise ConfigError(f"{path}: distortion model {name!r} is not supported; rectify the image and give no coefficients")
    if len(coefficients) > 8:
        wanted = "at most 8 (k1, k2, p1, p2, k3, k4, k5, k6)"
        raise ConfigError(f"{path}: got {len(coefficients)} distortion coefficients, wanted {wanted}")
    length = next(length for length in (0, 4, 5, 8) if len(coefficients) <= length)
    return (*coefficients, *[0.0] * (length - len(coefficients)))

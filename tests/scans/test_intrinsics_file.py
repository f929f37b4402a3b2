"""Camera files: every vendor's names for the same numbers give the same camera."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.scans import files
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError
from viewgain.scans import read_intrinsics, read_scan
from viewgain.scans._intrinsics_file import read_depth_camera

PLAIN = Intrinsics(width=640, height=480, fx=500.5, fy=501.5, cx=319.25, cy=239.75)
SIZE: dict[str, Any] = {"width": 640, "height": 480}
OURS: dict[str, Any] = SIZE | {"fx": 500.5, "fy": 501.5, "cx": 319.25, "cy": 239.75}
REALSENSE = SIZE | {
    "fx": 500.5,
    "fy": 501.5,
    "ppx": 319.25,
    "ppy": 239.75,
    "model": "distortion.brown_conrady",
    "coeffs": [0.0] * 5,
}
ROWS = [[500.5, 0, 319.25], [0, 501.5, 239.75], [0, 0, 1]]
BY_ROWS = [number for row in ROWS for number in row]
BY_COLUMNS = [number for row in np.transpose(ROWS).tolist() for number in row]

SAME_CAMERA: dict[str, Any] = {
    "ours": OURS,
    "upper case": {key.upper(): value for key, value in OURS.items()},
    "realsense": REALSENSE,
    "realsense inverse model without coefficients": REALSENSE | {"model": "Inverse Brown Conrady"},
    "azure kinect": OURS | dict.fromkeys(("k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "codx", "cody"), 0.0),
    "orbbec": {"depthIntrinsic": OURS, "depthDistortion": {"k1": 0, "k2": 0}, "rgbIntrinsic": OURS | {"fx": 900.0}},
    "orbbec python": {"depth_intrinsic": OURS, "rgb_intrinsic": OURS | {"fx": 900.0}},
    "open3d by columns": SIZE | {"intrinsic_matrix": BY_COLUMNS},
    "matrix by rows": SIZE | {"intrinsic_matrix": BY_ROWS},
    "nested rows": SIZE | {"K": ROWS},
    "open3d parameters": {"class_name": "PinholeCameraParameters", "intrinsic": SIZE | {"intrinsic_matrix": BY_COLUMNS}},
    "ros": SIZE | {"distortion_model": "plumb_bob", "D": [0, 0, 0, 0, 0], "K": BY_ROWS},
    "opencv": {"image_width": 640, "image_height": 480, "camera_matrix": {"rows": 3, "cols": 3, "data": BY_ROWS}},
    "nested": {"camera": {"intrinsics": OURS}},
    "depth before colour": {"intrinsics": OURS | {"fx": 900.0}, "depth": OURS},
    "top before nested": OURS | {"depth": {"fx": 900.0}},
    "resolution": {"resolution": SIZE, "intrinsics": OURS},
    "whole floats": OURS | {"width": 640.0},
}


def read(folder: Path, content: dict[str, Any]) -> Intrinsics:
    return read_intrinsics(files.put(folder, "camera.json", json.dumps(content)))


@pytest.mark.parametrize("vendor", SAME_CAMERA)
def test_every_vendor_means_the_same_camera(tmp_path: Path, vendor: str) -> None:
    assert read(tmp_path, SAME_CAMERA[vendor]) == PLAIN


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ({"distortion": []}, ()),
        ({"distortion": [0.1]}, (0.1, 0, 0, 0)),
        ({"distortion": [0.1, 0.2, 0.3, 0.4]}, (0.1, 0.2, 0.3, 0.4)),
        ({"coeffs": [0.1, 0.2, 0.3, 0.4, 0.5]}, (0.1, 0.2, 0.3, 0.4, 0.5)),
        ({"D": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]}, (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0, 0)),
        ({"D": [0.1] * 8 + [0] * 6}, (0.1,) * 8),
        ({"k1": 1, "k2": 2, "k3": 3, "k4": 4, "k5": 5, "k6": 6, "p1": 0.1, "p2": 0.2}, (1, 2, 0.1, 0.2, 3, 4, 5, 6)),
        ({"k1": 0.1, "k2": -0.2}, (0.1, -0.2, 0, 0)),
        ({"distortion": {"model": "brown_conrady", "coeffs": [0.1, 0.2, 0.3, 0.4]}}, (0.1, 0.2, 0.3, 0.4)),
        ({"distortion_coefficients": {"rows": 1, "cols": 4, "data": [0.1, 0.2, 0.3, 0.4]}}, (0.1, 0.2, 0.3, 0.4)),
        ({"distortion": [0.1] * 4, "model": "K4A_CALIBRATION_LENS_DISTORTION_MODEL_BROWN_CONRADY"}, (0.1,) * 4),
    ],
)
def test_lens_coefficients(tmp_path: Path, content: dict[str, Any], expected: tuple[float, ...]) -> None:
    assert read(tmp_path, OURS | content).distortion == expected


@pytest.mark.parametrize("model", ["distortion.inverse_brown_conrady", "Modified Brown Conrady", "fisheye", "Ftheta"])
def test_other_lens_models_are_refused(tmp_path: Path, model: str) -> None:
    with pytest.raises(ConfigError, match=r"camera\.json: distortion model '.*' is not supported; rectify"):
        read(tmp_path, REALSENSE | {"model": model, "coeffs": [0.1, 0, 0, 0, 0]})


def test_the_size_may_come_from_the_image(tmp_path: Path) -> None:
    content = {key: value for key, value in OURS.items() if key not in SIZE}
    path = files.put(tmp_path, "camera.json", json.dumps(content))
    with pytest.raises(ConfigError, match="lacks width or height"):
        read_intrinsics(path)
    assert read_intrinsics(path, size=(640, 480)) == PLAIN
    scan = read_scan(files.put(tmp_path, "scan.png", files.png(files.counts())), intrinsics=path)
    assert scan.intrinsics is not None
    assert (scan.intrinsics.width, scan.intrinsics.height) == (16, 12)


def test_kind_scale_and_pose_come_along(tmp_path: Path) -> None:
    content = OURS | {"depth_kind": "range", "depthScale": 0.0002, "camera_to_world": files.POSE.tolist()}
    camera = read_depth_camera(files.put(tmp_path, "camera.json", json.dumps(content)))
    assert (camera.kind, camera.scale) == ("range", 0.0002)
    np.testing.assert_allclose(camera.camera_to_world, files.POSE, atol=1e-12)


def test_an_extrinsic_beside_intrinsics_is_open3d_s_or_none_of_ours(tmp_path: Path) -> None:
    """Open3D stores world to camera; elsewhere it is the way to the colour camera."""
    extrinsic = np.linalg.inv(files.POSE).T.reshape(-1).tolist()
    content = {"class_name": "PinholeCameraParameters", "extrinsic": extrinsic, "intrinsic": OURS}
    camera = read_depth_camera(files.put(tmp_path, "camera.json", json.dumps(content)))
    np.testing.assert_allclose(camera.camera_to_world, files.POSE, atol=1e-12)
    content = OURS | {"extrinsic": {"rotation": [1, 0, 0], "translation": [1, 2, 3]}}
    assert read_depth_camera(files.put(tmp_path, "camera.json", json.dumps(content))).camera_to_world is None

"""Poses from files: formats, keys, and which one wins."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.scans import files
from viewgain.scans import read_pose, read_scan

ROWS = files.POSE.tolist()
FLAT = files.POSE.reshape(-1).tolist()

FILES: dict[str, tuple[str, str]] = {
    "rows": ("pose.json", json.dumps(ROWS)),
    "flat by rows": ("pose.json", json.dumps(FLAT)),
    "flat by columns": ("pose.json", json.dumps(files.POSE.T.reshape(-1).tolist())),
    "three rows": ("pose.json", json.dumps(ROWS[:3])),
    **{
        key: ("pose.json", json.dumps({"note": 1, key: ROWS}))
        for key in ("camera_to_world", "cam2root", "pose", "extrinsic", "CameraToWorld")
    },
    "open3d": (
        "pose.json",
        json.dumps({"class_name": "PinholeCameraParameters", "extrinsic": np.linalg.inv(files.POSE).T.reshape(-1).tolist()}),
    ),
    "text": ("pose.txt", "\n".join(" ".join(map(repr, row)) for row in ROWS)),
    "text of three rows": ("pose.txt", "\n".join("\t".join(map(repr, row)) for row in ROWS[:3])),
    "commas": ("pose.csv", ",".join(map(repr, FLAT))),
}


@pytest.mark.parametrize("case", FILES)
def test_every_way_to_write_a_pose(tmp_path: Path, case: str) -> None:
    path = files.put(tmp_path, *FILES[case])
    for source in (path, str(path)):
        np.testing.assert_allclose(read_pose(source), files.POSE, rtol=0, atol=1e-12)
    scan = read_scan(files.put(tmp_path, "scan.npy", files.npy(files.cloud())), camera_to_world=path)
    np.testing.assert_allclose(scan.camera_to_world, files.POSE, rtol=0, atol=1e-12)


def test_an_array_is_a_pose() -> None:
    np.testing.assert_allclose(read_pose(files.POSE), files.POSE, rtol=0, atol=1e-12)


def test_a_given_pose_beats_the_file_s_own(tmp_path: Path) -> None:
    path = files.put(tmp_path, "scan.npz", files.npz(points=files.cloud(), camera_to_world=np.eye(4)))
    np.testing.assert_array_equal(read_scan(path).camera_to_world, np.eye(4))
    np.testing.assert_allclose(read_scan(path, camera_to_world=files.POSE).camera_to_world, files.POSE, atol=1e-12)

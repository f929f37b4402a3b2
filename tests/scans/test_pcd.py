"""PCD: organised clouds, the viewpoint, extra fields, sloppy headers."""

import io
from pathlib import Path

import numpy as np
import pytest
from pypcd4 import Encoding, PointCloud

from tests.scans import files
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.scans import read_scan

POINTS = files.cloud(15 * 10)
ENCODINGS = ["ascii", "binary", "binary_compressed"]


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_organised_clouds_keep_their_image(tmp_path: Path, encoding: str) -> None:
    points = POINTS.copy()
    points[[4, 17]] = np.nan
    points[20] = 0
    scan = read_scan(files.put(tmp_path, "scan.pcd", files.pcd(points, encoding, shape=(10, 15))))
    assert scan.shape == (10, 15)
    np.testing.assert_array_equal(scan.pixels, np.delete(np.arange(150), [4, 17, 20]))
    assert (scan.dropped.not_a_number, scan.dropped.zero) == (2, 1)
    np.testing.assert_allclose(scan.organised()[1, 6], POINTS[21], rtol=0, atol=1e-9)


def test_an_organised_cloud_takes_a_camera_of_its_size(tmp_path: Path) -> None:
    path = files.put(tmp_path, "scan.pcd", files.pcd(files.cloud(192), shape=(12, 16)))
    assert read_scan(path, intrinsics=files.CAMERA).intrinsics == files.CAMERA
    camera = files.put(tmp_path, "camera.json", files.camera_json(pose=files.POSE.tolist()))
    scan = read_scan(path, intrinsics=camera)
    np.testing.assert_allclose(scan.camera_to_world, files.POSE, atol=1e-12)
    with pytest.raises(ValueError, match=r"16 x 12 pixels but .* has 15 x 10"):
        read_scan(files.put(tmp_path, "other.pcd", files.pcd(POINTS, shape=(10, 15))), intrinsics=files.CAMERA)


@pytest.mark.parametrize("units", ["m", "mm"])
def test_the_viewpoint_is_the_pose_of_the_camera(tmp_path: Path, units: str) -> None:
    """The points stay in the camera's frame; the translation has the units of the points; w comes first."""
    factor = {"m": 1.0, "mm": 1000.0}[units]
    quaternion = (np.cos(0.2), 0.0, 0.0, np.sin(0.2))
    viewpoint = (0.5 * factor, -0.25 * factor, 1.25 * factor, *quaternion)
    scan = read_scan(files.put(tmp_path, "scan.pcd", files.pcd(POINTS * factor, viewpoint=viewpoint)))
    expected = pose(rotation_from_rotvec(np.array([0, 0, 0.4])), np.array([0.5, -0.25, 1.25]))
    np.testing.assert_allclose(scan.camera_to_world, expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(scan.points, POINTS, rtol=1e-15, atol=1e-15)


def test_the_identity_viewpoint_says_nothing(tmp_path: Path) -> None:
    assert read_scan(files.put(tmp_path, "scan.pcd", files.pcd(POINTS))).camera_to_world is None


def test_a_given_pose_beats_the_viewpoint(tmp_path: Path) -> None:
    path = files.put(tmp_path, "scan.pcd", files.pcd(POINTS, viewpoint=(1, 2, 3, 1, 0, 0, 0)))
    np.testing.assert_allclose(read_scan(path, camera_to_world=files.POSE).camera_to_world, files.POSE, atol=1e-12)


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_normals_and_intensity(tmp_path: Path, encoding: str) -> None:
    normals, intensity = files.unit_vectors(150), np.arange(150.0)
    names = ("intensity", "x", "y", "z", "normal_x", "normal_y", "normal_z")
    content = PointCloud.from_points(np.column_stack([intensity, POINTS, normals]), names, (np.float64,) * 7)
    content.metadata = content.metadata.model_copy(update={"height": 10, "width": 15})
    buffer = io.BytesIO()
    content.save(buffer, Encoding(encoding))
    scan = read_scan(files.put(tmp_path, "scan.pcd", buffer.getvalue()), min_amplitude=50)
    assert scan.dropped.weak == 50
    assert scan.amplitude is not None
    assert scan.amplitude[3, 5] == 50
    np.testing.assert_allclose(scan.points, POINTS[50:], rtol=0, atol=1e-9)
    np.testing.assert_allclose(scan.normals, normals[50:], rtol=0, atol=1e-9)


def test_a_sloppy_ascii_file_is_understood(tmp_path: Path) -> None:
    """No COUNT, HEIGHT, VIEWPOINT or POINTS, an unnamed field, blanks, tabs and empty lines: all of it is seen in the wild."""
    header = "# .PCD v.5\r\nFIELDS x y z _\r\nSIZE 4 4 4 4\r\nTYPE F F F U\r\nWIDTH 150\r\nDATA ascii\r\n"
    rows = "".join(f" {x!r}\t{y!r}  {z!r} 7 \r\n\r\n" for x, y, z in POINTS.astype(np.float32).tolist())
    scan = read_scan(files.put(tmp_path, "scan.pcd", header + rows))
    np.testing.assert_array_equal(scan.points, POINTS.astype(np.float32))

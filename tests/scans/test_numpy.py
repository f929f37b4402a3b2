"""NPY and NPZ: shapes, keys, depth images, poses, amplitude."""

from pathlib import Path

import numpy as np
import pytest

from tests.scans import files
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError, ScanError
from viewgain.geometry import transform
from viewgain.scans import Scan, read_scan

POINTS = files.cloud(192)
IMAGE = POINTS.reshape(12, 16, 3)
K = np.array([20.0, 21.0, 7.25, 5.75])
MATRIX = np.array([[20.0, 0, 7.25], [0, 21.0, 5.75], [0, 0, 1]])
DEPTH = files.counts() / 1000.0


def read(folder: Path, content: bytes, name: str = "scan.npz", **options: object) -> Scan:
    return read_scan(files.put(folder, name, content), **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("key", ["points", "cloud", "xyz", "pts", "vertices", "arr_0"])
@pytest.mark.parametrize("kind", [np.float32, np.float64, np.float16])
def test_point_keys(tmp_path: Path, key: str, kind: type) -> None:
    flat = read(tmp_path, files.npz(**{key: POINTS.astype(kind)}))
    organised = read(tmp_path, files.npz(**{key: IMAGE.astype(kind)}))
    for scan in (flat, organised):
        np.testing.assert_array_equal(scan.points, POINTS.astype(kind))
        assert scan.points.dtype == np.float64
    assert flat.shape is None
    assert organised.shape == (12, 16)


def test_other_keys_do_no_harm(tmp_path: Path) -> None:
    """Not even those that would need pickle, which is never used."""
    np.savez(tmp_path / "scan.npz", points=POINTS, label=np.arange(192), meta=np.array({"a": 1}, dtype=object))
    np.testing.assert_array_equal(read_scan(tmp_path / "scan.npz").points, POINTS)


@pytest.mark.parametrize("order", ["C", "F"])
def test_memory_order(tmp_path: Path, order: str) -> None:
    scan = read(tmp_path, files.npy(np.array(IMAGE, order=order)), "scan.npy")  # type: ignore[call-overload]
    np.testing.assert_array_equal(scan.points, POINTS)


@pytest.mark.parametrize("camera", [{"K": K}, {"K": MATRIX}])
def test_depth_with_its_camera(tmp_path: Path, camera: dict[str, np.ndarray]) -> None:
    for key in ("z", "depth"):
        scan = read(tmp_path, files.npz(**{key: DEPTH}, **camera))
        assert scan.intrinsics == files.CAMERA
        assert scan.dropped.zero == 1
        np.testing.assert_allclose(files.CAMERA.project(scan.points), pixels(scan), atol=1e-9)
        np.testing.assert_allclose(scan.points[:, 2], DEPTH.reshape(-1)[1:], rtol=1e-15)


def test_ranges_run_along_the_rays(tmp_path: Path) -> None:
    scan = read(tmp_path, files.npz(range=DEPTH, K=K))
    np.testing.assert_allclose(np.linalg.norm(scan.points, axis=1), DEPTH.reshape(-1)[1:], rtol=1e-14)
    np.testing.assert_allclose(files.CAMERA.project(scan.points), pixels(scan), atol=1e-9)
    np.testing.assert_allclose(scan.points, Scan.from_range(DEPTH, files.CAMERA).points, rtol=1e-14)


def test_boxbench_keys(tmp_path: Path) -> None:
    """World = camera @ R + eye; a centred camera of focal lengths f; 0.1 mm per count."""
    rotation, eye = files.POSE[:3, :3], np.array([1.0, 2.0, 3.0])
    scan = read(tmp_path, files.npz(range_u16=files.counts() * 10, f=np.array([20.0, 21.0]), R=rotation, eye=eye))
    assert scan.intrinsics == Intrinsics(width=16, height=12, fx=20.0, fy=21.0, cx=7.5, cy=5.5)
    np.testing.assert_allclose(np.linalg.norm(scan.points, axis=1), DEPTH.reshape(-1)[1:], rtol=1e-14)
    assert scan.camera_to_world is not None
    np.testing.assert_allclose(transform(scan.camera_to_world, scan.points), scan.points @ rotation + eye, atol=1e-12)
    assert "units: 0.1 mm per count (key range_u16)" in scan.notes


def test_distortion_and_pose_keys(tmp_path: Path) -> None:
    lens = (-0.1, 0.02, 0.001, -0.001)
    scan = read(tmp_path, files.npz(z=DEPTH, K=K, distortion=np.array(lens), camera_to_world=files.POSE))
    assert scan.intrinsics is not None
    assert scan.intrinsics.distortion == lens
    np.testing.assert_allclose(scan.camera_to_world, files.POSE, atol=1e-12)
    np.testing.assert_allclose(scan.intrinsics.project(scan.points), pixels(scan), atol=1e-6)


def test_a_given_camera_makes_a_plain_array_a_depth_image(tmp_path: Path) -> None:
    camera = files.put(tmp_path, "camera.json", files.camera_json(depth_scale=0.0005, depth_kind="range"))
    scan = read(tmp_path, files.npy(files.counts()), "scan.npy", intrinsics=camera)
    np.testing.assert_allclose(np.linalg.norm(scan.points, axis=1), DEPTH.reshape(-1)[1:] / 2, rtol=1e-14)
    with pytest.raises(ConfigError, match=r"16 x 12 pixels but .*scan\.npy has 12 x 16"):
        read(tmp_path, files.npy(files.counts().T), "scan.npy", intrinsics=camera)


def test_a_narrow_depth_image_is_not_taken_for_points(tmp_path: Path) -> None:
    camera = Intrinsics(width=3, height=60, fx=50.0, fy=50.0, cx=1.0, cy=29.5)
    scan = read(tmp_path, files.npy(np.ones((60, 3))), "scan.npy", intrinsics=camera)
    assert scan.shape == (60, 3)


def test_amplitude_and_normals(tmp_path: Path) -> None:
    normals, amplitude = files.unit_vectors(192).reshape(12, 16, 3), np.arange(192).reshape(12, 16)
    content = files.npz(cloud=IMAGE, amplitude=amplitude.astype(np.uint16), normals=normals)
    scan = read(tmp_path, content)
    np.testing.assert_array_equal(scan.amplitude, amplitude)
    np.testing.assert_allclose(scan.normals, normals.reshape(-1, 3), rtol=0, atol=1e-15)
    strong = read(tmp_path, content, min_amplitude=10)
    np.testing.assert_array_equal(strong.points, POINTS[10:])
    assert strong.dropped.weak == 10
    assert strong.dropped.total == 10


def test_bad_cameras_and_amplitudes_in_the_file(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"scan\.npz: K: the camera matrix is not 3x3"):
        read(tmp_path, files.npz(z=DEPTH, K=np.ones(5)))
    with pytest.raises(ConfigError, match=r"scan\.npz: .*positive focal lengths"):
        read(tmp_path, files.npz(z=DEPTH, K=-K))
    with pytest.raises(ConfigError, match=r"scan\.npz: camera_to_world: .*rigid"):
        read(tmp_path, files.npz(points=POINTS, camera_to_world=2 * np.eye(4)))
    with pytest.raises(ScanError, match="got an amplitude image of shape"):
        read(tmp_path, files.npz(points=IMAGE, amplitude=np.ones((3, 3))))
    with pytest.raises(ScanError, match=r"got z of shape \(3,\)"):
        read(tmp_path, files.npz(z=np.ones(3), K=K))


def pixels(scan: Scan) -> np.ndarray:
    assert scan.pixels is not None
    return np.column_stack([scan.pixels % 16, scan.pixels // 16])

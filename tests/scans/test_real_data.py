"""Every scan of ../shared reads, with the number of points, the image and the notes that it should have."""

from pathlib import Path

import numpy as np
import pytest

from viewgain.geometry import transform
from viewgain.scans import Scan, read_scan, write_scan

TURNED = "turned by (x, -y, -z)"
ODD = "does not look like a single camera-frame scan"


@pytest.fixture(scope="module")
def boxes(data_dir: Path) -> Path:
    return data_dir / "real_boxes"


@pytest.mark.parametrize(
    ("name", "count", "distance", "blank_normals"),
    [
        ("trai_tof/vedere1_2boxes.ply", 37108, 1.938, 4),
        ("trai_tof/vedere1_large_box.ply", 29002, 2.095, 5),
        ("trai_tof/vedere1_large_box_down.ply", 32613, 1.933, 1),
        ("trai_tof/vedere1_small_box.ply", 16606, 1.171, 0),
        ("orthogonal_planes/test_single.ply", 7884, 3.437, 0),
    ],
)
def test_ply_clouds_in_the_camera_frame(boxes: Path, name: str, count: int, distance: float, blank_normals: int) -> None:
    scan = read_scan(boxes / name)
    assert scan.notes == (f"units: read as metres (median distance {distance})",)
    check_cloud(scan, count)
    assert scan.normals is not None
    lengths = np.linalg.norm(scan.normals, axis=1)
    assert np.isnan(lengths).sum() == blank_normals
    np.testing.assert_allclose(lengths[~np.isnan(lengths)], 1, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "count", "distance"),
    [
        ("vedere1.pcd", 6853, 1.66),
        ("vedere2.pcd", 11017, 1.77),
        ("Vedere_1_final.pcd", 1159, 1.292),
        ("Vedere_2_final.pcd", 926, 1.21),
    ],
)
def test_ascii_pcd_clouds(boxes: Path, name: str, count: int, distance: float) -> None:
    scan = read_scan(boxes / "trai_tof" / name)
    assert scan.notes == (f"units: read as metres (median distance {distance})",)
    check_cloud(scan, count)
    assert scan.normals is None


def test_blensor_looks_along_minus_z(boxes: Path) -> None:
    scan = read_scan(boxes / "trai_blensor" / "1.pcd")
    check_cloud(scan, 46821)
    assert scan.points[:, 2].min() > 0.8
    assert len(scan.notes) == 2
    assert TURNED in scan.notes[1]


def test_sick_is_organised_and_in_millimetres(boxes: Path) -> None:
    scan = read_scan(boxes / "sick_visionary_t" / "static_scene.pcd")
    assert scan.notes == (
        "units: read as millimetres (median distance 994.8)",
        "axes: x points left and y up in the image; turned by (-x, -y, z)",
    )
    assert scan.shape == (144, 176)
    assert len(scan.points) == 144 * 176
    assert scan.camera_to_world is None
    assert 0.5 < scan.points[:, 2].min() < scan.points[:, 2].max() < 1.4
    # Organised means that neighbours in the image are neighbours in the world; x runs to the right and y down.
    directions = scan.organised() / np.linalg.norm(scan.organised(), axis=-1, keepdims=True)
    np.testing.assert_allclose(np.diff(directions[..., 0], axis=1), 0.0065, atol=0.004)
    np.testing.assert_allclose(np.diff(directions[..., 1], axis=0), 0.0065, atol=0.004)


@pytest.mark.parametrize(("name", "count", "zeros"), [("example1", 202007, 15081), ("example2", 199462, 17626)])
def test_kinect2_npz(boxes: Path, name: str, count: int, zeros: int) -> None:
    scan = read_scan(boxes / "fau_kinect2" / f"{name}.npz")
    assert scan.shape == (424, 512)
    assert (len(scan.points), scan.dropped.zero, scan.dropped.total) == (count, zeros, zeros)
    assert scan.amplitude is not None
    assert scan.amplitude.shape == (424, 512)
    assert len(scan.notes) == 1
    assert scan.intrinsics is None
    strong = read_scan(boxes / "fau_kinect2" / f"{name}.npz", min_amplitude=float(np.median(scan.amplitude)))
    assert 0 < strong.dropped.weak < count
    assert len(strong.points) == count - strong.dropped.weak


def test_every_npz_reads(boxes: Path) -> None:
    paths = sorted(boxes.rglob("*.npz"))
    assert len(paths) >= 40
    for path in paths:
        scan = read_scan(path)
        assert scan.shape in [(424, 512), (480, 640)], path
        assert 175_000 < len(scan.points) < 215_000, path
        assert len(scan.notes) == 1, path
        assert scan.notes[0].startswith("units: read as metres"), path


def test_mosd_points_lie_on_the_rays_of_their_camera(boxes: Path) -> None:
    path = boxes / "mosd_boxes" / "learn0.npz"
    scan = read_scan(path)
    assert scan.intrinsics is not None
    assert scan.pixels is not None
    assert (scan.intrinsics.width, scan.intrinsics.height) == (640, 480)
    assert (len(scan.points), scan.dropped.zero) == (182292, 124908)
    pixels = np.column_stack([scan.pixels % 640, scan.pixels // 640])
    np.testing.assert_allclose(scan.intrinsics.project(scan.points), pixels, atol=1e-9)
    np.testing.assert_array_equal(scan.points[:, 2].astype(np.float32), np.load(path)["z"].reshape(-1)[scan.pixels])


@pytest.mark.parametrize(("box", "count"), [("small_box", 279535), ("medium_box", 279530)])
def test_palletizer_depth_png_with_its_files(boxes: Path, tmp_path: Path, box: str, count: int) -> None:
    folder = boxes / "smart_palletizer" / box
    scan = read_scan(folder / "raw_depth.png", camera_to_world=folder / "cam2root.json")
    assert scan.shape == (480, 640)
    assert (len(scan.points), scan.dropped.zero) == (count, 640 * 480 - count)
    assert f"camera: taken from {folder / 'intrinsics.json'} beside the image" in scan.notes
    assert "units: read as one millimetre per count (no depth_scale given)" in scan.notes
    assert scan.intrinsics is not None
    assert scan.intrinsics.fx == 607.59228515625
    # The pose is right if the camera, 1.1 m up, sees the floor of the cell below zero and nothing above itself.
    assert scan.camera_to_world is not None
    heights = transform(scan.camera_to_world, scan.points)[:, 2]
    assert -1.0 < np.median(heights) < 0
    assert np.percentile(heights, 99) < 1.1
    write_scan(scan, tmp_path / "again.png")
    np.testing.assert_allclose(read_scan(tmp_path / "again.png").points, scan.points, rtol=0, atol=1e-12)


def test_palletizer_clouds_are_in_the_robot_s_frame_and_say_so(boxes: Path) -> None:
    paths = sorted((boxes / "smart_palletizer").rglob("*_raw.ply"))
    assert len(paths) == 13
    for path in paths:
        scan = read_scan(path)
        assert scan.normals is not None, path
        assert any(TURNED in note for note in scan.notes), path
        assert any(ODD in note and "off the camera's line of sight" in note for note in scan.notes), path


def test_palletizer_meshes_say_that_they_are_none(boxes: Path) -> None:
    for path in sorted((boxes / "smart_palletizer").rglob("*_mesh.ply")):
        scan = read_scan(path)
        assert scan.notes[0].startswith("units: read as millimetres"), path
        assert scan.notes[1].startswith("the file is a mesh"), path
        assert ODD in scan.notes[2], path


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("smart_palletizer/small_box/color_image.png", "is a colour image, wanted a 16-bit grey depth image"),
        ("trai_blensor/0_target_value_permuted.npy", "needs its camera"),
        ("trai_blensor/0_viewstate_permuted.npy", r"got an array of shape \(4,\)"),
        ("trai_blensor/model.mat", r"unknown type of file '\.mat'"),
        ("trai_table1/Score_test_PCL.csv", "a line is no row of numbers"),
        ("smart_palletizer/ground_truth.json", r"unknown type of file '\.json'"),
    ],
)
def test_what_is_no_scan_is_refused(boxes: Path, name: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read_scan(boxes / name)


def test_boxbench(boxbench_dir: Path) -> None:
    """The box stands where its file says: floor at z = 0, the top at its height."""
    paths = sorted(boxbench_dir.glob("*.npz"))
    assert len(paths) == 128
    for path in paths[::16]:
        scan = read_scan(path)
        assert scan.notes == ("units: 0.1 mm per count (key range_u16)",)
        assert scan.camera_to_world is not None
        assert scan.intrinsics is not None
        stored = np.load(path)
        world = transform(scan.camera_to_world, scan.points)
        np.testing.assert_allclose(world, scan.points @ stored["R"] + stored["eye"], atol=1e-6)  # R is stored rounded
        width, length, height = stored["dims"]
        on_top = (np.abs(world[:, :2]) < 0.4 * np.array([width, length])).all(axis=1) & (world[:, 2] > height / 2)
        assert on_top.sum() > 50
        assert abs(np.median(world[on_top, 2]) - height) < 0.01
        outside = (np.abs(world[:, :2]) > 0.7 * np.array([width, length])).any(axis=1)
        assert abs(np.median(world[outside, 2])) < 0.01


def check_cloud(scan: Scan, count: int) -> None:
    assert len(scan.points) == count
    assert scan.shape is None
    assert scan.dropped.total == 0
    assert scan.camera_to_world is None
    assert np.all(scan.points[:, 2] > 0)

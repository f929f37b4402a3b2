"""Metres or millimetres, and which way the camera looks: what is decided, what is said, what can be ordered."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.scans import files
from viewgain.geometry import rotation_from_rotvec, transform
from viewgain.scans import read_scan
from viewgain.scans._frame import face_forward
from viewgain.scans._units import metres_per_unit

POINTS = files.cloud()
TURN = np.array([1.0, -1.0, -1.0])
TURNED = "turned by (x, -y, -z)"
ODD = "does not look like a single camera-frame scan"


@pytest.mark.parametrize("name", sorted(files.every_format(POINTS)))
def test_the_same_cloud_in_millimetres_is_the_same_scan(tmp_path: Path, name: str) -> None:
    metres = read_scan(files.put(tmp_path, name, files.every_format(POINTS)[name]))
    millimetres = read_scan(files.put(tmp_path, f"mm_{name}", files.every_format(POINTS * 1000)[name]))
    # pypcd4 writes ascii with ten digits; for the others the factor costs the last bit.
    np.testing.assert_allclose(millimetres.points, metres.points, rtol=0, atol=1e-9 if name == "ascii.pcd" else 1e-15)
    median = np.median(np.linalg.norm(POINTS, axis=1))
    assert f"units: read as metres (median distance {median:.4g})" in metres.notes
    assert f"units: read as millimetres (median distance {1000 * median:.4g})" in millimetres.notes


@pytest.mark.parametrize(("units", "factor"), [("m", 1.0), ("mm", 0.001)])
@pytest.mark.parametrize("true_scale", [1.0, 1000.0])
def test_units_can_be_ordered(tmp_path: Path, units: str, factor: float, true_scale: float) -> None:
    scan = read_scan(files.put(tmp_path, "scan.npy", files.npy(POINTS * true_scale)), units=units)
    np.testing.assert_allclose(scan.points, POINTS * true_scale * factor, rtol=1e-15)
    assert scan.notes[0].endswith("as ordered")


@given(distance=st.floats(0.01, 1e4))
def test_the_rule_is_the_median_distance(distance: float) -> None:
    """Invalid returns have no say, however many there are."""
    points = np.vstack([[[0, 0, distance]], np.zeros((5, 3)), np.full((5, 3), np.nan), np.full((5, 3), np.inf)])
    factor, note = metres_per_unit(points, None, None, "")
    assert factor == (0.001 if distance > 20 else 1.0)
    assert f"(median distance {distance:.4g})" in note


@pytest.mark.parametrize("name", ["scan.ply", "scan.pcd", "scan.npy", "scan.csv"])
def test_clouds_along_minus_z_are_turned(tmp_path: Path, name: str) -> None:
    content = {"ply": files.ply(files.xyz(POINTS * TURN)), "pcd": files.pcd(POINTS * TURN), "npy": files.npy(POINTS * TURN)}
    content["csv"] = files.text(POINTS * TURN, ",")
    scan = read_scan(files.put(tmp_path, name, content[name[-3:]]))
    np.testing.assert_array_equal(scan.points, POINTS)
    assert any(TURNED in note for note in scan.notes)
    assert not any(ODD in note for note in scan.notes)


def test_normals_and_pose_turn_with_the_cloud(tmp_path: Path) -> None:
    """The pose still takes each point to the same place in the world."""
    normals = files.unit_vectors()
    columns = files.xyz(POINTS * TURN) | {f"n{name}": normals[:, axis] for axis, name in enumerate("xyz")}
    path = files.put(tmp_path, "scan.ply", files.ply(columns))
    scan = read_scan(path, camera_to_world=files.POSE)
    assert scan.normals is not None
    assert scan.camera_to_world is not None
    np.testing.assert_allclose(scan.normals, normals * TURN, rtol=0, atol=1e-15)
    np.testing.assert_allclose(
        transform(scan.camera_to_world, scan.points), transform(files.POSE, POINTS * TURN), rtol=0, atol=1e-12
    )


def test_a_few_points_behind_do_not_matter_and_half_of_them_are_said() -> None:
    few, half = POINTS * TURN, POINTS.copy()
    few[:5] *= -1
    half[:75] *= -1
    (turned, _, _), notes = face_forward(few, None, None)
    np.testing.assert_array_equal(turned, few * TURN)
    assert len(notes) == 1
    (same, _, _), notes = face_forward(half, None, None)
    np.testing.assert_array_equal(same, half)
    assert notes == (f"axes: the cloud {ODD}: 50% of the points lie behind the camera (z < 0)",)


def test_a_cloud_off_the_line_of_sight_is_said() -> None:
    tilted = POINTS @ rotation_from_rotvec(np.array([np.radians(60), 0, 0])).T
    (same, _, _), notes = face_forward(tilted, None, None)
    np.testing.assert_array_equal(same, tilted)
    assert len(notes) == 1
    assert ODD in notes[0]
    assert "degrees off the camera's line of sight" in notes[0]


IMAGE = np.dstack([files.CAMERA.rays(), np.ones((12, 16))]) * np.random.default_rng(5).uniform(0.6, 1.5, (12, 16, 1))


@pytest.mark.parametrize("signs", [(-1, -1, 1), (1, -1, -1), (-1, 1, -1)])
def test_images_in_other_camera_axes_are_turned(tmp_path: Path, signs: tuple[int, int, int]) -> None:
    """All right-handed axes with z along the line of sight, forward or back, come out the same; holes have no say."""
    image = IMAGE.copy()
    image[2:5, 3:9] = np.nan
    image[7] = 0
    scan = read_scan(files.put(tmp_path, "scan.npz", files.npz(points=image * signs, camera_to_world=files.POSE)))
    np.testing.assert_array_equal(scan.points, image.reshape(-1, 3)[scan.pixels])
    assert scan.camera_to_world is not None
    before = transform(files.POSE, scan.points * signs)
    np.testing.assert_allclose(transform(scan.camera_to_world, scan.points), before, rtol=0, atol=1e-12)
    assert "turned" in scan.notes[-1]
    assert len(scan.notes) == (3 if signs == (-1, 1, -1) else 2)


@pytest.mark.parametrize("signs", [(-1, 1, 1), (1, -1, 1)])
def test_mirrored_images_are_left_alone_and_said(tmp_path: Path, signs: tuple[int, int, int]) -> None:
    scan = read_scan(files.put(tmp_path, "scan.npz", files.npz(points=IMAGE * signs)))
    np.testing.assert_array_equal(scan.points, (IMAGE * signs).reshape(-1, 3))
    assert "the cloud is mirrored" in scan.notes[-1]


def test_scans_in_the_camera_frame_need_no_word(tmp_path: Path) -> None:
    for points in (POINTS, IMAGE):
        assert len(read_scan(files.put(tmp_path, "scan.npy", files.npy(points))).notes) == 1


def test_depth_images_are_never_turned(tmp_path: Path) -> None:
    scan = read_scan(files.put(tmp_path, "scan.npz", files.npz(z=files.counts(), K=np.array([20.0, 21.0, 7.25, 5.75]))))
    assert [note for note in scan.notes if "axes" in note] == []

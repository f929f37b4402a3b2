"""PLY: normals, extra columns, other elements, and what write_scan puts into the comments."""

from pathlib import Path

import numpy as np
import pytest

from tests.scans import files
from viewgain.scans import read_scan

POINTS = files.cloud()
NORMALS = files.unit_vectors()
FORMS = ["ascii", "binary_little_endian", "binary_big_endian"]


def with_normals(normals: np.ndarray) -> dict[str, np.ndarray]:
    return files.xyz(POINTS) | {f"n{name}": normals[:, axis] for axis, name in enumerate("xyz")}


@pytest.mark.parametrize("form", FORMS)
def test_normals_are_kept(tmp_path: Path, form: str) -> None:
    extra = {"curvature": np.arange(150.0)}
    scan = read_scan(files.put(tmp_path, "scan.ply", files.ply(extra | with_normals(NORMALS), form)))
    np.testing.assert_array_equal(scan.points, POINTS)
    np.testing.assert_allclose(scan.normals, NORMALS, rtol=0, atol=1e-15)


def test_normals_are_scaled_to_length_one_and_blank_ones_are_nan(tmp_path: Path) -> None:
    normals = 0.01 * NORMALS
    normals[3], normals[4] = 0, np.nan
    scan = read_scan(files.put(tmp_path, "scan.ply", files.ply(with_normals(normals))))
    assert scan.normals is not None
    assert np.isnan(scan.normals[3:5]).all()
    np.testing.assert_allclose(np.delete(scan.normals, [3, 4], 0), np.delete(NORMALS, [3, 4], 0), rtol=0, atol=1e-15)


def test_dropped_points_take_their_normals_along(tmp_path: Path) -> None:
    columns = with_normals(NORMALS)
    columns["x"] = columns["x"].copy()
    columns["x"][[0, 7]] = np.nan, np.inf
    scan = read_scan(files.put(tmp_path, "scan.ply", files.ply(columns)))
    assert (scan.dropped.not_a_number, scan.dropped.infinite) == (1, 1)
    np.testing.assert_allclose(scan.normals, np.delete(NORMALS, [0, 7], 0), rtol=0, atol=1e-15)


@pytest.mark.parametrize("form", FORMS)
def test_elements_after_the_vertices_do_no_harm(tmp_path: Path, form: str) -> None:
    """PCL's camera element, and faces of mixed sizes, which cannot be skipped without reading them."""
    header = "element camera 1\nproperty float view_px\nelement face 2\nproperty list uchar int vertex_indices"
    footer = b"0\n3 0 1 2\n4 0 1 2 3\n" if form == "ascii" else bytes(4) + b"\x03" + bytes(12) + b"\x04" + bytes(16)
    scan = read_scan(files.put(tmp_path, "scan.ply", files.ply(files.xyz(POINTS), form, header=header, footer=footer)))
    np.testing.assert_array_equal(scan.points, POINTS)
    assert "the file is a mesh: its vertices were read, its faces were not" in scan.notes


def test_elements_before_the_vertices_are_skipped(tmp_path: Path) -> None:
    data = files.ply(files.xyz(POINTS))
    data = data.replace(b"element vertex", b"element info 2\nproperty short a\nelement vertex")
    data = data.replace(b"end_header\n", b"end_header\nABCD")
    scan = read_scan(files.put(tmp_path, "scan.ply", data))
    np.testing.assert_array_equal(scan.points, POINTS)


def test_windows_line_ends_and_comments(tmp_path: Path) -> None:
    data = files.ply(files.xyz(POINTS), "ascii").replace(b"\n", b"\r\n").replace(b"made by a test", b"TextureFile gone.png")
    np.testing.assert_array_equal(read_scan(files.put(tmp_path, "scan.PLY", data)).points, POINTS)


def test_a_pixel_outside_the_image_is_refused(tmp_path: Path) -> None:
    data = files.ply(files.xyz(POINTS) | {"pixel": np.arange(150.0)}).replace(b"made by a test", b"viewgain image 10 14")
    with pytest.raises(ValueError, match="pixel numbers do not fit the image of 14 x 10"):
        read_scan(files.put(tmp_path, "scan.ply", data))

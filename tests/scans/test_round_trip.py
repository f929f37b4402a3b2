"""What goes into a file comes out of it: the same points in the same order, in every format."""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.scans import files
from viewgain.camera import Intrinsics
from viewgain.scans import Scan, read_scan, write_scan

FORMATS = sorted(files.every_format(files.cloud()))
sideways = st.floats(-0.5, 0.5, allow_subnormal=False)
clouds = (
    st.integers(100, 130)
    .flatmap(
        lambda count: st.tuples(
            arrays(float, (count, 2), elements=sideways), arrays(float, (count, 1), elements=st.floats(0.5, 9.0))
        )
    )
    .map(np.hstack)
)


@pytest.mark.parametrize("name", FORMATS)
@given(points=clouds)
def test_every_format_gives_the_points_back(name: str, points: np.ndarray) -> None:
    with tempfile.TemporaryDirectory() as folder:
        scan = read_scan(files.put(Path(folder), name, files.every_format(points)[name]))
    # pypcd4 writes ascii with ten digits; all other formats carry float64 exactly.
    np.testing.assert_allclose(scan.points, points, rtol=0, atol=1e-9 if name == "ascii.pcd" else 0)
    assert scan.shape is None
    assert scan.dropped.total == 0


@pytest.mark.parametrize("suffix", [".ply", ".npz"])
@given(points=clouds, posed=st.booleans(), with_normals=st.booleans())
def test_write_scan_gives_an_unorganised_scan_back(suffix: str, points: np.ndarray, posed: bool, with_normals: bool) -> None:
    normals = files.unit_vectors(len(points)) if with_normals else None
    scan = Scan.from_array(points, normals=normals, camera_to_world=files.POSE if posed else None)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"scan{suffix}")
        write_scan(scan, path)
        again = read_scan(path)
    assert_same(again, scan)


@pytest.mark.parametrize("suffix", [".ply", ".npz"])
def test_write_scan_gives_an_organised_scan_back(tmp_path: Path, suffix: str) -> None:
    scan = organised_scan()
    write_scan(scan, tmp_path / f"scan{suffix}")
    again = read_scan(tmp_path / f"scan{suffix}")
    assert_same(again, scan)
    if suffix == ".npz":
        assert again.intrinsics == scan.intrinsics
        np.testing.assert_array_equal(again.amplitude, scan.amplitude)


def test_scans_in_metres_far_away_stay_in_metres(tmp_path: Path) -> None:
    scan = Scan.from_array(files.cloud() + np.array([0, 0, 40.0]))
    for suffix in (".ply", ".npz"):
        write_scan(scan, tmp_path / f"far{suffix}")
        assert_same(read_scan(tmp_path / f"far{suffix}"), scan)


@pytest.mark.parametrize("kind", ["z", "range"])
@pytest.mark.parametrize("scale", [0.001, 0.0001, 0.00025])
def test_depth_png_gives_the_points_back_to_half_a_count(tmp_path: Path, kind: str, scale: float) -> None:
    scan = replace(organised_scan(), normals=None, amplitude=None)
    write_scan(scan, tmp_path / "depth.png", depth_scale=scale, depth_kind=kind)
    again = read_scan(tmp_path / "depth.png")
    np.testing.assert_array_equal(again.pixels, scan.pixels)
    assert again.shape == scan.shape
    assert again.intrinsics == scan.intrinsics
    np.testing.assert_allclose(again.camera_to_world, files.POSE, atol=1e-12)
    # Half a count along z, and at most a ray's length (under 1.2 here) times that along the ray.
    np.testing.assert_allclose(again.points, scan.points, rtol=0, atol=0.6 * scale)


@given(image=arrays(np.uint16, (12, 16), elements=st.integers(0, 65534)))
def test_depth_png_counts_survive_a_second_round(image: np.ndarray) -> None:
    image[:7] = np.maximum(image[:7], 1)
    with tempfile.TemporaryDirectory() as folder:
        first = files.put(Path(folder), "first.png", files.png(image))
        files.put(Path(folder), "first.json", files.camera_json(depth_scale=0.001))
        scan = read_scan(first)
        write_scan(scan, Path(folder, "second.png"))
        again = read_scan(Path(folder, "second.png"))
    np.testing.assert_array_equal(scan.pixels, np.flatnonzero(image))
    assert_same(again, scan)


def organised_scan() -> Scan:
    """A slanted plane seen through a distorted lens, with holes."""
    lens = (-0.05, 0.02, 0.001, -0.002, 0.003)
    camera = Intrinsics(width=16, height=12, fx=20.0, fy=21.0, cx=7.25, cy=5.75, distortion=lens)
    rays = np.dstack([camera.rays(), np.ones((12, 16))])
    points = rays * (1.0 / (rays @ [0.1, 0.2, 0.9]))[..., None]
    points[2, 3] = 0
    points[4, 5:9] = np.nan
    normals = np.tile(files.unit_vectors(1)[0], (12, 16, 1))
    amplitude = np.arange(192.0).reshape(12, 16)
    return Scan.from_array(points, intrinsics=camera, normals=normals, amplitude=amplitude, camera_to_world=files.POSE)


def assert_same(again: Scan, scan: Scan) -> None:
    np.testing.assert_array_equal(again.points, scan.points)
    assert again.shape == scan.shape
    for name, tolerance in (("pixels", 0), ("normals", 1e-15), ("camera_to_world", 1e-12)):
        mine, theirs = getattr(again, name), getattr(scan, name)
        assert (mine is None) == (theirs is None), name
        if mine is not None:
            # A normal is scaled to length 1 and a pose to the nearest rotation again: the last bit may change.
            np.testing.assert_allclose(mine, theirs, rtol=0, atol=tolerance)

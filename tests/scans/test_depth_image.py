"""Depth PNGs: scale, kind, lens, sidecars, amplitude."""

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.scans import files
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError, ScanError
from viewgain.scans import Scan, read_scan
from viewgain.scans._depth_image import depth_to_points
from viewgain.scans._intrinsics_file import DepthCamera

COUNTS = files.counts()


@pytest.fixture
def image(tmp_path: Path) -> Path:
    return files.put(tmp_path, "scan.png", files.png(COUNTS))


def test_the_file_beside_the_image_is_found_and_named(image: Path) -> None:
    general = files.put(image.parent, "intrinsics.json", files.camera_json(depth_scale=0.001))
    scan = read_scan(image)
    assert f"camera: taken from {general} beside the image" in scan.notes
    own = files.put(image.parent, "scan.json", files.camera_json(depth_scale=0.002, camera_to_world=files.POSE.tolist()))
    scan = read_scan(image)
    assert f"camera: taken from {own} beside the image" in scan.notes
    np.testing.assert_allclose(scan.camera_to_world, files.POSE, atol=1e-12)
    np.testing.assert_allclose(scan.points[:, 2], COUNTS.reshape(-1)[1:] * 0.002, rtol=1e-14)
    given = read_scan(image, intrinsics=general)
    assert not any("beside the image" in note for note in given.notes)
    assert given.camera_to_world is None


def test_points_lie_on_the_rays_of_their_pixels(image: Path) -> None:
    scan = read_scan(image, intrinsics=files.CAMERA)
    assert scan.shape == (12, 16)
    assert scan.intrinsics == files.CAMERA
    np.testing.assert_array_equal(scan.pixels, np.arange(1, 192))
    np.testing.assert_allclose(files.CAMERA.project(scan.points)[0], [1, 0], atol=1e-12)
    np.testing.assert_allclose(scan.points[:, 2], COUNTS.reshape(-1)[1:] * 0.001, rtol=1e-14)
    assert "units: read as one millimetre per count (no depth_scale given)" in scan.notes


@pytest.mark.parametrize(
    ("written", "metres"),
    [(0.001, 0.001), (0.0001, 0.0001), (1000, 0.001), (5000, 0.0002), (1, 0.001), (0.25, 0.00025), (0.1, 0.0001)],
)
def test_the_three_ways_to_write_a_depth_scale(image: Path, written: float, metres: float) -> None:
    """Metres per count (RealSense), counts per metre (Open3D), millimetres per count (Orbbec)."""
    camera = files.put(image.parent, "camera.json", files.camera_json(depth_scale=written))
    scan = read_scan(image, intrinsics=camera)
    np.testing.assert_allclose(scan.points[:, 2], COUNTS.reshape(-1)[1:] * metres, rtol=1e-12)
    assert f"units: {metres:.6g} m per count (depth_scale {written:g} in {camera})" in scan.notes
    ordered = read_scan(image, intrinsics=camera, units="mm")
    np.testing.assert_allclose(ordered.points[:, 2], COUNTS.reshape(-1)[1:] * 0.001, rtol=1e-12)


def test_saturated_pixels_are_infinite(tmp_path: Path) -> None:
    counts = COUNTS.copy()
    counts[3, 4:7] = 65535
    scan = read_scan(files.put(tmp_path, "scan.png", files.png(counts)), intrinsics=files.CAMERA)
    assert scan.dropped.infinite == 3
    assert scan.dropped.zero == 1


lenses = st.one_of(
    st.just(()),
    st.tuples(st.floats(-0.2, 0.2), st.floats(-0.05, 0.05), st.floats(-0.005, 0.005), st.floats(-0.005, 0.005)),
    st.tuples(*[st.floats(-0.1, 0.1)] * 2, *[st.floats(-0.003, 0.003)] * 2, *[st.floats(-0.05, 0.05)] * 4),
)


@given(lens=lenses, seed=st.integers(0, 99), kind=st.sampled_from(["z", "range"]))
def test_points_project_back_to_their_pixels_through_any_lens(lens: tuple[float, ...], seed: int, kind: str) -> None:
    camera = Intrinsics(width=16, height=12, fx=20.0, fy=21.0, cx=7.25, cy=5.75, distortion=lens)
    depth = np.random.default_rng(seed).uniform(0.5, 2, (12, 16))
    points, notes = depth_to_points(depth, DepthCamera(intrinsics=camera, source="test", kind=kind))
    u, v = np.meshgrid(np.arange(16), np.arange(12))
    # The lens is inverted by iteration (docs of Intrinsics.undistort); a thousandth of a pixel is far below any depth camera.
    np.testing.assert_allclose(camera.project(points), np.stack([u, v], -1), atol=1e-3)
    measured = points[..., 2] if kind == "z" else np.linalg.norm(points, axis=-1)
    np.testing.assert_allclose(measured, depth, rtol=1e-14)
    assert notes == ()


def test_kind_z_and_range_are_the_same_scene(tmp_path: Path) -> None:
    """The range image of a scene and its z image, each read as what it is, give the same points up to a count."""
    rays = np.dstack([files.CAMERA.rays(), np.ones((12, 16))])
    depth = 1.0 / (rays @ [0.1, 0.2, 0.9])
    images = {"z": depth, "range": depth * np.linalg.norm(rays, axis=-1)}
    scans: dict[str, Scan] = {}
    for kind, metres in images.items():
        path = files.put(tmp_path, f"{kind}.png", files.png(np.rint(metres * 10_000).astype(np.uint16)))
        files.put(tmp_path, f"{kind}.json", files.camera_json(depth_kind=kind, depth_scale=0.0001))
        scans[kind] = read_scan(path)
    np.testing.assert_allclose(scans["z"].points, scans["range"].points, rtol=0, atol=0.0001)
    np.testing.assert_allclose(scans["z"].points, (rays * depth[..., None]).reshape(-1, 3), rtol=0, atol=0.0001)


def test_returns_outside_the_lens_model_are_dropped_and_said() -> None:
    """A lens that folds back: no ray of the corners projects to them."""
    camera = Intrinsics(width=16, height=12, fx=8.0, fy=8.0, cx=7.5, cy=5.5, distortion=(-0.5, 0.0, 0.0, 0.0))
    points, notes = depth_to_points(np.ones((12, 16)), DepthCamera(intrinsics=camera, source="test"))
    lost = np.isnan(points).any(axis=-1)
    assert lost[0, 0]
    assert not lost[6, 8]
    assert notes == (f"lens: {lost.sum()} returns lie where the distortion model cannot be inverted; dropped as NaN",)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_amplitude_image_and_threshold(image: Path, kind: type) -> None:
    amplitude = np.arange(192).reshape(12, 16).astype(kind)
    path = files.put(image.parent, "amplitude.png", files.png(amplitude))
    for source in (path, str(path), amplitude):
        scan = read_scan(image, intrinsics=files.CAMERA, amplitude=source, min_amplitude=20)
        np.testing.assert_array_equal(scan.pixels, np.arange(20, 192))
        np.testing.assert_array_equal(scan.amplitude, amplitude)
        assert (scan.dropped.weak, scan.dropped.zero, scan.dropped.not_a_number) == (19, 1, 0)
    unfiltered = read_scan(image, intrinsics=files.CAMERA, amplitude=path)
    assert unfiltered.dropped.weak == 0


def test_bad_amplitude_images(image: Path) -> None:
    colour = files.put(image.parent, "colour.png", files.png(np.zeros((12, 16, 3), np.uint8)))
    small = files.put(image.parent, "small.png", files.png(np.zeros((6, 8), np.uint8)))
    with pytest.raises(ScanError, match=r"colour\.png: is a colour image, wanted an 8-bit or 16-bit grey"):
        read_scan(image, intrinsics=files.CAMERA, amplitude=colour)
    with pytest.raises(ScanError, match=r"small\.png: got an amplitude image of shape \(6, 8\)"):
        read_scan(image, intrinsics=files.CAMERA, amplitude=small)
    with pytest.raises(ScanError, match=r"gone\.png: no such file"):
        read_scan(image, intrinsics=files.CAMERA, amplitude="gone.png")
    with pytest.raises(ScanError, match="0 valid points"):
        read_scan(image, intrinsics=files.CAMERA, amplitude=np.zeros((12, 16)), min_amplitude=1)
    cloud = files.put(image.parent, "scan.ply", files.ply(files.xyz(files.cloud())))
    with pytest.raises(ScanError, match="give the one of this scan"):
        read_scan(cloud, amplitude=np.zeros((12, 16)))


def test_other_kinds_of_png(tmp_path: Path) -> None:
    for name, pixels, message in [
        ("alpha", np.zeros((12, 16, 4), np.uint8), "a colour image"),
        ("grey and alpha", np.zeros((12, 16, 2), np.uint8), "a LA image"),
        ("bits", np.zeros((12, 16), bool), "a black-and-white image"),
    ]:
        path = files.put(tmp_path, f"{name}.png", files.png(pixels))
        with pytest.raises(ScanError, match=f"{message}, wanted a 16-bit grey depth image"):
            read_scan(path, intrinsics=files.CAMERA)


def test_a_wrong_camera_object(image: Path) -> None:
    other = Intrinsics.from_field_of_view(640, 480, 1.0, 0.8)
    with pytest.raises(ConfigError, match=r"intrinsics: is for images of 640 x 480 pixels but .*scan\.png has 16 x 12"):
        read_scan(image, intrinsics=other)


def test_a_png_made_by_hand(tmp_path: Path) -> None:
    """Counts are big-endian in the file; Pillow wrote and read all the others, so one comes from elsewhere."""
    rows = b"".join(b"\0" + row.astype(">u2").tobytes() for row in COUNTS)

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", 16, 12, 16, 0, 0, 0, 0)
    data = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    scan = read_scan(files.put(tmp_path, "scan.png", data), intrinsics=files.CAMERA)
    np.testing.assert_allclose(scan.points[:, 2], COUNTS.reshape(-1)[1:] * 0.001, rtol=1e-14)

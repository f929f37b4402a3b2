"""The simulated camera: ranges against a ray-by-ray oracle, noise against its own formula, losses, flying pixels, calibration."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from tests.oracles.rays import world_range
from tests.oracles.scenes import CAMERA, corner_view, scan_of
from viewgain.box import Box
from viewgain.camera import Intrinsics, Sensor
from viewgain.errors import ScanError
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.scans import Scan
from viewgain.simulate import Scene, capture, miscalibrated, orbit_pose, pixel_directions, standing_box, true_ranges

SMALL = replace(CAMERA, intrinsics=Intrinsics.from_field_of_view(28, 21, *np.deg2rad([62.0, 45.0])))
"""Few enough pixels to cast them one by one."""
NOISELESS = replace(CAMERA, noise_per_metre=0.0, lateral_px=0.0, flying_share=0.0, grazing_start=1.56, grazing_end=1.57)


def ranges_of(scan: Scan) -> np.ndarray:
    """(h, w) ranges, NaN for no return."""
    return np.linalg.norm(scan.organised(), axis=-1)


def box() -> Box:
    return standing_box(np.array([0.35, 0.25, 0.3]), yaw=0.4)


@settings(max_examples=12)
@given(
    st.lists(st.floats(0.1, 0.5), min_size=6, max_size=6),
    st.floats(0, 6.2),
    st.floats(20, 75),
    st.floats(0.9, 1.8),
    st.floats(-0.5, 0.5),
)
def test_a_perfect_camera_reports_what_the_oracle_finds(
    extents: list[float], azimuth: float, elevation: float, distance: float, roll: float
) -> None:
    """Two boxes, one perhaps before the other; a pixel that a nudge of 1e-7 takes to another surface is left to rounding."""
    boxes = (standing_box(np.array(extents[:3]), yaw=0.3), standing_box(np.array(extents[3:]), yaw=1.0, at=(0.55, 0.2)))
    view = orbit_pose(np.array([0.2, 0.1, 0.1]), azimuth, np.deg2rad(elevation), distance, roll)
    camera = replace(SMALL, range_max=1e3)
    found = np.nan_to_num(ranges_of(capture(Scene(boxes), view, camera, rng=None)).ravel(), nan=np.inf)
    for ray, measured in zip(pixel_directions(camera.intrinsics, 0.0, None), found, strict=True):
        true, cosine = world_range(boxes, view, ray)
        if cosine > 0.03 and not np.isclose(measured, true, rtol=1e-9):  # under 2 degrees faces are skipped on purpose
            beside = [
                world_range(boxes, view, ray + np.array(nudge))[0]
                for nudge in ((1e-7, 0, 0), (-1e-7, 0, 0), (0, 1e-7, 0), (0, -1e-7, 0))
            ]
            assert np.ptp(np.minimum(beside, 1e6)) > 1e-4, (ray, measured, true)


@given(st.floats(0, 6.2), st.floats(20, 85), st.floats(0.9, 1.8))
def test_the_cosines_are_the_oracles_too(azimuth: float, elevation: float, distance: float) -> None:
    scene, view = Scene((box(),)), orbit_pose(box().centre, azimuth, np.deg2rad(elevation), distance)
    rays = pixel_directions(SMALL.intrinsics, 0.0, None)[::17]
    ranges, cosine = true_ranges(scene, view, rays)
    for k, ray in enumerate(rays):
        true = world_range(scene.boxes, view, ray)
        if np.isclose(true[0], ranges[k], rtol=1e-6):
            np.testing.assert_allclose(cosine[k], true[1], atol=1e-6)


@given(st.floats(0, 6.2), st.floats(-3, 3), st.floats(-3, 3))
def test_moving_scene_and_camera_together_changes_no_pixel(yaw: float, x: float, y: float) -> None:
    """The same seed makes the same noise; the true ranges agree to rounding."""
    motion = pose(rotation_from_rotvec(np.array([0.0, 0.0, yaw])), np.array([x, y, 0.0]))
    view = corner_view(box(), elevation_deg=40)
    first = ranges_of(capture(Scene((box(),)), view, SMALL, rng=np.random.default_rng(4)))
    second = ranges_of(capture(Scene((box().in_frame(motion),)), motion @ view, SMALL, rng=np.random.default_rng(4)))
    np.testing.assert_allclose(second, first, rtol=1e-9)


def test_the_same_seed_gives_the_same_bits_and_another_seed_others() -> None:
    view = corner_view(box())
    first, again, other = (scan_of(box(), view=view, rng=np.random.default_rng(seed)).organised() for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    both = np.isfinite(first[..., 2]) & np.isfinite(other[..., 2])
    assert np.mean(first[both] != other[both]) > 0.99


def test_a_scan_carries_its_camera_its_pose_and_its_name() -> None:
    view = corner_view(box())
    scan = scan_of(box(), view=view, source="kitchen")
    assert scan.source == "kitchen"
    assert scan.intrinsics == CAMERA.intrinsics
    assert scan.shape == (171, 224)
    np.testing.assert_allclose(scan.camera_to_world, view, atol=1e-12)


@pytest.mark.parametrize("elevation_deg", [85, 60, 35])
@pytest.mark.parametrize(
    "change", [{}, {"noise_constant": 0.004, "noise_per_metre": 0.0}, {"lateral_px": 1.5}, {"noise_per_square_metre": 0.01}]
)
def test_the_noise_on_a_floor_is_the_sensors(change: dict[str, float], elevation_deg: float) -> None:
    """Standardised by range_sigma, the residuals of 38,304 pixels have spread one (standard error 0.4 %).

    The slope term takes every pixel for one at the centre of the image; 12 degrees off axis that is 4 % too wide, so the camera
    is narrow, and has the same pitch both ways.
    """
    narrow = Intrinsics(width=224, height=171, fx=500.0, fy=500.0, cx=111.5, cy=85.0)
    camera = replace(CAMERA, range_max=20.0, intrinsics=narrow, **change)
    view = orbit_pose(np.zeros(3), 0.3, np.deg2rad(elevation_deg), 1.5)
    measured = ranges_of(capture(Scene(()), view, camera, rng=np.random.default_rng(5))).ravel()
    true, cosine = true_ranges(Scene(()), view, pixel_directions(narrow, 0.0, None))
    z = (measured - true) / camera.range_sigma(true, cosine)
    assert np.isfinite(z).mean() > 0.99
    np.testing.assert_allclose(np.nanstd(z), 1, atol=0.04)
    assert abs(np.nanmean(z)) < 0.03  # 0.005 by chance; the rest is the bend of the range over a pixel on a slope


def test_grazing_returns_are_lost_as_often_as_the_sensor_says() -> None:
    """Bands of 5 degrees of a floor seen flat; 4 standard errors of the share."""
    camera = replace(CAMERA, range_max=1e4, grazing_start=np.deg2rad(55), grazing_end=np.deg2rad(75))
    view = orbit_pose(np.zeros(3), 0.0, np.deg2rad(25), 1.0)
    lost = np.isnan(ranges_of(capture(Scene(()), view, camera, rng=np.random.default_rng(6)))).ravel()
    _, cosine = true_ranges(Scene(()), view, pixel_directions(camera.intrinsics, 0.0, None))
    angle = np.rad2deg(np.arccos(cosine))
    for low in range(45, 85, 5):
        band = (angle >= low) & (angle < low + 5)
        expected = np.clip((angle[band] - 55) / 20, 0, 1)
        assert band.sum() > 500
        slack = 4 * np.sqrt(max(np.mean(expected * (1 - expected)), 1e-9) / band.sum())
        assert abs(lost[band].mean() - expected.mean()) <= slack


def test_flying_pixels_lie_between_foreground_and_background_and_only_on_edges() -> None:
    view = corner_view(box(), elevation_deg=45)
    clean = ranges_of(scan_of(box(), view=view, camera=NOISELESS))
    mixed = ranges_of(scan_of(box(), view=view, camera=replace(NOISELESS, flying_share=0.5), rng=np.random.default_rng(0)))
    nearest, farthest = ndimage.minimum_filter(clean, 3), ndimage.maximum_filter(clean, 3)
    jump = farthest - nearest > 0.05
    changed = ~np.isclose(clean, mixed, rtol=1e-12)
    assert not changed[~jump].any()
    assert np.all((mixed >= nearest - 1e-12) & (mixed <= farthest + 1e-12))
    clear = farthest - nearest > 0.1 + 0.02 * nearest  # well over the simulator's threshold of 3 cm plus 2 %
    count = clear.sum()
    assert count > 200
    assert abs(changed[clear].mean() - 0.5) < 4 * 0.5 / np.sqrt(count)
    depth = ((mixed - nearest) / (farthest - nearest))[clear & changed]
    assert abs(depth.mean() - 0.5) < 4 / np.sqrt(12 * len(depth))
    assert depth.min() < 0.1
    assert depth.max() > 0.9


def test_without_edges_nothing_flies() -> None:
    view = orbit_pose(np.zeros(3), 0.0, np.deg2rad(60), 1.2)
    clean = ranges_of(capture(Scene(()), view, NOISELESS, rng=None))
    mixed = ranges_of(capture(Scene(()), view, replace(NOISELESS, flying_share=1.0), rng=np.random.default_rng(0)))
    np.testing.assert_allclose(mixed, clean, rtol=1e-12)


@given(st.floats(-0.02, 0.02), st.floats(-0.02, 0.02))
def test_a_miscalibrated_camera_reports_scaled_and_shifted_ranges(scale: float, offset: float) -> None:
    """Along the same ray, r (1 + s) + o; in an image and in an unorganised cloud."""
    scan = scan_of(box(), view=corner_view(box()), camera=SMALL, rng=np.random.default_rng(0))
    for given_scan in (scan, Scan.from_array(scan.points, source="cloud")):
        wrong = miscalibrated(given_scan, scale=scale, offset=offset)
        distance = np.linalg.norm(scan.points, axis=1)
        np.testing.assert_allclose(np.linalg.norm(wrong.points, axis=1), distance * (1 + scale) + offset, rtol=1e-12)
        np.testing.assert_allclose(np.cross(wrong.points, scan.points), 0, atol=1e-12)
        assert wrong.source == given_scan.source
        assert wrong.shape == given_scan.shape
        assert wrong.intrinsics == given_scan.intrinsics
    kept = miscalibrated(scan, scale=scale, offset=offset)
    np.testing.assert_array_equal(kept.pixels, scan.pixels)
    np.testing.assert_allclose(kept.camera_to_world, scan.camera_to_world, atol=1e-12)


def test_returns_out_of_range_are_dropped() -> None:
    view = orbit_pose(np.zeros(3), 0.0, np.deg2rad(40), 1.5)
    everything = ranges_of(capture(Scene(()), view, replace(NOISELESS, range_max=1e3), rng=None))
    limited = ranges_of(capture(Scene(()), view, replace(NOISELESS, range_min=1.2, range_max=1.9), rng=None))
    within = (everything >= 1.2) & (everything <= 1.9)
    assert 0.1 < within.mean() < 0.9
    np.testing.assert_array_equal(np.isfinite(limited), within)
    noisy = ranges_of(capture(Scene(()), view, replace(CAMERA, range_min=1.2, range_max=1.9), rng=np.random.default_rng(0)))
    assert np.nanmin(noisy) >= 1.2
    assert np.nanmax(noisy) <= 1.9


def test_a_camera_that_sees_nothing_says_so() -> None:
    up = orbit_pose(np.array([0.0, 0.0, 3.0]), 0.0, np.deg2rad(-80), 1.5)  # looks at the sky
    with pytest.raises(ScanError, match="valid points"):
        capture(Scene(()), up, CAMERA, rng=None)


def test_lateral_noise_is_of_the_size_asked_for() -> None:
    camera: Sensor = CAMERA
    still, shaken = (pixel_directions(camera.intrinsics, px, np.random.default_rng(1)) for px in (0.0, 0.7))
    shift = (shaken[:, :2] / shaken[:, 2:] - still[:, :2] / still[:, 2:]) * (camera.intrinsics.fx, camera.intrinsics.fy)
    np.testing.assert_allclose(shift.std(axis=0), 0.7, rtol=0.03)  # 38,304 draws: 0.4 %
    np.testing.assert_allclose(np.linalg.norm(shaken, axis=1), 1, atol=1e-12)

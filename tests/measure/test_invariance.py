"""What must not change the answer: the order of the points, how the camera is turned, the unit of length, being asked twice."""

from dataclasses import replace

import numpy as np
import pytest

from tests.oracles.scenes import CAMERA, WELL_SEEN, corner_view, scan_of
from viewgain.camera import Intrinsics
from viewgain.measure import measure
from viewgain.scans import Scan
from viewgain.scenes import random_box, random_view, standing_box


def noisy_scan(seed: int) -> Scan:
    rng = np.random.default_rng(seed)
    box = random_box(rng, WELL_SEEN)
    return scan_of(box, view=random_view(rng, box, WELL_SEEN), rng=rng)


def quarter_turned(scan: Scan, quarters: int) -> Scan:
    """Return the scan as the same camera takes it when held turned by 90 degrees, anticlockwise on the screen, so often."""
    image, camera = np.rot90(scan.organised(), quarters), scan.intrinsics
    assert camera is not None
    for _ in range(quarters):
        image = np.stack([image[..., 1], -image[..., 0], image[..., 2]], axis=-1)
    height, width = image.shape[:2]
    fx, fy = (camera.fx, camera.fy) if quarters % 2 == 0 else (camera.fy, camera.fx)
    return Scan.from_array(
        image, intrinsics=Intrinsics(width=width, height=height, fx=fx, fy=fy, cx=(width - 1) / 2, cy=(height - 1) / 2)
    )


@pytest.mark.parametrize("quarters", [1, 2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_holding_the_camera_turned_by_quarters_changes_little(seed: int, quarters: int) -> None:
    """The very same returns; but which of them are thinned out in the first fits depends on the image's order."""
    scan = noisy_scan(seed)
    straight, turned = measure(scan, camera=CAMERA).boxes[0], measure(quarter_turned(scan, quarters), camera=CAMERA).boxes[0]
    apart = np.abs(turned.dimensions - straight.dimensions)
    assert np.all(apart < 0.7 * np.array(straight.sigma) + 5e-4)
    np.testing.assert_allclose(turned.sigma, straight.sigma, rtol=0.25)
    assert turned.vertical == straight.vertical


@pytest.mark.parametrize("roll_deg", [-60, -25, 25, 60, 90, 180])
def test_rolling_the_camera_changes_nothing_without_noise(roll_deg: float) -> None:
    """Other pixels, same view: to the millimetre that a noise-free scan gives."""
    box = standing_box(np.array([0.35, 0.25, 0.3]), yaw=0.4)
    straight, rolled = (
        measure(scan_of(box, view=corner_view(box, roll_deg=roll)), camera=CAMERA).boxes[0] for roll in (0.0, roll_deg)
    )
    np.testing.assert_allclose(rolled.dimensions, straight.dimensions, atol=1e-3)
    np.testing.assert_allclose(rolled.volume, straight.volume, rtol=0.01)
    assert rolled.vertical == straight.vertical


@pytest.mark.parametrize("seed", range(4))
def test_the_order_of_an_unorganised_cloud_does_not_matter(seed: int) -> None:
    """The grid laid over the cloud is fitted to a sample of the points, so it may differ by a hair."""
    points = noisy_scan(seed).points
    orders = [np.random.default_rng(seed).permutation(len(points)), np.arange(len(points))[::-1], np.argsort(points[:, 2])]
    straight = measure(Scan.from_array(points), camera=CAMERA).boxes[0]
    for order in orders:
        shuffled = measure(Scan.from_array(points[order]), camera=CAMERA).boxes[0]
        assert np.all(np.abs(shuffled.dimensions - straight.dimensions) < 0.3 * np.array(straight.sigma))


@pytest.mark.parametrize("seed", range(6))
def test_an_unorganised_cloud_gives_what_the_image_gives(seed: int) -> None:
    """It lost the pixels without a return, so its edges are less well known; the answers agree within their errors."""
    scan = noisy_scan(seed)
    image, cloud = measure(scan, camera=CAMERA).boxes[0], measure(Scan.from_array(scan.points), camera=CAMERA).boxes[0]
    apart = np.abs(cloud.dimensions - image.dimensions)
    assert np.all(apart < 4 * np.hypot(image.sigma, cloud.sigma) + 1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_an_image_without_intrinsics_gives_what_the_image_with_them_gives(seed: int) -> None:
    """The lens is fitted to the points themselves, and that is all it takes."""
    scan = noisy_scan(seed)
    with_lens, without = (
        measure(Scan.from_array(scan.organised(), intrinsics=lens), camera=CAMERA).boxes[0] for lens in (scan.intrinsics, None)
    )
    np.testing.assert_allclose(without.dimensions, with_lens.dimensions, atol=2e-4)


@pytest.mark.parametrize("factor", [0.6, 1.6])
@pytest.mark.parametrize("seed", range(4))
def test_a_larger_scene_is_a_larger_box(seed: int, factor: float) -> None:
    """All lengths scaled, noise too (it is proportional to range). Only thresholds such as 1.5 cm of height stay."""
    scan = noisy_scan(seed)
    scaled = Scan.from_array(scan.organised() * factor, intrinsics=scan.intrinsics)
    plain, large = measure(scan, camera=CAMERA).boxes[0], measure(scaled, camera=CAMERA).boxes[0]
    apart = np.abs(large.dimensions / factor - plain.dimensions)
    assert np.all(apart < 0.7 * np.array(plain.sigma) + 5e-4)
    np.testing.assert_allclose(np.array(large.sigma) / factor, plain.sigma, rtol=0.2)


def test_asked_twice_it_answers_the_same_and_leaves_the_scan_alone() -> None:
    scan = noisy_scan(9)
    before = scan.points.copy()
    first, second = measure(scan, camera=CAMERA).to_dict(), measure(scan, camera=CAMERA).to_dict()
    assert first == second
    np.testing.assert_array_equal(scan.points, before)


def test_the_pose_of_the_camera_is_for_the_world_only() -> None:
    scan = noisy_scan(3)
    assert scan.camera_to_world is not None
    free = replace(scan, camera_to_world=None)
    np.testing.assert_array_equal(
        measure(free, camera=CAMERA).boxes[0].dimensions, measure(scan, camera=CAMERA).boxes[0].dimensions
    )


@pytest.mark.parametrize("seed", range(6))
def test_a_camera_said_to_be_noisier_never_gives_narrower_intervals(seed: int) -> None:
    """Same points. Below the scan's own noise the noise is estimated and the data sheet moot; from there on it widens.

    A noisier camera also shifts the fit by a fraction of sigma, which moves the width by a few per cent either way.
    """
    scan = noisy_scan(seed)
    widths = []
    for noise in (0.005, 0.01, 0.02, 0.04):
        found = measure(scan, camera=replace(CAMERA, noise_per_metre=noise)).boxes[0]
        low, high = found.volume_interval90
        widths.append([*sorted(end - start for start, end in found.interval90), high - low])
    steps = np.diff(np.log(widths), axis=0)
    assert np.all(steps > -0.1)
    assert np.all(steps[1:].mean(axis=1) > 0)
    assert widths[-1][-1] > 1.03 * widths[0][-1]  # where edges decide, range noise counts for little

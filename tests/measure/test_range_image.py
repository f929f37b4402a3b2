"""The working form of a scan: what it keeps of an image, and the grid that it lays over a cloud."""

import numpy as np
import pytest

from tests.oracles.scenes import CAMERA, corner_view, scan_of
from viewgain.camera import Intrinsics
from viewgain.measure import range_image
from viewgain.scans import Scan
from viewgain.scenes import standing_box

LENS = Intrinsics(width=120, height=90, fx=100.0, fy=98.0, cx=58.0, cy=46.0, distortion=(-0.2, 0.06, 0.001, -0.0005))


def crate_scan() -> Scan:
    box = standing_box(np.array([0.35, 0.25, 0.3]))
    return scan_of(box, view=corner_view(box), rng=np.random.default_rng(0))


def lens_scan() -> Scan:
    ranges = np.random.default_rng(1).uniform(0.8, 1.6, (90, 120))
    ranges[:, :15] = np.nan  # a dark border: the lens is known there all the same
    return Scan.from_range(ranges, LENS)


def test_an_image_keeps_every_return_in_its_pixel() -> None:
    scan = crate_scan()
    image = range_image(scan)
    np.testing.assert_allclose(image.points, scan.organised(), atol=1e-12)
    np.testing.assert_array_equal(image.valid, np.isfinite(scan.organised()[..., 2]))
    assert image.known.all()
    assert image.organised
    np.testing.assert_allclose(np.linalg.norm(image.directions, axis=-1), 1, atol=1e-12)


@pytest.mark.parametrize("with_intrinsics", [True, False])
def test_pixels_without_a_return_look_where_the_lens_looks(with_intrinsics: bool) -> None:
    """From the intrinsics exactly; from the lens fitted to the other pixels to a tenth of a pixel, even 15 pixels outside."""
    scan = lens_scan()
    if not with_intrinsics:
        scan = Scan.from_array(scan.organised())
    image, rays = range_image(scan), LENS.rays()
    empty = ~image.valid
    assert empty.sum() == 90 * 15
    found = image.directions[empty][:, :2] / image.directions[empty][:, 2:]
    np.testing.assert_allclose(found, rays[empty], atol=1e-9 if with_intrinsics else 1e-3)


@pytest.mark.parametrize("with_intrinsics", [True, False])
def test_directions_lead_back_to_their_pixels(with_intrinsics: bool) -> None:
    scan = lens_scan() if with_intrinsics else Scan.from_array(lens_scan().organised())
    image = range_image(scan)
    rows, columns = np.mgrid[0:90:7, 20:120:9].reshape(2, -1)
    pixels = image.plane.to_pixels(LENS.rays()[rows, columns])
    np.testing.assert_allclose(pixels, np.column_stack([columns, rows]), atol=1e-3 if with_intrinsics else 0.05)


def test_the_pitch_is_that_of_the_lens_at_its_centre() -> None:
    for scan in (lens_scan(), Scan.from_array(lens_scan().organised())):
        np.testing.assert_allclose(range_image(scan).pitch, 1 / 99, rtol=0.02)


def test_a_cloud_falls_into_a_grid_of_about_its_own_pitch() -> None:
    scan = crate_scan()
    image = range_image(Scan.from_array(scan.points))
    np.testing.assert_allclose(image.pitch, 2 / (CAMERA.intrinsics.fx + CAMERA.intrinsics.fy), rtol=0.15)
    np.testing.assert_array_equal(image.known, image.valid)
    assert not image.organised
    assert image.valid.sum() > 0.75 * len(scan.points), "few points share a cell"


def test_each_cell_holds_a_point_of_the_cloud_where_it_belongs() -> None:
    """Every filled cell is one of the points, unchanged, and within half a cell of where the grid's own camera sees it."""
    scan = crate_scan()
    image = range_image(Scan.from_array(scan.points))
    points = image.points[image.valid]
    known = {tuple(point) for point in np.round(scan.points, 9)}
    assert all(tuple(point) in known for point in np.round(points, 9))
    rows, columns = np.nonzero(image.valid)
    pixels = image.plane.to_pixels(points[:, :2] / points[:, 2:])
    np.testing.assert_allclose(pixels, np.column_stack([columns, rows]), atol=0.5 + 1e-6)


def test_of_two_points_in_one_cell_the_nearer_is_kept() -> None:
    """Ghosts of every tenth point, 0.5 m behind it on the same ray, in any order: none is seen."""
    points = crate_scan().points
    ghosts = points[::10] * (1 + 0.5 / np.linalg.norm(points[::10], axis=1, keepdims=True))
    both = np.vstack([points, ghosts])
    for order in (slice(None), slice(None, None, -1)):
        image = range_image(Scan.from_array(both[order]))
        seen = {tuple(point) for point in np.round(image.points[image.valid], 9)}
        assert not seen & {tuple(ghost) for ghost in np.round(ghosts, 9)}


def test_points_behind_the_camera_are_left_out() -> None:
    scan = crate_scan()
    turned = np.where(np.arange(len(scan.points))[:, None] % 2, scan.points, -scan.points)
    image = range_image(Scan.from_array(turned))
    assert np.all(image.points[image.valid][:, 2] > 0)
    organised = scan.organised()
    organised[:50] *= -1
    assert not range_image(Scan.from_array(organised, intrinsics=scan.intrinsics)).valid[:50].any()


def test_a_crop_is_taken_for_the_middle_of_a_larger_image() -> None:
    """The left third of a cloud: its camera saw as far to the right."""
    points = crate_scan().points
    left = points[points[:, 0] / points[:, 2] < -0.2]
    image = range_image(Scan.from_array(left))
    whole = image.whole_camera()
    assert whole.width > 2 * image.intrinsics.width
    reach = -left[:, 0] / left[:, 2]
    np.testing.assert_allclose(whole.cx / whole.fx, reach.max(), rtol=0.05)
    np.testing.assert_allclose((whole.width - 1) / 2, whole.cx)
    assert range_image(crate_scan()).whole_camera() == CAMERA.intrinsics

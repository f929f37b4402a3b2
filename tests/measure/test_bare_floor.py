"""The empty scene as evidence: its slope, its share in what is known, and where it has a say."""

import numpy as np
import pytest

from tests.oracles.derivatives import along_steps
from tests.oracles.scenes import CAMERA, corner_view, scan_of
from viewgain.box import Box, entry_mask
from viewgain.camera import sensor
from viewgain.geometry import inverse
from viewgain.measure import BoxEstimate, Measurement, measure
from viewgain.measure._fit import COARSE, SHARP
from viewgain.measure._likelihood import evaluate
from viewgain.scans import Scan
from viewgain.scenes import standing_box

BOX = standing_box(np.array([0.35, 0.25, 0.3]))
VIEW = corner_view(BOX, elevation_deg=40.0, distance=1.1)


def black(scan: Scan, box: Box = BOX, shown: float = 0.0) -> Scan:
    """The scan with nothing from beside the box but the lowest share ``shown`` of the image's rows."""
    image = scan.organised()
    hit = entry_mask(box.in_frame(inverse(VIEW)), CAMERA.intrinsics.directions().reshape(-1, 3)).reshape(image.shape[:2])
    dark = ~hit & (np.arange(len(image)) < (1 - shown) * len(image))[:, None]
    image[dark] = np.nan
    return Scan.from_array(image, intrinsics=scan.intrinsics)


@pytest.fixture(scope="module")
def scans() -> tuple[Scan, Scan]:
    """The box on a floor that shows, and the empty scene."""
    rng = np.random.default_rng(2)
    return scan_of(BOX, view=VIEW, rng=rng), scan_of(view=VIEW, rng=rng)


@pytest.fixture(scope="module")
def measured(scans: tuple[Scan, Scan]) -> Measurement:
    return measure(black(scans[0]), camera=CAMERA, floor=scans[1])


def only(measured: Measurement) -> BoxEstimate:
    assert len(measured.boxes) == 1
    return measured.boxes[0]


@pytest.mark.parametrize("softness", [COARSE[1], SHARP[0]])
def test_its_slope_is_the_difference_of_its_value(measured: Measurement, softness: object) -> None:
    """What the empty scene adds, in units of sigma, nine sigma off the top; slopes leave out how noise grows with the range."""
    found = only(measured)
    view, scale = found.views[0], np.linalg.cholesky(found.covariance)
    assert view.bare is not None
    box = found.box.moved(scale @ np.full(9, 3.0))

    def added(box: Box) -> float:
        both = (evaluate(box, view.pixels, view.sensor, view.noise, softness, bare) for bare in (view.bare, None))
        return float(np.subtract(*(evaluation.value for evaluation in both)))

    with_it, without = (
        evaluate(box, view.pixels, view.sensor, view.noise, softness, bare).derivatives for bare in (view.bare, None)
    )
    slope = scale.T @ (with_it.gradient - without.gradient)
    differences = scale.T @ along_steps(added, box, 1e-6)
    assert np.abs(slope).max() > 0.3
    np.testing.assert_allclose(slope, differences, atol=0.1 * np.abs(slope).max())
    information = with_it.information - without.information
    assert np.linalg.matrix_rank(information, tol=1e-9 * np.abs(information).max()) == 3  # height and two tilts
    assert np.all(np.linalg.eigvalsh(information) > -1e-6 * np.abs(information).max())


def test_no_return_from_the_floor_is_no_harm(scans: tuple[Scan, Scan], measured: Measurement) -> None:
    """Height and its sigma are those of a floor that shows; without the empty scene nothing of it is known."""
    shown, dark = only(measure(scans[0], camera=CAMERA)), only(measured)
    truth = np.sort(BOX.extents)[::-1]
    np.testing.assert_allclose(dark.dimensions, truth, atol=0.005)
    assert abs(dark.dimensions[dark.vertical] - BOX.extents[2]) < 0.002
    sigmas = [box.sigma[box.vertical] for box in (dark, shown)]
    assert 1 < sigmas[0] / sigmas[1] < 3  # of a thousand readings, not of all
    assert measure(black(scans[0]), camera=CAMERA).boxes == ()


def test_what_the_camera_misreads_alike_in_both_scans_is_no_error_of_the_height(scans: tuple[Scan, Scan]) -> None:
    """The scale and offset of a camera that was not calibrated move floor and top together, as in one scan that shows both."""
    camera = sensor("pico_flexx")
    dark = only(measure(black(scans[0]), camera=camera, floor=scans[1]))
    shown = only(measure(scans[0], camera=camera))
    assert dark.sigma[dark.vertical] == pytest.approx(shown.sigma[shown.vertical], rel=0.1)


def test_a_scan_that_shows_its_floor_goes_by_what_it_shows(scans: tuple[Scan, Scan]) -> None:
    full, empty = scans
    seen = only(measure(full, camera=CAMERA, floor=empty))
    assert seen.views[0].bare is None
    little, much = (only(measure(black(full, shown=shown), camera=CAMERA, floor=empty)).views[0].bare for shown in (0.02, 0.5))
    assert little is not None
    assert much is None
    on_floor = little.directions * little.ranges[:, None]
    assert np.abs(BOX.in_frame(inverse(VIEW)).floor.height(on_floor)).max() < 0.05
    assert len(on_floor) > 500


def test_a_nearer_floor_makes_a_lower_box(scans: tuple[Scan, Scan]) -> None:
    """The scene was cleared, and a mat of 2 cm laid out: the box that hides it is 2 cm lower than it would be on the floor."""
    full, empty = scans
    view = VIEW.copy()
    view[2, 3] -= 0.02  # the floor is 2 cm nearer to the camera
    mat = scan_of(view=view, rng=np.random.default_rng(3))
    heights = [
        found.dimensions[found.vertical]
        for found in (only(measure(black(full), camera=CAMERA, floor=each)) for each in (empty, mat))
    ]
    assert heights[0] - heights[1] == pytest.approx(0.02, abs=0.002)


def test_parts_of_a_stack_stand_on_one_another_and_not_on_the_empty_scene(scans: tuple[Scan, Scan]) -> None:
    upper = Box(BOX.box_to_camera.copy(), np.array([0.2, 0.15, 0.2]))
    upper.box_to_camera[2, 3] += BOX.extents[2]
    rng = np.random.default_rng(4)
    both = scan_of(BOX, upper, view=VIEW, rng=rng).organised()
    rays = CAMERA.intrinsics.directions().reshape(-1, 3)
    hit = np.logical_or.reduce([entry_mask(box.in_frame(inverse(VIEW)), rays) for box in (BOX, upper)])
    both[~hit.reshape(both.shape[:2])] = np.nan
    found = measure(Scan.from_array(both, intrinsics=scans[0].intrinsics), camera=CAMERA, floor=scans[1])
    by_flag = {("stacked" in box.flags): box for box in found.boxes}
    assert set(by_flag) == {True, False}
    assert by_flag[True].views[0].bare is None
    assert by_flag[False].views[0].bare is not None
    assert by_flag[False].dimensions[by_flag[False].vertical] == pytest.approx(0.3, abs=0.01)

"""From light to numbers: the published noise comes out of simulated scans again, and losses and rounding do what they say."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.footprint import flipped_edges
from tests.simulate.targets import EYE, FAR, Array, cropped, flat_target, grazing, only_plane, plane_ranges, plate, ranges_of
from viewgain.camera import Sensor, sensor
from viewgain.errors import ScanError
from viewgain.scenes import Scene, orbit_pose
from viewgain.simulate import Effects, RangeError, capture, draw_range_error, true_hits
from viewgain.simulate._receive import flying

XTION, KINECT = sensor("xtion"), sensor("kinect_v2")


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def nguyen_axial(z: float, theta: float) -> float:
    """Nguyen, Izadi, Lovell 2012, equation 5, metres."""
    return float(0.0012 + 0.0019 * (z - 0.4) ** 2 + 0.0001 / np.sqrt(z) * grazing(theta) ** 2)


def nguyen_lateral(theta: float) -> float:
    """Nguyen, Izadi, Lovell 2012, equation 3, pixels."""
    return 0.8 + 0.035 * grazing(theta)


def fankhauser_axial(z: float, theta: float) -> float:
    """Fankhauser et al. 2015, metres."""
    return 1e-3 * float(1.5 - 0.5 * z + 0.3 * z**2 + 0.1 * z**1.5 * grazing(theta) ** 2)


def depth_scatter(camera: Sensor, z: float, theta: float, captures: int) -> tuple[float, float]:
    """Return the scatter of the depth about the true plane and about the fitted one, metres, in the middle of the image.

    31 x 31 pixels: 1.5 to 2 degrees to each side, so that distance and angle are the target's.
    """
    camera, plane = cropped(camera, 31, 31), flat_target(z, theta)
    forward = camera.intrinsics.directions()[..., 2]
    true = plane_ranges(plane, camera) * forward
    slopes = camera.intrinsics.rays().reshape(-1, 2)
    about_truth, about_fit = [], []
    for seed in range(captures):
        depth = capture(only_plane(plane), EYE, camera, rng=rng(seed)).organised()[..., 2]
        residual = (depth - true).ravel()
        valid = np.isfinite(residual)
        assert valid.mean() > 0.99
        # A plane's inverse depth is linear in the image, so a slightly other plane differs by z^2 times a linear function.
        basis = np.column_stack([np.ones(len(slopes)), slopes])[valid] * true.ravel()[valid, None] ** 2
        fitted = basis @ np.linalg.lstsq(basis, residual[valid], rcond=None)[0]
        about_truth.append(np.mean(residual[valid] ** 2))
        about_fit.append(np.sum((residual[valid] - fitted) ** 2) / (valid.sum() - 3))
    return float(np.sqrt(np.mean(about_truth))), float(np.sqrt(np.mean(about_fit)))


@pytest.mark.parametrize("theta_deg", [10, 20, 30, 45, 60])
@pytest.mark.parametrize("z", [0.6, 1.0, 1.5, 2.0, 2.5, 3.0])
def test_the_xtions_flat_targets_scatter_as_nguyen_measured(z: float, theta_deg: float) -> None:
    """All effects on, rounding included. 5 %: 1.1 % by chance (9,610 pixels), the rest for depth taken for range."""
    theta = np.deg2rad(theta_deg)
    for scatter in depth_scatter(XTION, z, theta, 10):
        np.testing.assert_allclose(scatter, nguyen_axial(z, theta), rtol=0.05)


@pytest.mark.parametrize("theta_deg", [0, 10, 20, 30, 45, 60])
@pytest.mark.parametrize("z", [1.0, 1.5, 2.0, 2.5, 3.0, 3.5])
def test_the_kinects_flat_targets_scatter_as_fankhauser_measured(z: float, theta_deg: float) -> None:
    """All effects on, rounding and wiggle included: 0.2 mm rms beside 1.3 mm is 1.3 %, 0.3 mm at a crest 2.6 %, chance 1.1 %."""
    theta = np.deg2rad(theta_deg)
    for scatter in depth_scatter(KINECT, z, theta, 10):
        np.testing.assert_allclose(scatter, fankhauser_axial(z, theta), rtol=0.05)


def edge_scatter(theta: float) -> tuple[float, float]:
    """Return the sd over rows, about the fitted line, of where an upright edge lies: number of near pixels, last near pixel."""
    camera = cropped(XTION, 41, 401)
    scene = Scene((plate(1.0, theta),), planes=(flat_target(2.0),))
    rows, found = np.arange(401), []
    for seed in range(6):
        depth = capture(scene, EYE, camera, rng=rng(seed)).organised()[..., 2]
        near = depth[:, 10:31] < 1.5
        for edge in (near.sum(axis=1), [np.flatnonzero(row).max() for row in near]):
            found.append(np.var(edge - np.polyval(np.polyfit(rows, edge, 1), rows)))
    count, last = np.sqrt(np.mean(np.reshape(found, (6, 2)), axis=0))
    return float(count), float(last)


@pytest.mark.parametrize("theta_deg", [0, 20, -20, 40, -40, 60, -60])
def test_the_xtions_edges_scatter_as_nguyen_measured(theta_deg: float) -> None:
    """The edge pixel of a row is its last one on the plate, as in the paper; all effects on.

    Against an edge whose pixels flip one by one, without the simulator's reach of 1.5 sd: 6 %, 1.4 % of it by chance (2,406
    rows). Against the paper: 15 %. Pixels that look aside by 0.8 px, each for itself, put the last one of a row within 0.76 px
    (its place is decided by several of them, and rounding to whole pixels is in it), and on a slanted plate only the pixels on
    the plate have its larger displacement, the background's half does not.
    """
    theta = abs(np.deg2rad(theta_deg))
    count, last = edge_scatter(np.deg2rad(theta_deg))
    expected = flipped_edges(nguyen_lateral(theta), 40_000, rng(), sigma_beyond=nguyen_lateral(0.0)).std(axis=0)
    np.testing.assert_allclose([count, last], expected, rtol=0.06)
    np.testing.assert_allclose(last, nguyen_lateral(theta), rtol=0.15)


@pytest.mark.parametrize(("kind", "growth"), [("tof", 2.0), ("structured_light", 1.0)])
def test_a_darker_target_is_noisier_to_time_of_flight_only(kind: str, growth: float) -> None:
    """A quarter of the light, half the photons' signal to noise. 2 %: four standard errors of 38,304 pixels."""
    camera, target = replace(FAR, kind=kind), flat_target(1.5)
    spread = []
    for reflectivity in (0.8, 0.2):
        noisy = ranges_of(capture(only_plane(target, reflectivity), EYE, camera, rng=rng(), effects=Effects.only("noise")))
        true = plane_ranges(target, camera)
        spread.append(np.std((noisy - true) / camera.range_sigma(true, 1.5 / true)))
    np.testing.assert_allclose(spread[1] / spread[0], growth, rtol=0.02)
    expected = np.sqrt(0.5 / 0.8) if kind == "tof" else 1.0  # the noise is stated for a reflectivity of 0.5
    np.testing.assert_allclose(spread[0], expected, rtol=0.02)


def test_the_noise_of_the_amplitude_is_that_of_the_light() -> None:
    """A phase error of sigma 2 pi / wavelength is a relative amplitude error of the same size, independent of it. 2 %: chance."""
    target = flat_target(1.5)
    scan = capture(only_plane(target), EYE, FAR, rng=rng(), effects=Effects.only("noise"))
    clean = capture(only_plane(target), EYE, FAR, rng=None)
    assert scan.amplitude is not None
    assert clean.amplitude is not None
    true = plane_ranges(target, FAR)
    sigma = FAR.range_sigma(true, 1.5 / true)
    relative = (scan.amplitude / clean.amplitude - 1) / (2 * np.pi / FAR.wavelength * sigma)
    np.testing.assert_allclose(np.std(relative), 1, rtol=0.02)
    assert abs(np.corrcoef(relative.ravel(), ((ranges_of(scan) - true) / sigma).ravel())[0, 1]) < 4 / np.sqrt(true.size)


def test_grazing_returns_are_lost_as_often_as_the_sensor_says() -> None:
    """Bands of 5 degrees of a floor seen flat; 4 standard errors of the share."""
    camera = replace(FAR, range_max=1e4, grazing_start=np.deg2rad(55), grazing_end=np.deg2rad(75))
    view = orbit_pose(np.zeros(3), 0.0, np.deg2rad(25), 1.0)
    lost = np.isnan(ranges_of(capture(Scene(), view, camera, rng=rng(6), effects=Effects().without("jitter")))).ravel()
    angle = np.rad2deg(np.arccos(true_hits(Scene(), view, camera).cosine))
    for low in range(45, 85, 5):
        band = (angle >= low) & (angle < low + 5)
        expected = np.clip((angle[band] - 55) / 20, 0, 1)
        assert band.sum() > 500
        slack = 4 * np.sqrt(max(np.mean(expected * (1 - expected)), 1e-9) / band.sum())
        assert abs(lost[band].mean() - expected.mean()) <= slack


def test_weak_returns_are_lost_around_the_weakest_amplitude() -> None:
    """Half of them right at it, none well above, all well below, and never more of the brighter ones."""
    camera = cropped(replace(FAR, weakest=0.1), 61, 61)  # 5 degrees to each side: amplitudes within 2 %
    shares = []
    for strength in (0.6, 0.8, 0.9, 1.0, 1.1, 1.2, 1.5):
        scene = only_plane(flat_target(1.0), 0.1 * strength)
        try:
            image = ranges_of(capture(scene, EYE, camera, rng=rng(), effects=Effects.only("loss")))
            shares.append(float(np.isnan(image).mean()))
        except ScanError:
            shares.append(1.0)
    assert shares[0] == 1
    assert shares[-1] == 0
    assert abs(shares[3] - 0.5) < 0.05  # 0.8 % by chance, 2 % of amplitude are 4 % of the ramp
    assert shares == sorted(shares, reverse=True)
    kept = ranges_of(capture(only_plane(flat_target(1.0), 0.05), EYE, camera, rng=rng(), effects=Effects.only("noise")))
    assert np.isfinite(kept).all()  # the effect is switched off


def test_the_amplitude_of_a_lost_return_stays() -> None:
    """It was too little to be trusted, not nothing."""
    camera = replace(FAR, grazing_start=np.deg2rad(30), grazing_end=np.deg2rad(70))
    scan = capture(only_plane(flat_target(1.0, np.deg2rad(50))), EYE, camera, rng=rng(), effects=Effects.only("loss"))
    lost = np.isnan(ranges_of(scan))
    assert 0.2 < lost.mean() < 0.8
    assert scan.amplitude is not None
    assert np.all(scan.amplitude[lost] > 0)


@pytest.mark.parametrize("beyond", [0.3, 1.0, 1.7])
def test_a_wall_beyond_the_unambiguous_range_comes_back_near(beyond: float) -> None:
    """Every ray by itself, exactly: r becomes r - 2 m."""
    camera = cropped(replace(FAR, unambiguous=2.0, range_max=1.95), 61, 61)
    scene = only_plane(flat_target(2.0 + beyond))
    true = plane_ranges(flat_target(2.0 + beyond), camera)
    image = ranges_of(capture(scene, EYE, camera, rng=rng(), effects=Effects.only("wrap")))
    np.testing.assert_allclose(image, true - 2.0, atol=1e-9)
    with pytest.raises(ScanError):
        capture(scene, EYE, camera, rng=rng(), effects=Effects.only())


def test_within_the_unambiguous_range_nothing_wraps_and_infinity_is_never_reached() -> None:
    for unambiguous in (2.5, np.inf):
        camera = replace(FAR, unambiguous=unambiguous)
        image = ranges_of(capture(only_plane(flat_target(1.5)), EYE, camera, rng=rng(), effects=Effects.only("wrap")))
        np.testing.assert_allclose(image, plane_ranges(flat_target(1.5), camera), rtol=1e-12)


@settings(max_examples=10)
@given(st.floats(0.001, 0.05), st.floats(0, 1.2))
def test_ranges_are_multiples_of_the_step_the_nearest_ones(step: float, theta: float) -> None:
    camera = cropped(replace(FAR, step=step), 41, 31)
    target = flat_target(1.3, theta)
    image = ranges_of(capture(only_plane(target), EYE, camera, rng=rng(), effects=Effects.only("quantisation")))
    np.testing.assert_allclose(image / step, np.rint(image / step), atol=1e-9)
    assert np.abs(image - plane_ranges(target, camera)).max() <= step / 2 + 1e-12


def test_a_step_that_grows_with_range_leaves_gaps_between_the_values() -> None:
    """The disparity camera reports few values, a step apart (docs/cameras.md: 0.00285 r^2): 2.9 to 25 mm from 1 to 3 m."""
    image = ranges_of(
        capture(Scene(), orbit_pose(np.zeros(3), 0, 0.8, 1.5), XTION, rng=rng(), effects=Effects.only("quantisation"))
    )
    values = np.unique(np.round(image[np.isfinite(image)], 9))
    between = 1 / 0.00285 * (1 / values[0] - 1 / values[-1])  # how many steps lie between the ends
    assert len(values) < 1.2 * between
    gaps, middles = np.diff(values), (values[1:] + values[:-1]) / 2
    inner = slice(1, -1)  # 10 %: the step changes by up to 2 % from one value to the next; the mean of 1 / r is not 1 / mean
    np.testing.assert_allclose(gaps[inner], XTION.quantum(middles[inner]), rtol=0.1)


def test_a_step_that_grows_with_range_is_no_more_than_half_off() -> None:
    image = ranges_of(capture(only_plane(flat_target(2.0, 0.5)), EYE, XTION, rng=rng(), effects=Effects.only("quantisation")))
    true = plane_ranges(flat_target(2.0, 0.5), XTION)
    error = np.abs(image - true) / XTION.quantum(true)
    assert np.nanmax(error) < 0.51  # the step itself grows by 1 % over half a step
    np.testing.assert_allclose(np.nanstd(image - true) / np.sqrt(np.mean(XTION.quantum(true) ** 2) / 12), 1, rtol=0.15)


@settings(max_examples=10)
@given(st.floats(0.0005, 0.01), st.floats(0.1, 0.8))
def test_the_wiggle_is_a_sine_of_its_amplitude_and_period(amplitude: float, period: float) -> None:
    camera = replace(FAR, wiggle=amplitude, wiggle_period=period)
    target = flat_target(1.0, np.deg2rad(45))
    true = plane_ranges(target, camera)
    wrong = ranges_of(capture(only_plane(target), EYE, camera, rng=rng(), effects=Effects.only("wiggle"))) - true
    assert np.ptp(true) > period  # a whole period is in view
    np.testing.assert_allclose([wrong.min(), wrong.max()], [-amplitude, amplitude], rtol=1e-3)
    np.testing.assert_allclose(wrong, amplitude * np.sin(2 * np.pi * true / period), atol=1e-7)


def test_the_wiggle_repeats_after_its_period_and_is_off_for_a_perfectly_calibrated_camera() -> None:
    camera = cropped(replace(FAR, wiggle=0.004, wiggle_period=0.4), 11, 11)
    centre = [
        ranges_of(capture(only_plane(flat_target(z)), EYE, camera, rng=rng(), effects=Effects.only("wiggle")))[5, 5] - z
        for z in (1.05, 1.45, 1.25)
    ]
    np.testing.assert_allclose(centre[1], centre[0], atol=1e-7)
    np.testing.assert_allclose(centre[2], -centre[0], atol=1e-7)
    scene = only_plane(flat_target(1.05))
    calibrated = ranges_of(capture(scene, EYE, camera.without_systematic(), rng=rng(), effects=Effects.only("wiggle")))
    np.testing.assert_allclose(calibrated[5, 5], 1.05, rtol=1e-12)


FLYING: list[tuple[list[list[float]], list[list[int]]]] = [
    ([[1, 1, 2, 1, 1]], [[0, 0, 1, 0, 0]]),  # alone, in a row
    ([[1, 1, 1.02, 1, 1]], [[0, 0, 0, 0, 0]]),  # less than 3 % off
    ([[1, 1, 1.5, 2, 2]], [[0, 0, 1, 0, 0]]),  # half way between two surfaces
    ([[1, 1, 2, 2, 2]], [[0, 0, 0, 0, 0]]),  # an edge
    ([[1, np.nan, 2, 1, 1]], [[0, 0, 0, 0, 0]]),  # next to no return there is nothing to differ from
    ([[2, 1, 1]], [[0, 0, 0]]),  # nor at the border
    ([[1], [1], [2], [1], [1]], [[0], [0], [1], [0], [0]]),  # in a column
    ([[1, 1, 1], [1, 2, 1], [1, 1, 1]], [[0, 0, 0], [0, 1, 0], [0, 0, 0]]),
    ([[1, 2, 1], [1, 2, 1], [1, 2, 1]], [[0, 1, 0], [0, 1, 0], [0, 1, 0]]),  # a wire: one line is enough
    ([[1, 1, 1], [2, 2, 1], [2, 2, 1]], [[0, 0, 0], [0, 0, 0], [0, 0, 0]]),  # a corner
    ([[1.0, 1.04, 1.08]], [[0, 1, 0]]),  # a slope steeper than 3 % a pixel
    ([[1.0, 1.0325, 1.06]], [[0, 0, 0]]),  # the threshold is a share of its own range: 3.1 % before it, 2.7 % after
]


@pytest.mark.parametrize(("image", "expected"), FLYING)
def test_the_cameras_own_filter_on_small_images(image: list[list[float]], expected: list[list[int]]) -> None:
    np.testing.assert_array_equal(flying(np.array(image, dtype=float), 0.03), np.array(expected, dtype=bool))


def test_the_filter_takes_most_flying_pixels_and_no_others() -> None:
    """A plate half a metre before a wall: what lies between the two after mixing alone is gone with the filter on."""
    camera = cropped(replace(FAR, flying_filter=0.03), 61, 201)
    scene = Scene((plate(1.0),), planes=(flat_target(1.5),))
    mixed, filtered = (
        capture(scene, EYE, camera, rng=rng(), effects=Effects.only(*names)).organised()[..., 2]
        for names in (("mixing",), ("mixing", "filtering"))
    )
    between = (mixed > 1.1) & (mixed < 1.4)
    assert between.sum() > 60
    assert np.isnan(filtered[between]).mean() > 0.9
    lost = mixed[np.isnan(filtered)]
    assert np.minimum(np.abs(lost - 1.0), np.abs(lost - 1.5)).min() > 0.01  # only what was mixed
    np.testing.assert_array_equal(filtered[np.isfinite(filtered)], mixed[np.isfinite(filtered)])


def test_systematic_errors_are_drawn_as_the_sensor_says() -> None:
    """4,000 cameras: 1.1 % in the spread, times four."""
    chance = rng()
    errors = [draw_range_error(KINECT, rng=chance) for _ in range(4000)]
    scale, offset = np.array([e.scale for e in errors]), np.array([e.offset for e in errors])
    np.testing.assert_allclose([scale.std(), offset.std()], [KINECT.scale_sd, KINECT.offset_sd], rtol=0.05)
    assert abs(np.corrcoef(scale, offset)[0, 1]) < 4 / np.sqrt(4000)
    assert draw_range_error(KINECT.without_systematic(), rng=chance) == RangeError()


def test_the_noise_never_makes_an_amplitude_negative() -> None:
    camera = replace(FAR, noise_per_metre=2.0, range_min=0.0)
    amplitude: Array | None = capture(
        only_plane(flat_target(1.0)), EYE, camera, rng=rng(), effects=Effects.only("noise")
    ).amplitude
    assert amplitude is not None
    assert amplitude.min() == 0

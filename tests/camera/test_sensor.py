"""How well a camera measures: noise, edges and loss over range and incidence."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewgain.camera import PRESETS, Intrinsics, Sensor, sensor
from viewgain.errors import ConfigError

CAMERA = Sensor(
    name="test", intrinsics=Intrinsics(width=100, height=80, fx=100.0, fy=100.0, cx=49.5, cy=39.5), noise_constant=0.001,
    noise_per_metre=0.005, noise_per_square_metre=0.002, lateral_px=0.5,
)  # fmt: skip
NUMBERS = sorted({field.name for field in fields(Sensor)} - {"name", "kind", "intrinsics"})
presets = st.sampled_from(PRESETS).map(sensor)
cosines = st.floats(0, 1)
shares = st.floats(0, 1)


def range_at(camera: Sensor, share: float) -> float:
    return camera.range_min + share * (camera.range_max - camera.range_min)


def least_noisy_range(camera: Sensor) -> float:
    """The range at which the polynomial of the noise is least; beyond it the noise grows."""
    if camera.noise_per_square_metre <= 0:
        return 0.0
    return max(0.0, -camera.noise_per_metre / (2 * camera.noise_per_square_metre))


@given(presets, shares, cosines)
def test_noise_is_positive_over_the_whole_range(camera: Sensor, share: float, cosine: float) -> None:
    sigma = camera.range_sigma(np.array([range_at(camera, share)]), np.array([cosine]))
    assert sigma.shape == (1,)
    assert 1e-4 < sigma[0] < 1.0  # no camera here is better than 0.1 mm, and none worse than a metre


@given(presets, shares, shares)
def test_head_on_noise_grows_with_range_beyond_the_least_noisy_one(camera: Sensor, first: float, second: float) -> None:
    near, far = sorted(max(range_at(camera, share), least_noisy_range(camera)) for share in (first, second))
    sigma = camera.range_sigma(np.array([near, far]), np.ones(2))
    assert sigma[0] <= sigma[1] * (1 + 1e-12)


def test_the_least_noisy_ranges_are_those_of_the_published_formulas() -> None:
    assert least_noisy_range(sensor("xtion")) == pytest.approx(0.4, rel=1e-12)
    assert least_noisy_range(sensor("kinect_v2")) == pytest.approx(0.5 / 0.6, rel=1e-12)
    others = [least_noisy_range(sensor(name)) for name in PRESETS if name not in ("xtion", "kinect_v2")]
    assert others == [0.0] * len(others)


@given(presets, shares, cosines, cosines)
def test_noise_grows_with_the_angle_of_incidence(camera: Sensor, share: float, first: float, second: float) -> None:
    steep, grazing = max(first, second), min(first, second)
    sigma = camera.range_sigma(np.full(2, range_at(camera, share)), np.array([steep, grazing]))
    assert sigma[0] <= sigma[1] * (1 + 1e-12)


def test_noise_is_the_polynomial_head_on_and_the_jitter_on_a_slope() -> None:
    head_on = CAMERA.range_sigma(np.array([0.0, 1.0, 2.0]), np.ones(3))
    np.testing.assert_allclose(head_on, [0.001, 0.008, 0.019], rtol=1e-12)
    flat = replace(CAMERA, noise_constant=0.0, noise_per_metre=0.0, noise_per_square_metre=0.0, jitter_px=0.5)
    sixty = flat.range_sigma(np.array([2.0]), np.array([0.5]))
    np.testing.assert_allclose(sixty, [0.5 / 100 * 2 * np.tan(np.pi / 3)], rtol=1e-12)
    np.testing.assert_allclose(CAMERA.range_sigma(np.array([1.0]), np.array([0.25])), [0.008 / 0.5], rtol=1e-12)


def test_jitter_adds_in_quadrature() -> None:
    ranges, cosine = np.array([0.5, 1.0, 3.0]), np.array([0.9, 0.5, 0.2])
    slope = 0.3 / 100 * ranges * np.tan(np.arccos(cosine))
    expected = np.sqrt(CAMERA.range_sigma(ranges, cosine) ** 2 + slope**2)
    np.testing.assert_allclose(replace(CAMERA, jitter_px=0.3).range_sigma(ranges, cosine), expected, rtol=1e-12)


@given(st.floats(0, 2), st.floats(0.2, 1))
def test_the_polynomial_grows_as_the_given_power_of_the_incidence(power: float, cosine: float) -> None:
    sigma = replace(CAMERA, noise_incidence_power=power).range_sigma(np.ones(1), np.array([cosine]))
    np.testing.assert_allclose(sigma, 0.008 / cosine**power, rtol=1e-12)


@given(presets, shares, cosines, st.floats(0, 5), st.floats(0, 5))
def test_the_lateral_noise_of_edges_is_never_in_the_range_noise(
    camera: Sensor, share: float, cosine: float, px: float, grazing_px: float
) -> None:
    ranges, seen = np.array([range_at(camera, share)]), np.array([cosine])
    other = replace(camera, lateral_px=px, lateral_grazing_px=grazing_px)
    assert other.range_sigma(ranges, seen) == camera.range_sigma(ranges, seen)


def test_lateral_noise_is_the_head_on_one_and_twice_that_at_45_degrees_if_both_terms_are_equal() -> None:
    camera = replace(CAMERA, lateral_px=0.4, lateral_grazing_px=0.4)
    angles = np.deg2rad([0.0, 45.0, 60.0])
    np.testing.assert_allclose(camera.lateral_sigma(np.cos(angles)), [0.4, 0.8, 1.2], rtol=1e-12)
    np.testing.assert_allclose(CAMERA.lateral_sigma(np.cos(angles)), 0.5, rtol=1e-12)


# Nguyen et al. 2012 measured from 10 to 60 degrees; the formula of Fankhauser et al. 2015 is compared over the same angles.
angles_measured = st.floats(np.deg2rad(10), np.deg2rad(60))


@given(st.floats(0.5, 3.5), angles_measured)
def test_the_xtion_is_nguyens_formula(z: float, angle: float) -> None:
    grazing = angle / (np.pi / 2 - angle)
    axial = 0.0012 + 0.0019 * (z - 0.4) ** 2 + 0.0001 / np.sqrt(z) * grazing**2
    camera, cosine = sensor("xtion"), np.array([np.cos(angle)])
    np.testing.assert_allclose(camera.range_sigma(np.array([z]), cosine), axial, rtol=1e-9)
    np.testing.assert_allclose(camera.lateral_sigma(cosine), 0.8 + 0.035 * grazing, rtol=1e-9)


@given(st.floats(0.5, 4.5), angles_measured)
def test_the_kinect_v2_is_fankhausers_formula(z: float, angle: float) -> None:
    millimetres = 1.5 - 0.5 * z + 0.3 * z**2 + 0.1 * z**1.5 * angle**2 / (np.pi / 2 - angle) ** 2
    sigma = sensor("kinect_v2").range_sigma(np.array([z]), np.array([np.cos(angle)]))
    np.testing.assert_allclose(sigma, 1e-3 * millimetres, rtol=1e-9)


@pytest.mark.parametrize("name", PRESETS)
def test_the_residual_wiggle_is_small_against_the_noise(name: str) -> None:
    """The published noise is the total of what was seen; a sine of amplitude a has the standard deviation a / sqrt(2)."""
    camera = sensor(name)
    ranges = np.linspace(camera.range_min, camera.range_max, 50)
    share = camera.wiggle / np.sqrt(2) / camera.range_sigma(ranges, np.ones(50))
    assert np.median(share) < 0.5
    if name == "kinect_v2":
        assert share.max() < 0.2


@given(presets, shares, cosines, st.floats(0.02, 1), st.floats(0.02, 1))
def test_with_half_the_light_noise_is_larger_by_the_square_root_of_two(
    camera: Sensor, share: float, cosine: float, first: float, second: float
) -> None:
    ranges, seen = np.array([range_at(camera, share)]), np.array([cosine])
    one, two = (camera.range_sigma(ranges, seen, reflectivity=value) for value in (first, second))
    ratio = np.sqrt(second / first) if camera.kind == "tof" else 1.0
    np.testing.assert_allclose(one / two, ratio, rtol=1e-9)
    stated = camera.range_sigma(ranges, seen, reflectivity=np.array([camera.noise_reflectivity]))
    np.testing.assert_allclose(stated, camera.range_sigma(ranges, seen), rtol=1e-12)


def test_reflectivity_leaves_the_jitter_alone_and_black_stays_finite() -> None:
    flat = replace(CAMERA, noise_constant=0.0, noise_per_metre=0.0, noise_per_square_metre=0.0, jitter_px=0.5)
    ranges, cosine = np.ones(2), np.array([0.5, 0.9])
    np.testing.assert_array_equal(flat.range_sigma(ranges, cosine, reflectivity=0.1), flat.range_sigma(ranges, cosine))
    assert np.all(np.isfinite(CAMERA.range_sigma(ranges, cosine, reflectivity=0.0)))


def test_beyond_the_floor_of_the_cosine_the_noise_stays_as_it_is() -> None:
    camera = replace(CAMERA, noise_grazing=1e-4, lateral_grazing_px=0.1)
    cosine = np.array([0.15, 0.05, 0.0])
    for sigma in (camera.range_sigma(np.ones(3), cosine), camera.lateral_sigma(cosine)):
        np.testing.assert_allclose(sigma, sigma[0], rtol=1e-12)


def test_a_negative_power_of_the_range_stays_finite_at_the_camera() -> None:
    camera = replace(CAMERA, noise_grazing=1e-4, noise_grazing_range_power=-0.5)
    assert np.all(np.isfinite(camera.range_sigma(np.zeros(2), np.array([1.0, 0.3]))))


@given(presets, cosines, cosines)
def test_loss_is_a_probability_that_grows_with_the_angle(camera: Sensor, first: float, second: float) -> None:
    steep, grazing = camera.loss(np.array([max(first, second), min(first, second)]))
    assert 0 <= steep <= grazing <= 1


def test_loss_is_a_ramp_between_the_two_angles() -> None:
    camera = replace(CAMERA, grazing_start=np.deg2rad(60), grazing_end=np.deg2rad(80))
    angles = np.deg2rad([0, 60, 65, 70, 80, 90])
    np.testing.assert_allclose(camera.loss(np.cos(angles)), [0, 0, 0.25, 0.5, 1, 1], atol=1e-12)


@given(st.floats(0, 0.01), st.floats(0, 0.01), st.floats(0, 10))
def test_the_quantum_is_the_step_and_its_growth(step: float, growth: float, distance: float) -> None:
    camera = replace(CAMERA, step=step, step_per_square_metre=growth)
    np.testing.assert_allclose(camera.quantum(np.array([distance])), [step + growth * distance**2], rtol=1e-12)


def test_the_quantum_of_the_presets() -> None:
    # Khoshelham 2011: 2.85e-5 z^2 cm for z in cm.
    np.testing.assert_allclose(sensor("xtion").quantum(np.array([1.0, 3.0])), 2.85e-5 * np.array([100, 300.0]) ** 2 / 100)
    np.testing.assert_array_equal(sensor("pico_flexx").quantum(np.array([1.0])), [0.0])
    np.testing.assert_array_equal(sensor("kinect_v2").quantum(np.array([0.5, 4.5])), [0.001, 0.001])


def test_wavelength_is_metres_of_range_per_turn() -> None:
    assert replace(CAMERA, modulation_hz=20e6).wavelength == pytest.approx(7.49481145, rel=1e-9)
    assert CAMERA.wavelength == np.inf
    assert replace(CAMERA, modulation_hz=20e6, kind="structured_light").wavelength == np.inf


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_measures_no_farther_than_its_phases_are_unambiguous(name: str) -> None:
    camera = sensor(name)
    assert camera.range_max <= camera.unambiguous
    if np.isfinite(camera.unambiguous):  # the common divisor of the frequencies: a whole number of turns, up to the file's digits
        turns = camera.unambiguous / camera.wavelength
        assert turns == pytest.approx(round(turns), abs=2e-3 * turns)


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_sees_a_white_surface_over_its_whole_range(name: str) -> None:
    camera = sensor(name)
    assert 1 / camera.range_max**2 > camera.weakest > 0


@pytest.mark.parametrize("name", ["azure_kinect_nfov", "azure_kinect_wfov", "femto_nfov", "femto_wfov"])
def test_the_azure_kinect_keeps_its_17_mm_down_to_15_per_cent(name: str) -> None:
    camera = sensor(name)
    sigma = camera.range_sigma(np.linspace(camera.range_min, camera.range_max, 20), np.ones(20), reflectivity=0.15)
    assert sigma.max() <= 0.017
    assert sigma.max() == pytest.approx(0.017, rel=0.01)  # the file's coefficients have two digits


def test_perfect_calibration_changes_the_systematic_error_only() -> None:
    camera = replace(CAMERA, scale_sd=0.01, offset_sd=0.02, wiggle=0.003)
    perfect = camera.without_systematic()
    assert (perfect.scale_sd, perfect.offset_sd, perfect.wiggle) == (0.0, 0.0, 0.0)
    assert replace(perfect, scale_sd=0.01, offset_sd=0.02, wiggle=0.003) == camera


def test_the_calibrated_cameras_keep_the_numbers_that_their_error_bars_rest_on() -> None:
    pico, xtion = sensor("pico_flexx"), sensor("xtion")
    assert (pico.intrinsics.width, pico.intrinsics.height) == (224, 171)
    np.testing.assert_allclose(pico.range_sigma(np.array([2.0]), np.ones(1)), 0.01, rtol=1e-12)  # half of 1 % of 2 m
    assert (xtion.intrinsics.width, xtion.intrinsics.height) == (640, 480)
    for camera, scale_sd, lateral_px in ((pico, 0.003, 0.3), (xtion, 0.005, 0.8)):
        assert (camera.scale_sd, camera.offset_sd, camera.lateral_px) == (scale_sd, 0.003, lateral_px)
        assert (camera.edge_sd_px, camera.lost_edge_sd_px) == (0.07, 0.3)
        np.testing.assert_allclose(np.rad2deg([camera.grazing_start, camera.grazing_end]), [70, 85], rtol=1e-12)
    plain = Sensor(name="plain", intrinsics=pico.intrinsics)
    ranges, cosine = np.array([0.3, 1.0, 4.0]), np.array([1.0, 0.6, 0.2])
    np.testing.assert_array_equal(plain.range_sigma(ranges, cosine), pico.range_sigma(ranges, cosine))


@pytest.mark.parametrize("field", NUMBERS)
@pytest.mark.parametrize("value", [np.nan, -np.inf, "1", True, [1.0]])
def test_every_number_must_be_one(field: str, value: object) -> None:
    with pytest.raises(ConfigError, match=rf"camera test: .*{field}"):
        replace(CAMERA, **{field: value})


@pytest.mark.parametrize("field", sorted(set(NUMBERS) - {"unambiguous"}))
def test_only_the_unambiguous_range_may_be_infinite(field: str) -> None:
    replace(CAMERA, unambiguous=np.inf)
    with pytest.raises(ConfigError, match=rf"camera test: .*{field}"):
        replace(CAMERA, **{field: np.inf})


@pytest.mark.parametrize(
    "change",
    [
        {"range_min": -0.1}, {"range_min": 4.0, "range_max": 4.0}, {"grazing_start": 0.0},
        {"grazing_start": 1.5, "grazing_end": 1.4}, {"grazing_end": 1.6}, {"kind": "stereo"}, {"jitter_px": -0.1},
        {"lateral_px": -0.1}, {"noise_reflectivity": 0.0}, {"wiggle_period": 0.0}, {"modulation_hz": 0.0}, {"unambiguous": 0.0},
        {"noise_incidence_power": -1.0}, {"weakest": -1.0}, {"footprint_px": -1.0}, {"flying_filter": -0.1}, {"step": -0.001},
        {"scale_sd": -0.1}, {"noise_constant": -0.001}, {"noise_per_metre": -0.02}, {"noise_per_square_metre": -0.01},
        {"noise_constant": 0.001, "noise_per_metre": -0.01, "noise_per_square_metre": 0.005},
    ],
)  # fmt: skip
def test_a_camera_that_makes_no_sense_is_refused_by_name(change: dict[str, object]) -> None:
    with pytest.raises(ConfigError, match=r"^camera test: ") as caught:
        replace(CAMERA, **change)
    assert "\n" not in str(caught.value)


steps = st.one_of(st.just(0.0), st.floats(1e-4, 0.01))


@given(steps, steps, st.lists(st.floats(0.3, 6), min_size=1, max_size=20))
def test_rounding_moves_by_half_a_quantum_at_most_and_once_is_enough(step: float, growth: float, ranges: list[float]) -> None:
    """10 % more for a quantum that changes from one value to the next."""
    camera, exact = replace(CAMERA, step=step, step_per_square_metre=growth), np.array(ranges)
    once = camera.rounded(exact)
    assert np.all(np.abs(once - exact) <= 0.55 * np.maximum(camera.quantum(exact), camera.quantum(once)) + 1e-12)
    np.testing.assert_allclose(camera.rounded(once), once, rtol=1e-9)


@pytest.mark.parametrize(("step", "growth"), [(0.003, 0.0), (0.0, 0.00285), (0.002, 0.001)])
def test_neighbouring_values_are_a_quantum_apart(step: float, growth: float) -> None:
    """2 %: the quantum at the middle of two values stands for that between them."""
    camera = replace(CAMERA, step=step, step_per_square_metre=growth)
    values = np.unique(np.round(camera.rounded(np.linspace(0.5, 3, 200_001)), 9))
    np.testing.assert_allclose(np.diff(values)[1:-1], camera.quantum((values[1:] + values[:-1]) / 2)[1:-1], rtol=0.02)


@pytest.mark.parametrize("name", ["pico_flexx", "kinect_v2", "xtion"])
def test_a_noisier_camera_has_as_much_more_noise_at_every_range_and_incidence(name: str) -> None:
    camera = replace(sensor(name), jitter_px=0.0)
    ranges, cosine = np.array([0.4, 1.0, 3.0]), np.array([1.0, 0.7, 0.3])
    louder = camera.noisier(2.5)
    assert louder.range_sigma(ranges, cosine) == pytest.approx(2.5 * camera.range_sigma(ranges, cosine))
    assert louder.noisier(0.4).range_sigma(ranges, cosine) == pytest.approx(camera.range_sigma(ranges, cosine))
    assert sensor(name).noisier(2.5).lateral_sigma(cosine) == pytest.approx(sensor(name).lateral_sigma(cosine))

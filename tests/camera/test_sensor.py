"""How well a camera measures: noise and loss over range and incidence, and the cameras known by name."""

from dataclasses import replace

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
presets = st.sampled_from(sorted(PRESETS)).map(sensor)
cosines = st.floats(0, 1)


@given(presets, st.floats(0, 1), st.floats(0, 1), cosines)
def test_noise_grows_with_range(camera: Sensor, near: float, far: float, cosine: float) -> None:
    near, far = sorted(camera.range_min + np.array([near, far]) * (camera.range_max - camera.range_min))
    sigma = camera.range_sigma(np.array([near, far]), np.full(2, cosine))
    assert 0 < sigma[0] <= sigma[1] * (1 + 1e-12)


@given(presets, st.floats(0.5, 3.5), cosines, cosines)
def test_noise_grows_with_the_angle_of_incidence(camera: Sensor, distance: float, first: float, second: float) -> None:
    steep, grazing = max(first, second), min(first, second)
    sigma = camera.range_sigma(np.full(2, distance), np.array([steep, grazing]))
    assert sigma[0] <= sigma[1] * (1 + 1e-12)


def test_noise_is_the_polynomial_head_on_and_the_lateral_noise_on_a_slope() -> None:
    head_on = CAMERA.range_sigma(np.array([0.0, 1.0, 2.0]), np.ones(3))
    np.testing.assert_allclose(head_on, [0.001, 0.008, 0.019], rtol=1e-12)
    flat = replace(CAMERA, noise_constant=0.0, noise_per_metre=0.0, noise_per_square_metre=0.0)
    sixty = flat.range_sigma(np.array([2.0]), np.array([0.5]))
    np.testing.assert_allclose(sixty, [0.5 / 100 * 2 * np.tan(np.pi / 3)], rtol=1e-12)
    still = replace(CAMERA, lateral_px=0.0)
    np.testing.assert_allclose(still.range_sigma(np.array([1.0]), np.array([0.25])), [0.008 / 0.5], rtol=1e-12)


def test_beyond_the_floor_of_the_cosine_the_noise_stays_as_it_is() -> None:
    sigma = CAMERA.range_sigma(np.ones(3), np.array([0.15, 0.05, 0.0]))
    np.testing.assert_allclose(sigma, sigma[0], rtol=1e-12)


@given(presets, cosines, cosines)
def test_loss_is_a_probability_that_grows_with_the_angle(camera: Sensor, first: float, second: float) -> None:
    steep, grazing = camera.loss(np.array([max(first, second), min(first, second)]))
    assert 0 <= steep <= grazing <= 1


def test_loss_is_a_ramp_between_the_two_angles() -> None:
    camera = replace(CAMERA, grazing_start=np.deg2rad(60), grazing_end=np.deg2rad(80))
    angles = np.deg2rad([0, 60, 65, 70, 80, 90])
    np.testing.assert_allclose(camera.loss(np.cos(angles)), [0, 0, 0.25, 0.5, 1, 1], atol=1e-12)


def test_perfect_calibration_changes_the_systematic_error_only() -> None:
    camera = replace(CAMERA, scale_sd=0.01, offset_sd=0.02)
    perfect = camera.without_systematic()
    assert (perfect.scale_sd, perfect.offset_sd) == (0.0, 0.0)
    assert replace(perfect, scale_sd=0.01, offset_sd=0.02) == camera


def test_the_presets_have_the_numbers_of_their_sources() -> None:
    pico, xtion = sensor("pico_flexx"), sensor("xtion")
    assert (pico.intrinsics.width, pico.intrinsics.height) == (224, 171)
    np.testing.assert_allclose(pico.range_sigma(np.array([2.0]), np.ones(1)), 0.01, rtol=1e-12)  # half of 1 % of 2 m
    assert (xtion.intrinsics.width, xtion.intrinsics.height) == (640, 480)
    depth = np.array([0.5, 1.0, 2.0, 3.5])
    # Nguyen et al. 2012; the preset rounds the expanded polynomial to 1e-5, times at most 3.5 m.
    np.testing.assert_allclose(xtion.range_sigma(depth, np.ones(4)), 0.0012 + 0.0019 * (depth - 0.4) ** 2, atol=4e-5)


@pytest.mark.parametrize("name", sorted(PRESETS))
def test_a_preset_knows_its_own_name(name: str) -> None:
    assert sensor(name).name == name


def test_an_unknown_camera_is_refused_with_the_names_of_the_known_ones() -> None:
    with pytest.raises(ConfigError) as caught:
        sensor("kinect_v9")
    assert "'kinect_v9'" in str(caught.value)
    assert all(name in str(caught.value) for name in PRESETS)


@pytest.mark.parametrize(
    "change",
    [
        {"range_min": -0.1}, {"range_min": 4.0, "range_max": 4.0}, {"range_max": np.nan}, {"grazing_start": 0.0},
        {"grazing_start": 1.5, "grazing_end": 1.4}, {"grazing_end": 1.6}, {"grazing_end": np.nan},
    ],
)  # fmt: skip
def test_a_camera_that_makes_no_sense_is_refused_by_name(change: dict[str, float]) -> None:
    with pytest.raises(ConfigError, match="camera test"):
        replace(CAMERA, **change)

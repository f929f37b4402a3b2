"""A camera written to TOML is the same camera when it is read back."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewgain.camera import PRESETS, Sensor, camera_text, sensor

scales = st.floats(-0.1, 0.1)
offsets = st.floats(-0.1, 0.1)
ranges = st.lists(st.floats(0.05, 8), min_size=1, max_size=5).map(np.array)


def read_back(camera: Sensor, folder: Path, comment: str = "") -> Sensor:
    path = folder / "written.toml"
    path.write_text(camera_text(camera, comment=comment), encoding="utf-8")
    return sensor(str(path))


def assert_same(one: Sensor, other: Sensor) -> None:
    for field in fields(Sensor):
        ours, theirs = getattr(one, field.name), getattr(other, field.name)
        if field.name in ("name", "kind") or ours is None:
            assert ours == theirs
        elif field.name == "intrinsics":
            assert one.intrinsics == other.intrinsics
        else:
            assert theirs == pytest.approx(ours, rel=1e-12), field.name


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_comes_back_the_same(name: str, tmp_path: Path) -> None:
    assert_same(sensor(name), read_back(sensor(name), tmp_path))


@pytest.mark.parametrize("name", PRESETS)
def test_what_calibration_and_coverage_add_comes_back_too(name: str, tmp_path: Path) -> None:
    camera = replace(sensor(name).corrected(0.004, -0.0021, 1e-5, 3e-4), spread=1.3)
    assert_same(camera, read_back(camera, tmp_path, comment="two lines\nof comment"))


def test_a_lens_with_distortion_and_a_name_in_quotes_come_back(tmp_path: Path) -> None:
    lens = replace(sensor("pico_flexx").intrinsics, distortion=(0.1, -0.02, 0.001, 0.0, 0.003))
    camera = replace(sensor("pico_flexx"), name='the "left" one \\ arm', intrinsics=lens)
    assert_same(camera, read_back(camera, tmp_path))


def test_every_field_of_a_sensor_is_written() -> None:
    """A new field without a key would be lost by calibrating."""
    text = camera_text(sensor("kinect_v2"))
    assert text.count(" = ") >= len(fields(Sensor)) - 1  # the image is a section


@given(scales, offsets, ranges)
def test_true_ranges_undo_a_known_error(scale: float, offset: float, true: np.ndarray) -> None:
    camera = replace(sensor("pico_flexx"), scale=scale, offset=offset)
    np.testing.assert_allclose(camera.true_ranges(true * (1 + scale) + offset), true, atol=1e-12)


def test_without_a_known_error_ranges_stay_as_they_are() -> None:
    measured = np.array([0.3, 1.0])
    assert sensor("pico_flexx").true_ranges(measured) is measured


@given(scales, offsets, scales, offsets, ranges)
def test_correcting_twice_takes_off_one_after_the_other(
    scale: float, offset: float, further_scale: float, further_offset: float, measured: np.ndarray
) -> None:
    plain = sensor("pico_flexx")
    first = plain.corrected(scale, offset, 0.001, 0.001)
    both = first.corrected(further_scale, further_offset, 0.0005, 0.0007)
    rest = plain.corrected(further_scale, further_offset, 0.0005, 0.0007)
    np.testing.assert_allclose(both.true_ranges(measured), rest.true_ranges(first.true_ranges(measured)), atol=1e-12)
    assert (both.scale_sd, both.offset_sd) == (0.0005, 0.0007)


@given(scales, offsets)
def test_correcting_by_nothing_changes_only_what_is_unknown(scale: float, offset: float) -> None:
    camera = sensor("pico_flexx").corrected(scale, offset, 0.001, 0.002)
    same = camera.corrected(0.0, 0.0, 0.0005, 0.0007)
    assert (same.scale, same.offset) == pytest.approx((camera.scale, camera.offset), abs=1e-15)
    assert same.without_systematic().scale == same.without_systematic().offset == 0.0

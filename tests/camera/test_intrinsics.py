"""Pixels to rays and back, with and without a lens."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError

LENSES = {
    "none": (),
    "brown4": (-0.28, 0.08, 0.0008, -0.0005),
    "brown5 kinect": (0.0893, -0.2722, 0.0, 0.0, 0.0956),
    "brown5 barrel": (-0.32, 0.12, 0.001, -0.001, -0.02),
    "rational azure": (0.45, 0.05, 0.0001, -0.0001, 0.002, 0.8, 0.15, 0.01),
}
"""Coefficients of the size that real depth cameras report."""


def with_lens(distortion: tuple[float, ...]) -> Intrinsics:
    return Intrinsics(width=64, height=48, fx=55.0, fy=54.0, cx=30.7, cy=24.9, distortion=distortion)


def brown_point(x: float, y: float, k: tuple[float, ...]) -> tuple[float, float]:
    """OpenCV's formula for one point, written out."""
    k1, k2, p1, p2, k3, k4, k5, k6 = (*k, *[0.0] * (8 - len(k)))
    r2 = x**2 + y**2
    radial = (1 + k1 * r2 + k2 * r2**2 + k3 * r2**3) / (1 + k4 * r2 + k5 * r2**2 + k6 * r2**3)
    return (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x**2), y * radial + p1 * (r2 + 2 * y**2) + 2 * p2 * x * y)


@pytest.mark.parametrize("name", LENSES)
@given(x=st.floats(-0.8, 0.8), y=st.floats(-0.8, 0.8))
def test_distortion_is_opencvs_formula(name: str, x: float, y: float) -> None:
    found = with_lens(LENSES[name]).distort(np.array([[x, y]]))
    np.testing.assert_allclose(found[0], brown_point(x, y, LENSES[name]), atol=1e-14)


def ring(field_of_view_deg: float) -> np.ndarray:
    """Directions on the edge of a round field of view."""
    around = np.linspace(0, 2 * np.pi, 60)
    return np.tan(np.deg2rad(field_of_view_deg) / 2) * np.column_stack([np.cos(around), np.sin(around)])


@pytest.mark.parametrize("name", LENSES)
@pytest.mark.parametrize("field_of_view_deg", [30, 60, 80])
def test_undistorting_takes_distorted_directions_back(name: str, field_of_view_deg: float) -> None:
    camera, directions = with_lens(LENSES[name]), ring(field_of_view_deg)
    np.testing.assert_allclose(camera.undistort(camera.distort(directions)), directions, atol=1e-6)


@pytest.mark.parametrize("name", LENSES)
def test_undistorting_is_as_good_as_its_docstring_says_up_to_110_degrees(name: str) -> None:
    camera, directions = with_lens(LENSES[name]), ring(110)
    np.testing.assert_allclose(camera.undistort(camera.distort(directions)), directions, atol=1e-9)


@pytest.mark.parametrize("name", LENSES)
def test_projecting_the_rays_gives_the_pixel_grid(name: str) -> None:
    camera = with_lens(LENSES[name])
    rays = camera.rays()
    assert rays.shape == (48, 64, 2)
    depth = np.random.default_rng(0).uniform(0.3, 4, (48, 64, 1))
    pixels = camera.project(np.concatenate([rays, np.ones((48, 64, 1))], axis=-1) * depth)
    u, v = np.meshgrid(np.arange(64), np.arange(48))
    np.testing.assert_allclose(pixels, np.stack([u, v], axis=-1), atol=1e-4)  # 1e-6 times a focal length of 55


def test_pixel_zero_is_the_centre_of_the_top_left_pixel() -> None:
    camera = Intrinsics(width=4, height=2, fx=2.0, fy=1.0, cx=1.5, cy=0.5)
    np.testing.assert_allclose(camera.rays()[0, 0], [-0.75, -0.5], atol=1e-15)
    np.testing.assert_allclose(camera.project(np.array([0.0, 0.0, 5.0])), [1.5, 0.5], atol=1e-15)
    np.testing.assert_allclose(camera.project(np.array([2.0, -1.0, 2.0])), [3.5, 0.0], atol=1e-15)


@given(st.integers(2, 800), st.integers(2, 800), st.floats(5, 150), st.floats(5, 150))
def test_the_field_of_view_spans_the_outer_edges_of_the_image(
    width: int, height: int, horizontal: float, vertical: float
) -> None:
    camera = Intrinsics.from_field_of_view(width, height, np.deg2rad(horizontal), np.deg2rad(vertical))
    edge = np.array([[np.tan(np.deg2rad(horizontal) / 2), 0, 1], [-np.tan(np.deg2rad(horizontal) / 2), 0, 1]])
    np.testing.assert_allclose(camera.project(edge)[:, 0], [width - 0.5, -0.5], atol=1e-9)
    edge = np.array([[0, np.tan(np.deg2rad(vertical) / 2), 1], [0, -np.tan(np.deg2rad(vertical) / 2), 1]])
    np.testing.assert_allclose(camera.project(edge)[:, 1], [height - 0.5, -0.5], atol=1e-9)


GOOD = {"width": 64, "height": 48, "fx": 50.0, "fy": 50.0, "cx": 31.5, "cy": 23.5}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"width": 0}, "0 x 48 pixels"),
        ({"height": -1}, "64 x -1 pixels"),
        ({"fx": 0.0}, "positive focal"),
        ({"fy": -50.0}, "positive focal"),
        ({"fx": np.nan}, "finite numbers"),
        ({"cx": np.inf}, "finite numbers"),
        ({"cy": np.nan}, "finite numbers"),
        ({"distortion": (0.1, np.nan, 0, 0)}, "finite numbers"),
        ({"distortion": (0.1,)}, "got 1 distortion coefficients, wanted 0, 4, 5 or 8"),
        ({"distortion": (0.0,) * 12}, "got 12 distortion coefficients"),
    ],
)
def test_intrinsics_that_make_no_sense_are_refused(change: dict[str, object], message: str) -> None:
    Intrinsics(**GOOD)
    with pytest.raises(ConfigError, match=message):
        Intrinsics(**{**GOOD, **change})

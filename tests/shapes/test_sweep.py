"""Sweeps and the lines they follow: straight ones are prisms, frames do not spin, bends keep their size."""

from math import pi

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.shapes.parts import is_closed, pieces, signed_volume, surface_area
from viewgain.errors import ConfigError
from viewgain.geometry import rotation_from_rotvec
from viewgain.shapes._extrude import extrude
from viewgain.shapes._outline import ellipse, rectangle, unit_circle
from viewgain.shapes._part import Part
from viewgain.shapes._path import arc, rounded, rounded_loop, smooth
from viewgain.shapes._sweep import _tangents, _transported, rod, sweep

points = arrays(float, 3, elements=st.floats(-2, 2))


def volume(part: Part) -> float:
    return signed_volume(part.vertices[part.faces])


def area(part: Part) -> float:
    return surface_area(part.vertices[part.faces])


def helix(count: int) -> np.ndarray:
    angle = np.linspace(0, 3 * pi, count)
    return np.column_stack([np.cos(angle), np.sin(angle), 0.3 * angle])


@given(points, points, st.integers(2, 7))
def test_a_straight_sweep_is_the_prism_over_its_section(start: np.ndarray, end: np.ndarray, count: int) -> None:
    length = float(np.linalg.norm(end - start))
    assume(length > 0.1)
    section = rectangle(0.3, 0.5)
    part = sweep(np.linspace(start, end, count), section)
    prism = extrude(section, length)
    assert is_closed(part.faces)
    assert volume(part) == pytest.approx(volume(prism))
    assert area(part) == pytest.approx(area(prism))


def test_a_level_sweep_has_its_sections_first_axis_on_the_left_and_the_second_upwards() -> None:
    part = sweep([(0.0, 0.0, 0.0), (4.0, 0.0, 0.0)], rectangle(0.2, 0.6))
    low, high = part.vertices.min(axis=0), part.vertices.max(axis=0)
    np.testing.assert_allclose([low, high], [[0, -0.1, -0.3], [4, 0.1, 0.3]], atol=1e-15)
    corner = sweep([(0.0, 0.0, 0.0), (4.0, 0.0, 0.0)], np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 2.0)]))
    assert corner.vertices[:, 1].max() == pytest.approx(1.0)  # left of +x is +y
    assert corner.vertices[:, 1].min() == pytest.approx(0.0)
    assert corner.vertices[:, 2].max() == pytest.approx(2.0)


@given(points, points, st.floats(0.05, 0.5), st.floats(0.05, 0.5), st.integers(3, 16))
def test_a_rod_is_a_tapered_sweep_and_a_frustum(
    start: np.ndarray, end: np.ndarray, radius: float, end_radius: float, sides: int
) -> None:
    length = float(np.linalg.norm(end - start))
    assume(length > 0.1)
    bar = rod(start, end, radius, end_radius, sides)
    twin = sweep(np.stack([start, end]), unit_circle(sides), scale=[radius, end_radius])
    np.testing.assert_allclose(bar.vertices, twin.vertices, atol=1e-9)
    section = sides / 2 * np.sin(2 * pi / sides)
    expected = length * section * (radius**2 + radius * end_radius + end_radius**2) / 3
    assert volume(bar) == pytest.approx(expected)
    assert is_closed(bar.faces)


def test_a_bent_tube_obeys_pappus() -> None:
    """A quarter of a torus: section times the way of its middle."""
    path = np.column_stack([arc(2.0, 0.0, pi / 2, 200), np.zeros(200)])
    part = sweep(path, unit_circle(60) * 0.3)
    assert volume(part) == pytest.approx(pi * 0.09 * pi, rel=3e-3)  # the 60-gon lacks (2 pi / 60)^2 / 6 = 1.8e-3
    assert area(part) == pytest.approx(2 * pi * 0.3 * pi + 2 * pi * 0.09, rel=3e-3)
    assert is_closed(part.faces)


@given(arrays(float, (8, 3), elements=st.floats(-1, 1)))
def test_frames_are_orthonormal_along_any_path(steps: np.ndarray) -> None:
    path = np.cumsum(steps + np.array((1.5, 0.0, 0.0)), axis=0)
    tangents = _tangents(path)
    lefts = _transported(path, tangents, (0.0, 0.0, 1.0))
    np.testing.assert_allclose(np.linalg.norm(tangents, axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(lefts, axis=1), 1, atol=1e-12)
    np.testing.assert_allclose((tangents * lefts).sum(axis=1), 0, atol=1e-12)


def test_frames_along_a_plane_path_stay_in_its_plane() -> None:
    path = np.column_stack([arc(1.0, 0.0, 1.9 * pi, 30), np.zeros(30)])
    tangents = _tangents(path)
    lefts = _transported(path, tangents, (0.0, 0.0, 1.0))
    np.testing.assert_allclose(np.cross(tangents, lefts), np.tile([0.0, 0.0, 1.0], (30, 1)), atol=1e-12)


def test_frames_do_not_spin_about_the_path() -> None:
    """The change of a frame's axis has no part along the other axis of the frame: to second order in the step."""
    for count, most in ((100, 2e-4), (200, 2.5e-5)):  # the error falls with the third power of the step
        path = helix(count)
        tangents = _tangents(path)[1:-1]  # the ends are one-sided and only of first order
        lefts = _transported(path[1:-1], tangents, (0.0, 0.0, 1.0))
        tops = np.cross(tangents, lefts)
        spin = (np.diff(lefts, axis=0) * (tops[1:] + tops[:-1]) / 2).sum(axis=1)
        assert np.abs(spin).max() < most


@given(points)
def test_a_turned_path_gives_the_turned_sweep(rotvec: np.ndarray) -> None:
    """With ``up`` turned as well, nothing in a sweep knows the axes of the world."""
    rotation = rotation_from_rotvec(rotvec)
    scale = np.linspace(1.0, 0.5, 20)
    straight = sweep(helix(20), ellipse(0.2, 0.1), scale=scale)
    up = rotation @ (0.0, 0.0, 1.0)
    turned = sweep(helix(20) @ rotation.T, ellipse(0.2, 0.1), scale=scale, up=(up[0], up[1], up[2]))
    np.testing.assert_allclose(turned.vertices, straight.vertices @ rotation.T, atol=1e-9)


def test_a_scale_for_each_axis_changes_width_and_height_apart() -> None:
    part = sweep([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)], rectangle(1.0, 1.0), scale=[(1.0, 2.0), (3.0, 0.5)])
    at_end = part.vertices[np.isclose(part.vertices[:, 0], 1.0)]
    np.testing.assert_allclose(np.ptp(at_end, axis=0), [0, 3, 0.5], atol=1e-12)
    at_start = part.vertices[np.isclose(part.vertices[:, 0], 0.0)]
    np.testing.assert_allclose(np.ptp(at_start, axis=0), [0, 1, 2], atol=1e-12)


@pytest.mark.parametrize("way", [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0)])
def test_a_path_straight_up_has_a_frame_too(way: tuple[float, float, float]) -> None:
    part = sweep([(0.0, 0.0, 0.0), way], rectangle(0.2, 0.3))
    assert volume(part) == pytest.approx(0.06)
    assert len(pieces(part.vertices, part.faces).volumes) == 1


def test_a_path_that_stands_still_is_refused() -> None:
    with pytest.raises(ConfigError, match="coincide"):
        sweep([(0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)], unit_circle(6))
    with pytest.raises(ConfigError, match="direction"):
        rod((1.0, 1.0, 1.0), (1.0, 1.0, 1.0), 0.1)


@given(arrays(float, (5, 3), elements=st.floats(-2, 2)), st.integers(2, 40))
def test_a_smooth_line_starts_and_ends_at_its_ends(knots: np.ndarray, count: int) -> None:
    line = smooth(knots, count)
    assert line.shape == (count, 3)
    np.testing.assert_allclose(line[[0, -1]], knots[[0, -1]], atol=1e-12)


def test_a_smooth_line_passes_through_its_knots_and_keeps_straight_ones_straight() -> None:
    knots = np.array([(0.0, 0.0), (1.0, 2.0), (2.0, -1.0), (3.0, 0.0)])
    np.testing.assert_allclose(smooth(knots, 13)[::4], knots, atol=1e-12)
    straight = smooth([(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (3.0, 3.0)], 20)
    np.testing.assert_allclose(straight[:, 0], straight[:, 1], atol=1e-12)


@given(arrays(float, (6, 3), elements=st.floats(-1, 1)), st.floats(0.01, 5.0))
def test_a_rounded_path_keeps_its_ends_and_no_two_points_coincide(steps: np.ndarray, radius: float) -> None:
    path = np.cumsum(steps + np.array((1.2, 0.0, 0.0)), axis=0)
    line = rounded(path, radius)
    np.testing.assert_array_equal(line[[0, -1]], path[[0, -1]])
    assert np.linalg.norm(np.diff(line, axis=0), axis=1).min() > 0
    assert len(line) == 2 + 4 * 5


def test_a_rounded_corner_leaves_the_segments_at_the_radius() -> None:
    line = rounded([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0)], 1.0, steps=2)
    np.testing.assert_allclose(line, [(0, 0), (3, 0), (3.75, 0.25), (4, 1), (4, 4)])
    np.testing.assert_array_equal(rounded([(0.0, 0.0), (1.0, 0.0)], 0.3), [(0, 0), (1, 0)])


def test_a_rounded_loop_rounds_every_corner_alike() -> None:
    square = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])
    loop = rounded_loop(square, 0.5)
    assert len(loop) == 16
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    np.testing.assert_allclose(loop @ quarter.T, np.roll(loop, -4, axis=0), atol=1e-12)
    np.testing.assert_allclose(np.ptp(loop, axis=0), [2, 2])

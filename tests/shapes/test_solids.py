"""The solids that objects are made of, against the closed formulas of what they approximate."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.shapes.parts import is_closed, pieces, signed_volume, surface_area
from viewgain.errors import ConfigError
from viewgain.shapes._extrude import extrude, front_profile, side_profile
from viewgain.shapes._lathe import hollow, lathe, lathe_ring
from viewgain.shapes._outline import ellipse, polar, rectangle, superellipse, unit_circle
from viewgain.shapes._part import Part
from viewgain.shapes._primitives import block, board, cushion, cylinder, ellipsoid, frustum, tapered, torus, wedge
from viewgain.shapes._wheels import wheel
from viewgain.shapes._wing import wing

lengths = st.floats(0.01, 10.0)
shares = st.floats(0.05, 0.95)
sides_of = st.integers(3, 40)


def volume(part: Part) -> float:
    return signed_volume(part.vertices[part.faces])


def area(part: Part) -> float:
    return surface_area(part.vertices[part.faces])


def spans(part: Part) -> np.ndarray:
    """(2, 3) lowest and highest corner."""
    return np.stack([part.vertices.min(axis=0), part.vertices.max(axis=0)])


def ring_share(sides: int) -> float:
    """Area of a regular polygon over that of its circle."""
    return sides / (2 * pi) * sin(2 * pi / sides)


def assert_sound(part: Part) -> None:
    assert is_closed(part.faces)
    found = pieces(part.vertices, part.faces)
    assert len(found.volumes) == 1
    assert found.volumes[0] > 0
    assert found.areas.min() > 0


SOLIDS = {
    "block": block(1.0, 2.0, 3.0),
    "board": board(1.0, 2.0, 3.0),
    "tapered": tapered((1.0, 2.0), (0.5, 0.7), 2.0, (0.3, -0.2)),
    "wedge": wedge(1.0, 2.0, 0.7, 0.2),
    "cylinder": cylinder(0.5, 2.0),
    "cone": frustum(0.5, 0.0, 2.0),
    "frustum": frustum(0.5, 0.9, 2.0, 5),
    "ellipsoid": ellipsoid(1.0, 2.0, 3.0),
    "cushion": cushion(1.0, 2.0, 0.3),
    "torus": torus(1.0, 0.4),
    "cup": lathe(hollow([(0.4, 0.0), (0.5, 1.0)], 0.05, 0.1)),
    "wheel": wheel(0.3, 0.2),
    "wing": wing(2.0, 1.0, 5.0, sweep=1.0, rise=0.5),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_every_solid_is_one_closed_piece_wound_outwards(name: str) -> None:
    assert_sound(SOLIDS[name])


@pytest.mark.parametrize("name", SOLIDS)
def test_moving_turning_and_mirroring_keep_a_solid_sound_and_its_volume(name: str) -> None:
    part = SOLIDS[name]
    for moved in (part.at(3.0, -2.0, 1.0), part.turned(0.7, "x"), part.turned(0.7, "y"), part.turned(0.7), part.mirrored()):
        assert_sound(moved)
        assert volume(moved) == pytest.approx(volume(part), rel=1e-9)
        assert area(moved) == pytest.approx(area(part), rel=1e-9)
    assert volume(part.stretched(2.0, 3.0, 0.5)) == pytest.approx(3 * volume(part), rel=1e-9)


def test_turning_is_right_handed_about_each_axis() -> None:
    point = Part(np.array([[1.0, 2.0, 3.0]]), np.zeros((0, 3), dtype=np.int32))
    np.testing.assert_allclose(point.turned(pi / 2, "x").vertices, [[1, -3, 2]], atol=1e-15)
    np.testing.assert_allclose(point.turned(pi / 2, "y").vertices, [[3, 2, -1]], atol=1e-15)
    np.testing.assert_allclose(point.turned(pi / 2, "z").vertices, [[-2, 1, 3]], atol=1e-15)
    np.testing.assert_allclose(point.mirrored().vertices, [[1, -2, 3]])


@given(lengths, lengths, lengths)
def test_a_block_has_the_volume_and_the_surface_of_its_sides(x: float, y: float, z: float) -> None:
    part = block(x, y, z)
    assert volume(part) == pytest.approx(x * y * z)
    assert area(part) == pytest.approx(2 * (x * y + y * z + z * x))
    np.testing.assert_allclose(spans(part), [[-x / 2, -y / 2, 0], [x / 2, y / 2, z]])


@given(lengths, lengths, lengths, st.floats(0.001, 1.0))
def test_a_board_fills_its_cuboid_but_for_the_bevelled_edges(x: float, y: float, z: float, bevel: float) -> None:
    part, cut = board(x, y, z, bevel), min(bevel, min(x, y, z) / 5)
    assert_sound(part)
    np.testing.assert_allclose(spans(part), [[-x / 2, -y / 2, 0], [x / 2, y / 2, z]], atol=1e-12)
    # The upright edges lose a triangle each, the level ones as well; corners count twice, hence a lower bound only.
    lost = 2 * cut**2 * (x + y + z) * 2
    assert x * y * z - lost <= volume(part) < x * y * z


@given(st.tuples(lengths, lengths), st.tuples(lengths, lengths), lengths, st.tuples(lengths, lengths))
def test_a_tapered_block_is_a_prismatoid(
    bottom: tuple[float, float], top: tuple[float, float], z: float, shift: tuple[float, float]
) -> None:
    """Simpson's rule is exact for it: the mean of the three sections weighted 1, 4, 1; a shift changes nothing."""
    middle = (bottom[0] + top[0]) * (bottom[1] + top[1]) / 4
    part = tapered(bottom, top, z, shift)
    assert volume(part) == pytest.approx(z * (bottom[0] * bottom[1] + 4 * middle + top[0] * top[1]) / 6)
    np.testing.assert_allclose(part.vertices[4:].mean(axis=0), [*shift, z])


@given(lengths, lengths, lengths, st.floats(-2.0, 2.0))
def test_a_wedge_is_half_its_cuboid_wherever_the_ridge(x: float, y: float, z: float, ridge: float) -> None:
    assert volume(wedge(x, y, z, ridge)) == pytest.approx(x * y * z / 2)


@given(lengths, lengths, st.integers(3, 60))
def test_a_cylinder_is_the_prism_inscribed_in_it(radius: float, z: float, sides: int) -> None:
    part = cylinder(radius, z, sides)
    rim = 2 * radius * sides * sin(pi / sides)
    assert volume(part) == pytest.approx(pi * radius**2 * z * ring_share(sides))
    assert area(part) == pytest.approx(2 * pi * radius**2 * ring_share(sides) + rim * z)


@given(lengths, lengths, lengths, sides_of)
def test_a_frustum_and_a_cone_have_the_volume_of_the_pyramid(bottom: float, top: float, z: float, sides: int) -> None:
    share = pi / 3 * z * ring_share(sides)
    assert volume(frustum(bottom, top, z, sides)) == pytest.approx(share * (bottom**2 + bottom * top + top**2))
    assert volume(frustum(bottom, 0.0, z, sides)) == pytest.approx(share * bottom**2)


def test_a_fine_cone_has_the_mantle_of_the_smooth_one() -> None:
    part = frustum(0.5, 0.0, 2.0, 400)
    assert area(part) == pytest.approx(pi * 0.25 + pi * 0.5 * sqrt(0.25 + 4), rel=1e-4)  # (pi / 400)^2 is 6e-5


def test_a_fine_ellipsoid_fills_the_smooth_one_and_a_coarse_one_less() -> None:
    smooth = pi / 6 * 1.0 * 2.0 * 3.0
    fine, coarse = volume(ellipsoid(1.0, 2.0, 3.0, 120, 240)), volume(ellipsoid(1.0, 2.0, 3.0))
    assert fine == pytest.approx(smooth, rel=1e-3)  # inscribed: short by (2 + 1) pi^2 / (3 120^2) at most
    assert 0.9 * smooth < coarse < fine < smooth
    assert area(ellipsoid(1.0, 1.0, 1.0, 120, 240)) == pytest.approx(pi, rel=1e-3)
    np.testing.assert_allclose(spans(ellipsoid(1.0, 2.0, 3.0, 9)), [[-0.5, -1, -1.5], [0.5, 1, 1.5]])


def test_a_cushion_lies_between_the_ellipsoid_and_the_cuboid_and_stands_on_the_floor() -> None:
    part = cushion(1.0, 2.0, 0.5, 0.3)
    assert pi / 6 < volume(part) < 1.0
    assert volume(cushion(1.0, 2.0, 0.5, 0.2)) > volume(part) > volume(cushion(1.0, 2.0, 0.5, 0.6))
    assert spans(part)[0, 2] == pytest.approx(0.0, abs=1e-12)


@given(st.floats(1.0, 5.0), st.floats(0.1, 1.5), st.integers(3, 40), st.integers(3, 20))
def test_a_torus_obeys_pappus_for_polygons(radius: float, thickness: float, sides: int, around: int) -> None:
    """Section times the way of its middle, both polygons: exact, as each piece between two sections is a prismatoid."""
    section = pi * (thickness / 2) ** 2 * ring_share(around)
    part = torus(radius, thickness, sides, around)
    assert_sound(part)
    moment = np.sum(_triangle_moments(unit_circle(around) * (thickness / 2) + (radius, 0.0)))
    assert volume(part) == pytest.approx(2 * pi * ring_share(sides) * moment)
    assert moment == pytest.approx(section * radius)


def _triangle_moments(polygon: np.ndarray) -> np.ndarray:
    """Integral of the first coordinate over a polygon, by edges."""
    (x, y), (u, v) = polygon.T, np.roll(polygon, -1, axis=0).T
    return (x + u) * (x * v - u * y) / 6


def test_a_fine_torus_has_the_volume_and_the_area_of_the_smooth_one() -> None:
    part = torus(2.0, 1.0, 300, 200)
    assert volume(part) == pytest.approx(2 * pi**2 * 2.0 * 0.25, rel=1e-3)
    assert area(part) == pytest.approx(4 * pi**2 * 2.0 * 0.5, rel=1e-3)


@given(st.lists(st.tuples(st.floats(0.1, 2.0), st.floats(0.05, 1.0)), min_size=2, max_size=8), sides_of)
def test_a_lathe_stacks_frustums(steps: list[tuple[float, float]], sides: int) -> None:
    radii, heights = np.array([r for r, _ in steps]), np.cumsum([z for _, z in steps])
    part = lathe(np.column_stack([radii, heights]), sides)
    a, b, z = radii[:-1], radii[1:], np.diff(heights)
    assert_sound(part)
    assert volume(part) == pytest.approx(pi / 3 * ring_share(sides) * np.sum(z * (a**2 + a * b + b**2)))


def test_a_profile_may_start_and_end_on_the_axis() -> None:
    double_cone = lathe([(0.0, -1.0), (1.0, 0.0), (0.0, 1.0)], 4)
    assert len(double_cone.vertices) == 6
    assert volume(double_cone) == pytest.approx(4 / 3)  # the regular octahedron


@pytest.mark.parametrize("profile", [[(0.0, 0.0), (0.0, 1.0)], [(1.0, 0.0), (0.0, 0.5), (1.0, 1.0)], [(1.0, 0.0), (-0.1, 1.0)]])
def test_a_profile_that_touches_the_axis_elsewhere_is_refused(profile: list[tuple[float, float]]) -> None:
    with pytest.raises(ConfigError, match="axis"):
        lathe(profile)


def test_a_ring_that_reaches_the_axis_is_refused() -> None:
    with pytest.raises(ConfigError, match="axis"):
        lathe_ring([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])


@given(st.floats(0.5, 2.0), st.floats(0.5, 2.0), st.floats(0.01, 0.2), st.floats(0.01, 0.3))
def test_a_hollow_vessel_is_the_solid_less_its_cavity(bottom: float, top: float, wall: float, floor: float) -> None:
    outer = [(bottom, 0.0), ((bottom + top) / 2, 0.5), (top, 1.0)]
    part = lathe(hollow(outer, wall, floor), 16)
    assert_sound(part)
    low = bottom + (top - bottom) * floor - wall
    high = top - wall
    cavity = pi / 3 * ring_share(16) * (1 - floor) * (low**2 + low * high + high**2)
    assert volume(part) == pytest.approx(volume(lathe(outer, 16)) - cavity)
    assert np.ptp(part.vertices[:, 2]) == pytest.approx(1.0)


@given(lengths, lengths, lengths, shares)
def test_extruding_an_outline_gives_its_area_times_the_height(x: float, y: float, z: float, share: float) -> None:
    part = extrude(ellipse(x, y, 12), z)
    assert_sound(part)
    assert volume(part) == pytest.approx(pi / 4 * x * y * ring_share(12) * z)
    bevelled = extrude(rectangle(x, y), z, bevel=0.4 * share * min(x, y, z))
    assert_sound(bevelled)
    assert volume(bevelled) < x * y * z
    np.testing.assert_allclose(spans(bevelled), [[-x / 2, -y / 2, 0], [x / 2, y / 2, z]], atol=1e-12)


def test_a_side_profile_keeps_its_outline_in_x_and_z_and_a_front_profile_in_y_and_z() -> None:
    outline = np.array([(0.0, 0.0), (3.0, 0.0), (0.0, 1.0)])
    side, front = side_profile(outline, 2.0, centre=(1.0, 0.3)), front_profile(outline, 2.0, centre=(1.0, 0.3))
    np.testing.assert_allclose(spans(side), [[0, -1, 0], [3, 1, 1]], atol=1e-15)
    np.testing.assert_allclose(spans(front), [[0, 0, 0], [2, 3, 1]], atol=1e-15)
    for part in (side, front):
        assert_sound(part)
        assert volume(part) == pytest.approx(3.0)


@given(lengths, lengths, st.just(0.0) | st.floats(1e-3, 20.0), st.integers(1, 6))
def test_outlines_run_counter_clockwise_and_keep_their_widths(x: float, y: float, radius: float, steps: int) -> None:
    for outline in (rectangle(x, y, radius, steps), superellipse(x, y, 3.0), ellipse(x, y)):
        following = np.roll(outline, -1, axis=0)
        assert (outline[:, 0] * following[:, 1] - following[:, 0] * outline[:, 1] > 0).all()
        np.testing.assert_allclose(np.ptp(outline, axis=0), [x, y])


def test_a_rounded_rectangle_loses_its_corners_and_a_polar_outline_keeps_its_radii() -> None:
    assert volume(extrude(rectangle(4.0, 3.0, 1.0, 50), 1.0)) == pytest.approx(12 - (4 - pi), abs=1e-3)
    radii = np.array([1.0, 2.0, 1.0, 3.0])
    np.testing.assert_allclose(np.linalg.norm(polar(radii), axis=1), radii)


def test_a_wing_has_its_span_and_its_sweep_and_is_thickest_at_the_root() -> None:
    part = wing(2.0, 1.0, 5.0, sweep=3.0, rise=0.5, thickness=0.1)
    low, high = spans(part)
    assert (low[1], high[1]) == pytest.approx((0.0, 5.0))
    tip, root = part.vertices[np.isclose(part.vertices[:, 1], 5.0)], part.vertices[np.isclose(part.vertices[:, 1], 0.0)]
    assert (tip[:, 0].max() + tip[:, 0].min()) / 2 == pytest.approx(-3.0, abs=1e-9)
    assert np.ptp(root[:, 2]) > np.ptp(tip[:, 2]) > 0
    assert tip[:, 2].mean() == pytest.approx(0.5, abs=0.05)


def test_a_wheel_rolls_about_y() -> None:
    low, high = spans(wheel(0.3, 0.2, 16))
    np.testing.assert_allclose(high - low, [0.6, 0.2, 0.6])
    assert cos(0.0) * high[1] == pytest.approx(0.1)


def test_the_test_of_closedness_itself_tells_open_from_closed() -> None:
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], dtype=np.int32)
    assert is_closed(faces)
    assert not is_closed(faces[:3])  # a hole
    assert not is_closed(np.vstack([faces[:3], faces[3:, ::-1]]))  # one triangle wound the other way
    assert not is_closed(np.vstack([faces, faces]))  # edges of four triangles

"""A pixel is a square: what it reports at depth edges, where those appear, and that nothing else changes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.footprint import footprint_image
from tests.oracles.scenes import corner_view
from tests.oracles.triangles import block
from tests.simulate.targets import EYE, FAR, SMALL, Array, cropped, flat_target, only_plane, plane_ranges, plate, ranges_of
from viewgain.box import Box
from viewgain.camera import Intrinsics, Sensor
from viewgain.geometry import pose
from viewgain.rays import Hits, SceneCaster
from viewgain.scenes import Scene, orbit_pose, standing_box
from viewgain.simulate import Effects, capture, true_hits
from viewgain.simulate._footprint import SUBRAYS, _middle, _most_seen, _phasor_sum, pixels_near_edges

BOX = standing_box(np.array([0.35, 0.25, 0.3]), yaw=0.4)
MIXING, LATERAL = Effects.only("mixing"), Effects.only("lateral")
SMALL_FAR = replace(SMALL, range_max=1e3)
PATTERN = replace(FAR, kind="structured_light")


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def upright_plate(edge_u: float, camera: Sensor, z: float, reflectivity: tuple[float, float], beyond: float) -> Scene:
    """A plate at depth z that covers the image left of column ``edge_u``, before a wall; its side faces away from the camera."""
    edge = (edge_u - camera.intrinsics.cx) / camera.intrinsics.fx * z
    # Its own frame is the camera's turned by a quarter: the front is the face -y.
    turn = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    return Scene(
        (Box(pose(turn, np.array([edge - 1.0, 3.0, z + 0.0005])), np.array([2.0, 0.001, 6.0])),),
        (),
        (flat_target(beyond),),
        reflectivity,
    )


@pytest.mark.parametrize("kind", ["tof", "structured_light"])
@pytest.mark.parametrize("names", [("mixing",), ("lateral",), ("mixing", "lateral")])
def test_only_pixels_near_depth_edges_change(names: tuple[str, ...], kind: str) -> None:
    """Within two pixels of another face or the floor: half a footprint, and 1.5 sd of displacement."""
    camera = replace(FAR, kind=kind)
    view = corner_view(BOX)
    clean = ranges_of(capture(Scene((BOX,)), view, camera, rng=None))
    changed = ranges_of(capture(Scene((BOX,)), view, camera, rng=rng(), effects=Effects.only(*names)))
    patch = true_hits(Scene((BOX,)), view, camera).surfaces.reshape(clean.shape)
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(patch, 2, mode="edge"), (5, 5))
    inside = np.all(windows == patch[..., None, None], axis=(2, 3))
    assert 0.8 < inside.mean() < 0.99
    np.testing.assert_array_equal(changed[inside], clean[inside])
    assert np.mean(changed[~inside] != clean[~inside]) > 0.05


@settings(max_examples=8)
@given(st.floats(0, 6.2), st.floats(25, 60), st.floats(0.8, 1.4))
def test_mixed_ranges_lie_between_what_is_seen_around(azimuth: float, elevation: float, distance: float) -> None:
    """Where everything around is within half a wavelength (0.93 m) of each other. 1 %: a slope seen at the pixel's own ray lies
    between its ranges a pixel further, which on a grazing face is not what the neighbours' centres see."""
    view = corner_view(BOX, azimuth_deg=float(np.rad2deg(azimuth)), elevation_deg=elevation, distance=distance)
    camera = replace(FAR, intrinsics=Intrinsics.from_field_of_view(112, 86, *np.deg2rad([62.0, 45.0])))
    clean = ranges_of(capture(Scene((BOX,)), view, camera, rng=None))
    mixed = ranges_of(capture(Scene((BOX,)), view, camera, rng=rng(), effects=MIXING))
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(clean, 1, mode="edge"), (3, 3))
    nearest, farthest = windows.min(axis=(2, 3)), windows.max(axis=(2, 3))
    narrow = farthest - nearest < camera.wavelength / 2
    assert narrow.mean() > 0.9
    assert np.all((mixed >= nearest * 0.99)[narrow])
    assert np.all((mixed <= farthest * 1.01)[narrow])


def phasor(returns: list[tuple[float, float]], wavelength: float) -> complex:
    """The sum of weight * exp(2 pi i range / wavelength), and nothing clever."""
    return sum((w * np.exp(2j * np.pi * r / wavelength) for r, w in returns), 0j)


@given(st.floats(0.5, 3), st.floats(-0.9, 0.9), st.floats(0.05, 20))
def test_two_returns_in_one_pixel_add_as_phasors(range_: float, apart: float, ratio: float) -> None:
    """At unit wavelength: range and amplitude are the angle and length of the sum; the turn counts from the strongest."""
    found_range, found_amplitude = _phasor_sum(np.array([[range_, range_ + apart]]), np.array([[1.0, ratio]]), 1.0)
    total = phasor([(range_, 1.0), (range_ + apart, ratio)], 1.0)
    np.testing.assert_allclose(found_amplitude, abs(total) / 2, atol=1e-9)
    if abs(total) > 1e-6:
        np.testing.assert_allclose(np.exp(2j * np.pi * found_range), total / abs(total), atol=1e-6)
        assert abs(found_range - (range_ if ratio < 1 else range_ + apart)) <= 0.5 + 1e-9
    if abs(apart) < 0.5:
        assert min(0, apart) - 1e-9 <= found_range - range_ <= max(0, apart) + 1e-9


def test_phasors_by_hand() -> None:
    """Equal returns a quarter of a wavelength apart: half way, and 1 / sqrt(2) of the light. A mixture with nothing: itself."""
    ranges, amplitude = _phasor_sum(
        np.array([[1.0, 1.25], [1.0, np.inf], [np.inf, np.inf]]), np.array([[1, 1], [1, 0], [0, 0.0]]), 1.0
    )
    np.testing.assert_allclose(ranges, [1.125, 1.0, np.inf])
    np.testing.assert_allclose(amplitude, [np.sqrt(0.5), 0.5, 0.0], atol=1e-12)


def test_a_pattern_locks_to_the_surface_that_most_sub_rays_see() -> None:
    """Four see the near one, one the middle, three the far: the near one, though the middle one is the median."""
    patches = np.array([[5, 5, 5, 5, 7, 9, 9, 9], [-1, -1, -1, -1, -1, 2, 2, 2], [3, 3, 3, 3, 3, 3, 3, -1]], dtype=np.int32)
    chosen = _most_seen(patches)
    np.testing.assert_array_equal(chosen[0], patches[0] == 5)
    np.testing.assert_array_equal(chosen[1], patches[1] == -1)
    np.testing.assert_array_equal(chosen[2], patches[2] == 3)
    ranges = np.array([[1.0, 1.2, 1.1, np.nan], [np.inf, np.inf, np.nan, np.nan], [2.0, np.nan, np.nan, np.nan]])
    np.testing.assert_array_equal(_middle(ranges), [1.1, np.inf, 2.0])


@pytest.mark.parametrize("reflectivity", [(0.5, 0.5), (0.2, 0.9), (0.9, 0.2)])
@pytest.mark.parametrize("covered", [1, 2])
def test_a_pixel_on_an_edge_is_the_phasor_sum_of_what_it_sees(covered: int, reflectivity: tuple[float, float]) -> None:
    """An edge between the columns of sub-rays: a third or two of the footprint is the plate's. 1e-6: sub-rays of the middle pixel
    are up to 0.1 degrees off, which changes weights by a few 1e-6."""
    camera = cropped(FAR, 21, 21)
    edge = 10 - 0.5 + covered / SUBRAYS
    scene = upright_plate(edge, camera, 1.0, reflectivity, 1.6)
    scan = capture(scene, EYE, camera, rng=rng(), effects=MIXING)
    share, near, far = covered / SUBRAYS, reflectivity[0] / 1.0**2, reflectivity[1] / 1.6**2
    total = phasor([(0.0, share * near), (0.6, (1 - share) * far)], camera.wavelength)
    assert scan.amplitude is not None
    np.testing.assert_allclose(ranges_of(scan)[10, 10], 1.0 + np.angle(total) * camera.wavelength / 2 / np.pi, rtol=1e-5)
    np.testing.assert_allclose(scan.amplitude[10, 10], abs(total), rtol=1e-4)
    np.testing.assert_allclose(ranges_of(scan)[10, [9, 11]], [1.0, 1.6], rtol=1e-4)  # 0.3 degrees off the axis


def test_returns_far_apart_may_show_a_range_outside_their_interval() -> None:
    """0.8 of a wavelength apart is 0.2 of one on the other side: what a camera of one frequency does."""
    camera = cropped(FAR, 21, 21)
    scene = upright_plate(10 - 0.5 + 2 / 3, camera, 1.0, (0.5, 0.9), 1.0 + 0.8 * camera.wavelength)
    assert ranges_of(capture(scene, EYE, camera, rng=rng(), effects=MIXING))[10, 10] < 0.999


@pytest.mark.parametrize("names", [("mixing",), ("mixing", "lateral")])
def test_structured_light_never_mixes(names: tuple[str, ...]) -> None:
    """Every value is the plate's or the wall's, in depth (1e-9: both are seen head-on)."""
    camera = replace(cropped(PATTERN, 61, 101), lateral_px=0.8)
    scene = Scene((plate(1.0, roll=0.02),), planes=(flat_target(1.6),))
    depth = capture(scene, EYE, camera, rng=rng(), effects=Effects.only(*names)).organised()[..., 2]
    on_plate, on_wall = np.isclose(depth, 1.0, rtol=1e-9), np.isclose(depth, 1.6, rtol=1e-9)
    side = (depth > 1.0) & (depth < 1.002 + 1e-9)  # the plate is 2 mm thick
    assert np.all(on_plate | on_wall | side)
    assert on_plate.sum() > 1000
    assert on_wall.sum() > 1000
    tof = capture(scene, EYE, replace(camera, kind="tof"), rng=rng(), effects=Effects.only(*names)).organised()[..., 2]
    assert np.sum((tof > 1.05) & (tof < 1.55)) > 50


@pytest.mark.parametrize("lateral_px", [0.3, 0.8])
@pytest.mark.parametrize("kind", ["tof", "structured_light"])
def test_the_place_of_an_edge_is_not_biased(kind: str, lateral_px: float) -> None:
    """Where half of the pixels are the plate's, both sides equally bright. 4 standard errors: 0.75 sqrt(sd) per row at most."""
    camera = replace(cropped(FAR, 41, 401), kind=kind, lateral_px=lateral_px)
    near, far = 1.0, 1.6
    scene = Scene((plate(near, roll=0.01, width=2.0),), planes=(flat_target(far),), reflectivity=(0.8 * near**2 / far**2, 0.8))
    hits = true_hits(scene, EYE, camera)
    edge = (hits.ranges * camera.intrinsics.directions()[..., 2].ravel()).reshape(401, 41) < 1.3
    found = []
    for seed in range(6):
        depth = capture(scene, EYE, camera, rng=rng(seed), effects=Effects.only("mixing", "lateral")).organised()[..., 2]
        found.append((depth < 1.3).sum(axis=1) - edge.sum(axis=1))
    # The true edge crosses a pixel every 100 rows, so counting pixel centres is right on average over 4 crossings.
    assert abs(np.mean(found)) < 4 * 0.75 * lateral_px**0.5 / np.sqrt(6 * 401) + 0.01


@settings(max_examples=4)
@given(st.floats(0.1, 6.2), st.floats(25, 65), st.floats(0.7, 1.2), st.sampled_from(["tof", "structured_light"]))
def test_mixing_at_edges_only_equals_mixing_everywhere(azimuth: float, elevation: float, distance: float, kind: str) -> None:
    """Against every pixel's footprint, sub-ray by sub-ray. 1e-9: the same arithmetic, other order.

    0.5 % of the pixels may differ: where only a corner of the footprint meets another surface that no pixel centre beside sees,
    and sub-rays that meet an edge to within rounding.
    """
    other = standing_box(np.array([0.2, 0.3, 0.5]), yaw=1.0, at=(0.5, 0.1))
    scene = Scene((BOX, other), reflectivity=(0.7, 0.3, 0.5))
    view = orbit_pose(np.array([0.2, 0.1, 0.15]), azimuth, np.deg2rad(elevation), distance)
    camera = replace(SMALL_FAR, kind=kind)
    found = ranges_of(capture(scene, view, camera, rng=rng(), effects=MIXING)).ravel()
    expected = footprint_image(scene, view, camera, SUBRAYS)
    same = np.isclose(np.nan_to_num(found, nan=np.inf), expected, rtol=1e-9)
    assert np.mean(~same) <= 0.005, np.flatnonzero(~same)
    clean = capture(scene, view, camera, rng=None)
    assert np.mean(ranges_of(clean).ravel() != found) > 0.02


@pytest.mark.parametrize("theta_deg", [0, 30, 60, 75])
@pytest.mark.parametrize("kind", ["tof", "structured_light"])
def test_a_slope_without_edges_is_left_alone(kind: str, theta_deg: float) -> None:
    target = flat_target(1.0, np.deg2rad(theta_deg))
    camera = replace(cropped(FAR, 41, 31), kind=kind, lateral_px=2.0)
    image = ranges_of(capture(only_plane(target), EYE, camera, rng=rng(), effects=Effects.only("mixing", "lateral")))
    np.testing.assert_allclose(image, plane_ranges(target, camera), rtol=1e-12)


@pytest.mark.parametrize("kind", ["tof", "structured_light"])
def test_a_crease_between_two_slopes_brings_no_range_error(kind: str) -> None:
    """The faces of a box seen edge-on meet in one line: what a displaced pixel reads there is one face or the other, continued.

    At its own ray each differs from the true one by less than the crease's depth over the reach: two pixels of 5 mrad on two
    slopes of 45 degrees, 1.2 m away, 2 (1.2 * 5e-3 * 2) = 24 mm; and far less on average.
    """
    box = standing_box(np.array([0.4, 0.4, 0.6]))
    view = orbit_pose(np.array([0.2, 0.2, 0.3]), np.pi / 4, 0.0, 1.2, 0.05)
    camera = replace(cropped(FAR, 41, 31), kind=kind)
    scene = Scene((box,), planes=())
    clean = ranges_of(capture(scene, view, camera, rng=None))
    shaken = ranges_of(capture(scene, view, camera, rng=rng(), effects=Effects.only("mixing", "lateral")))
    off = np.abs(shaken - clean)
    assert 0.002 < np.mean(off > 1e-6) < 0.15
    assert off.max() < 0.024
    assert off.mean() < 1e-3


def test_a_slopes_edge_pixels_keep_their_own_range_where_nothing_else_is_in_sight() -> None:
    """Beside an edge, pixels that still see the slope alone read the slope at their own ray, displaced or not."""
    scene = Scene((plate(1.0, np.deg2rad(50), roll=0.01),), planes=(flat_target(2.0),))
    camera = replace(cropped(PATTERN, 61, 101), lateral_px=0.8)
    clean = ranges_of(capture(scene, EYE, camera, rng=None))
    shaken = ranges_of(capture(scene, EYE, camera, rng=rng(), effects=Effects.only("mixing", "lateral")))
    both = (clean < 1.3) & (shaken < 1.3)
    moved = both & (np.abs(clean - shaken) > 1e-9)
    assert both.sum() > 1500
    assert moved.sum() < 0.01 * both.sum()  # the plate's 2 mm side


def hand_made(ranges: list[list[float]], patches: list[list[int]], meshes: bool = False) -> tuple[Hits, SceneCaster, Sensor]:
    """Hits on a box's faces 0 to 5 (and the floor, 6), as an image; with a mesh in the scene if asked for."""
    scene = Scene((BOX,), (block(np.full(3, 5.0), np.full(3, 6.0)),) if meshes else ())
    image = np.array(ranges, dtype=float)
    camera = replace(SMALL, intrinsics=Intrinsics.from_field_of_view(image.shape[1], image.shape[0], 1.0, 1.0))
    surfaces = np.array(patches, dtype=np.int32).ravel()
    return Hits(image.ravel(), surfaces, np.ones(image.size)), SceneCaster(scene), camera


def near_edges(patches: list[list[int]], reach: int) -> list[int]:
    hits, caster, camera = hand_made(np.ones(np.shape(patches)).tolist(), patches)
    return list(pixels_near_edges(hits, caster, camera, reach).tolist())


def test_pixels_near_edges_by_hand() -> None:
    row = [[0, 0, 0, 0, 2, 2, 2, 2]]
    assert near_edges(row, 1) == [3, 4]
    assert near_edges(row, 2) == [2, 3, 4, 5]
    assert near_edges(row, 3) == [1, 2, 3, 4, 5, 6]
    assert near_edges([[0, 0, 0]], 3) == []
    assert near_edges([[-1, 0, 0]], 1) == [0, 1]  # the sky is a patch of its own
    assert near_edges([[0], [0], [4], [4]], 1) == [1, 2]
    square = [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 4, 4], [0, 0, 4, 4]]
    assert near_edges(square, 1) == [6, 7, 9, 10, 11, 13, 14]
    assert near_edges(square, 2) == [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15]


def test_a_mesh_has_edges_where_its_range_jumps() -> None:
    """Surfaces 6 to 17 are the mesh's triangles: one patch, but 3 % of range is an edge, and no more is a slope."""
    row = [[6, 7, 8, 9]]
    for jump, expected in ((1.02, []), (1.04, [1, 2])):
        hits, caster, camera = hand_made([[1.0, 1.0, jump, jump]], row, meshes=True)
        assert pixels_near_edges(hits, caster, camera, 1).tolist() == expected
    hits, caster, camera = hand_made([[1.0, 1.0, np.inf, np.inf]], [[6, 6, -1, -1]], meshes=True)
    assert pixels_near_edges(hits, caster, camera, 1).tolist() == [1, 2]


def test_lateral_noise_alone_flips_pixels_and_a_wider_footprint_mixes_more() -> None:
    scene, camera = Scene((plate(1.0, roll=0.05),), planes=(flat_target(1.5),)), cropped(FAR, 61, 201)
    flipped = capture(scene, EYE, replace(camera, lateral_px=0.8), rng=rng(), effects=LATERAL).organised()[..., 2]
    assert np.sum((flipped > 1.01) & (flipped < 1.49)) == 0
    counts = []
    for width in (0.5, 1.0, 2.0, 4.0):
        mixed = capture(scene, EYE, replace(camera, footprint_px=width), rng=rng(), effects=MIXING).organised()[..., 2]
        counts.append(int(np.sum((mixed > 1.01) & (mixed < 1.49))))
    # The number of pixels whose sub-rays see both sides is rows times (width of the grid of sub-rays): 2 / 3 of the footprint.
    rows: Array = 201 * np.array([0.5, 1.0, 2.0, 4.0]) * (SUBRAYS - 1) / SUBRAYS
    np.testing.assert_allclose(counts, rows, rtol=0.15)

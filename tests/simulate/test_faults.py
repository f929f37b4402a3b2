"""Places and scenes in which a simulator easily goes wrong: the numbers stay numbers, and words come where nothing is seen."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles.rays import corners_of
from tests.oracles.scenes import corner_view
from tests.oracles.triangles import block, soup
from tests.simulate.targets import EYE, FAR, SMALL, Array, flat_target
from viewgain.box import Box
from viewgain.camera import PRESETS, Intrinsics, sensor
from viewgain.errors import ScanError
from viewgain.geometry import pose
from viewgain.scans import Scan
from viewgain.scenes import FLOOR, Scene, Surroundings, orbit_pose, random_scene, standing_box, wall
from viewgain.simulate import Effects, capture, true_hits

BOX = standing_box(np.array([0.35, 0.25, 0.3]), yaw=0.4)


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def seen(scene: Scene, view: Array, camera: object = FAR) -> Scan:
    return capture(scene, view, camera, rng=rng())  # type: ignore[arg-type]


def assert_sane(scan: Scan) -> None:
    """Finite points within the camera's reach, and an amplitude everywhere that is a number."""
    assert np.isfinite(scan.points).all()
    assert scan.amplitude is not None
    assert np.isfinite(scan.amplitude).all()
    assert scan.amplitude.min() >= 0


@pytest.mark.parametrize("name", PRESETS)
def test_every_camera_reports_finite_numbers_within_its_range(name: str) -> None:
    """The middle of its image, of a scene with sky, edges, grazing floor and a wall."""
    full = sensor(name)
    camera = replace(full, intrinsics=Intrinsics.from_field_of_view(64, 48, *np.deg2rad([60.0, 47.0])))
    scan = seen(Scene((BOX,), planes=(FLOOR, wall(np.pi, 1.5))), orbit_pose(BOX.centre, 0.2, 0.15, 1.1), camera)
    assert_sane(scan)
    distance = np.linalg.norm(scan.points, axis=1)
    assert distance.min() >= full.range_min - 1e-9
    assert distance.max() <= full.range_max + 1e-9


@settings(max_examples=15)
@given(st.integers(0, 10_000), st.integers(1, 3))
def test_random_scenes_give_numbers(seed: int, frames: int) -> None:
    chance = rng(seed)
    scene = random_scene(chance, surroundings=Surroundings(boxes=(1, 4), walls=(0, 2), clutter=(0, 1), reflectivity=(0.02, 1.0)))
    view = orbit_pose(np.array([0.0, 0.0, 0.1]), float(chance.uniform(0, 6)), float(chance.uniform(0.1, 1.5)), 1.0)
    camera = replace(SMALL, weakest=0.0, unambiguous=1.5, flying_filter=0.02, jitter_px=0.5, step=0.001, range_min=1e-3)
    assert_sane(capture(scene, view, camera, rng=chance, frames=frames))


def test_a_camera_inside_a_box_sees_through_it() -> None:
    """It sees what it would without the box; 1e-12, for there are no edges of it either."""
    around = standing_box(np.array([3.0, 3.0, 3.0]))
    view = corner_view(BOX)
    for scene, without in ((Scene((BOX, around)), Scene((BOX,))), (Scene((around,)), Scene())):
        with_it, expected = seen(scene, view), seen(without, view)
        np.testing.assert_allclose(with_it.organised(), expected.organised(), rtol=1e-12)
        np.testing.assert_allclose(with_it.amplitude, expected.amplitude, rtol=1e-12)


def test_a_box_behind_the_camera_changes_nothing() -> None:
    view = corner_view(BOX)
    behind = view[:3, 3] - 1.0 * view[:3, 2]
    other = Box(pose(np.eye(3), behind - [0, 0, 0.2]), np.full(3, 0.4))
    np.testing.assert_allclose(seen(Scene((BOX, other)), view).organised(), seen(Scene((BOX,)), view).organised(), rtol=1e-12)


def test_a_mesh_behind_the_camera_or_around_it() -> None:
    """Both sides of a triangle are surface, so a camera within a mesh sees it from inside."""
    behind = block(np.array([-0.2, -0.2, -1.2]), np.array([0.2, 0.2, -0.8]))
    scene = Scene(meshes=(behind,), planes=(flat_target(1.0),))
    np.testing.assert_allclose(seen(scene, EYE).organised(), seen(Scene(planes=(flat_target(1.0),)), EYE).organised(), rtol=1e-9)
    room = Scene(meshes=(block(np.full(3, -1.0), np.full(3, 1.0)),), planes=())
    scan = capture(room, EYE, FAR, rng=None)
    np.testing.assert_allclose(np.abs(scan.points).max(axis=1), 1.0, rtol=1e-9)
    assert_sane(seen(room, EYE))


def test_planes_are_seen_from_their_front_only() -> None:
    in_front, behind = flat_target(1.0), flat_target(1.0).flipped()
    assert np.isfinite(true_hits(Scene(planes=(in_front,)), EYE, FAR).ranges).all()
    assert np.isinf(true_hits(Scene(planes=(behind,)), EYE, FAR).ranges).all()
    under_the_floor = orbit_pose(np.array([0.0, 0.0, -2.0]), 0.0, -0.9, 1.0)
    with pytest.raises(ScanError, match="0 valid points"):
        capture(Scene(), under_the_floor, FAR, rng=rng())


@pytest.mark.parametrize("generator", [None, 0])
def test_an_empty_scene_is_refused_in_one_line(generator: int | None) -> None:
    with pytest.raises(ScanError, match="0 valid points") as raised:
        capture(Scene(planes=()), EYE, FAR, rng=None if generator is None else rng(generator), source="void")
    assert str(raised.value).startswith("void:")
    assert "\n" not in str(raised.value)


def test_a_box_in_an_empty_world_has_sky_around_it() -> None:
    scan = capture(Scene((BOX,), planes=()), corner_view(BOX), replace(FAR, flying_filter=0.03), rng=rng())
    assert_sane(scan)
    assert 0.05 < len(scan.points) / scan.amplitude.size < 0.5  # type: ignore[union-attr]


def test_edges_against_the_sky_do_not_mix() -> None:
    """Half a pixel of sky brings no light: the range is the box's own, continued to the pixel's ray.

    2 cm: by a third of a pixel of 5 mrad on the top, seen under 11 degrees, 1.37 m away, it is 13 mm.
    """
    scene, view = Scene((BOX,), planes=()), corner_view(BOX, elevation_deg=20)
    found = capture(scene, view, FAR, rng=rng(), effects=Effects.only("mixing"))
    distance = np.linalg.norm(found.points, axis=1)
    true = true_hits(scene, view, FAR)
    inner = np.isin(found.pixels, np.flatnonzero(np.isfinite(true.ranges)))  # type: ignore[arg-type]
    assert 10 < np.sum(~inner) < 400  # the rim: less than half of the footprint is the box's, and it is seen all the same
    corners = np.linalg.norm(corners_of(BOX) - view[:3, 3], axis=1)
    assert distance.max() < corners.max() + 0.02
    assert distance.min() > true.ranges.min() - 0.02


def test_degenerate_triangles_and_a_mesh_alone() -> None:
    mesh = soup(rng(1), count=60)
    assert_sane(seen(Scene(meshes=(mesh,), planes=()), EYE))
    assert_sane(seen(Scene((BOX,), (mesh,)), corner_view(BOX)))


def test_a_lens_with_distortion_sees_boxes_and_meshes_alike() -> None:
    lens = replace(FAR.intrinsics, distortion=(0.1, -0.05, 0.0, 0.0, 0.0))
    camera = replace(FAR, intrinsics=lens)
    low, high = np.array([-0.2, -0.15, 0.0]), np.array([0.2, 0.15, 0.3])
    view = orbit_pose(np.array([0.0, 0.0, 0.15]), 0.5, 0.6, 1.2)
    solid, mesh = Scene((Box(EYE, high - low),)), Scene(meshes=(block(low, high),))
    images = [np.nan_to_num(capture(scene, view, camera, rng=None).organised()) for scene in (solid, mesh)]
    assert np.mean(np.isclose(*images, atol=1e-9)) > 0.999
    assert_sane(seen(mesh, view, camera))


@pytest.mark.parametrize(("width", "height"), [(100, 1), (1, 100), (11, 10), (37, 53)])
def test_images_of_odd_shapes(width: int, height: int) -> None:
    camera = replace(FAR, intrinsics=Intrinsics(width=width, height=height, fx=60.0, fy=60.0, cx=width / 2, cy=height / 2))
    scan = capture(Scene((BOX,)), corner_view(BOX, elevation_deg=60), replace(camera, flying_filter=0.5), rng=rng())
    assert scan.shape == (height, width)
    assert_sane(scan)


def test_a_camera_right_before_a_surface() -> None:
    assert_sane(seen(Scene(planes=(flat_target(0.002),)), EYE))
    with pytest.raises(ScanError):
        capture(Scene(planes=(flat_target(0.01),)), EYE, replace(FAR, range_min=0.1), rng=rng())

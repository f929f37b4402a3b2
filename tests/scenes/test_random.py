"""Scenes and camera poses: standing boxes, orbits, and random ones that keep to their ranges."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewgain.geometry import inverse, require_rigid, transform
from viewgain.scenes import SceneRanges, orbit_pose, random_box, random_view, standing_box


@given(st.lists(st.floats(0.01, 2), min_size=3, max_size=3), st.floats(-7, 7), st.floats(-1, 1), st.floats(-1, 1))
def test_a_standing_box_stands_where_it_is_put(extents: list[float], yaw: float, x: float, y: float) -> None:
    box = standing_box(np.array(extents), yaw=yaw, at=(x, y))
    corners = box.corners()
    np.testing.assert_allclose(corners[:4, 2], 0, atol=1e-12)
    np.testing.assert_allclose(corners[4:, 2], extents[2], atol=1e-12)
    np.testing.assert_allclose(corners.mean(axis=0), [x, y, extents[2] / 2], atol=1e-12)
    first_side = corners[1] - corners[0]
    np.testing.assert_allclose(first_side, extents[0] * np.array([np.cos(yaw), np.sin(yaw), 0]), atol=1e-12)


@given(st.floats(0, 360), st.floats(-20, 90), st.floats(0.3, 3), st.floats(-180, 180))
def test_an_orbit_pose_sees_its_target_from_the_direction_and_distance_asked_for(
    azimuth: float, elevation: float, distance: float, roll: float
) -> None:
    target = np.array([0.2, -0.1, 0.15])
    camera_to_world = orbit_pose(target, *np.deg2rad([azimuth, elevation]), distance, float(np.deg2rad(roll)))
    require_rigid(camera_to_world, "camera")
    np.testing.assert_allclose(transform(inverse(camera_to_world), target), [0, 0, distance], atol=1e-9)
    away = camera_to_world[:3, 3] - target
    np.testing.assert_allclose(away[2], distance * np.sin(np.deg2rad(elevation)), atol=1e-9)
    if elevation < 89:
        turn = np.rad2deg(np.arctan2(away[1], away[0])) - azimuth
        np.testing.assert_allclose((turn + 180) % 360, 180, atol=1e-6)
        level = orbit_pose(target, *np.deg2rad([azimuth, elevation]), distance)[:3, 0]
        np.testing.assert_allclose(level @ camera_to_world[:3, 0], np.cos(np.deg2rad(roll)), atol=1e-6)


def test_a_positive_roll_turns_the_camera_clockwise_about_its_line_of_sight() -> None:
    rolled = orbit_pose(np.zeros(3), 0.0, 0.0, 1.0, np.pi / 2)
    np.testing.assert_allclose(rolled[:3, 0], [0, 0, -1], atol=1e-12)  # what was right in the image points down


@pytest.mark.parametrize("seed", range(5))
def test_random_scenes_keep_to_their_ranges_and_repeat_with_their_seed(seed: int) -> None:
    ranges = SceneRanges(
        extent=(0.2, 0.3),
        yaw_deg=(10, 20),
        azimuth_deg=(40, 50),
        elevation_deg=(30, 35),
        distance=(1.0, 1.1),
        aim_sd=0.0,
        roll_sd_deg=0.0,
    )
    rng, again = np.random.default_rng(seed), np.random.default_rng(seed)
    box, view = random_box(rng, ranges), None
    view = random_view(rng, box, ranges)
    assert np.all((box.extents >= 0.2) & (box.extents <= 0.3))
    yaw = np.rad2deg(np.arctan2(box.box_to_camera[1, 0], box.box_to_camera[0, 0]))
    assert 10 <= yaw <= 20
    away = view[:3, 3] - box.centre
    assert 1.0 <= np.linalg.norm(away) <= 1.1
    assert 40 <= np.rad2deg(np.arctan2(away[1], away[0])) <= 50
    assert 30 <= np.rad2deg(np.arcsin(away[2] / np.linalg.norm(away))) <= 35
    np.testing.assert_array_equal(random_box(again, ranges).extents, box.extents)
    np.testing.assert_array_equal(random_view(again, box, ranges), view)
    assert not np.allclose(random_box(rng, ranges).extents, box.extents)


def test_aim_and_roll_spread_as_stated() -> None:
    """200 draws: the standard error of a standard deviation is 5 %, three axes together 3 %; 15 % is more than four of them."""
    rng, box, ranges = np.random.default_rng(0), standing_box(np.array([0.3, 0.3, 0.3])), SceneRanges(elevation_deg=(10, 40))
    misses, rolls = [], []
    for _ in range(200):
        view = random_view(rng, box, ranges)
        sight = view[:3, 2]
        offset = box.centre - view[:3, 3]
        misses.append(offset - (offset @ sight) * sight)
        rolls.append(np.rad2deg(np.arcsin(view[2, 0] / np.hypot(view[2, 0], view[2, 1]))))
    np.testing.assert_allclose(np.sqrt(np.mean(np.square(misses).sum(axis=1)) / 2), ranges.aim_sd, rtol=0.15)
    np.testing.assert_allclose(np.std(rolls), ranges.roll_sd_deg, rtol=0.2)

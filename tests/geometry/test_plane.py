"""Planes: least squares, orientation, and the frame of the floor as the camera sees it."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from viewgain.geometry import Plane, fit_plane, floor_to_camera, inverse, pose, require_rigid, rotation_from_rotvec, transform
from viewgain.scenes import orbit_pose

rotvecs = arrays(float, 3, elements=st.floats(-3, 3))


@given(rotvecs, st.floats(0.05, 5), st.integers(0, 1000))
def test_points_of_a_plane_give_it_back_with_the_origin_above(rotvec: np.ndarray, offset: float, seed: int) -> None:
    normal = rotation_from_rotvec(rotvec)[:, 2]
    flat = np.column_stack([np.random.default_rng(seed).uniform(-1, 1, (30, 2)), np.full(30, -offset)])
    plane = fit_plane(flat @ rotation_from_rotvec(rotvec).T)
    np.testing.assert_allclose(plane.normal, normal, atol=1e-9)
    np.testing.assert_allclose(plane.offset, offset, atol=1e-9)


def test_the_fit_is_the_least_squares_one() -> None:
    rng = np.random.default_rng(3)
    points = (
        np.column_stack([rng.uniform(-1, 1, (200, 2)), 2 + 0.1 * rng.normal(size=200)])
        @ rotation_from_rotvec(np.array([0.4, 0.2, 0])).T
    )
    plane = fit_plane(points)
    best = np.sum(plane.height(points) ** 2)
    for _ in range(100):
        normal = plane.normal + 0.02 * rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        other = Plane(normal, plane.offset + 0.02 * rng.normal())
        assert np.sum(other.height(points) ** 2) > best


@given(rotvecs, st.floats(-3, 3))
def test_heights_are_signed_and_flip_with_the_plane(rotvec: np.ndarray, offset: float) -> None:
    plane = Plane(rotation_from_rotvec(rotvec)[:, 0], offset)
    foot = -offset * plane.normal
    points = np.array([foot, foot + 2 * plane.normal, foot - 3 * plane.normal])
    np.testing.assert_allclose(plane.height(points), [0, 2, -3], atol=1e-11)
    np.testing.assert_allclose(plane.flipped().height(points), [0, -2, 3], atol=1e-11)


@given(st.floats(-180, 180), st.floats(-60, 89), st.floats(0.3, 3), st.floats(-50, 50))
def test_the_floor_frame_stands_below_the_camera_with_x_to_its_right(
    azimuth: float, elevation: float, distance: float, roll: float
) -> None:
    """A camera anywhere above the floor, rolled by less than a quarter turn: right stays right in the image."""
    target = np.array([0.3, -0.2, 3.0])
    camera_to_world = orbit_pose(target, *np.deg2rad([azimuth, elevation]), distance, float(np.deg2rad(roll)))
    world_to_camera = inverse(camera_to_world)
    height = camera_to_world[2, 3]
    floor = Plane(world_to_camera[:3, 2], height)
    placing = require_rigid(floor_to_camera(floor), "floor")
    np.testing.assert_allclose(placing[:3, 2], floor.normal, atol=1e-9)
    below = np.array([*camera_to_world[:2, 3], 0.0])
    np.testing.assert_allclose(placing[:3, 3], transform(world_to_camera, below), atol=1e-9)
    np.testing.assert_allclose(floor.height(placing[:3, 3]), 0, atol=1e-9)
    np.testing.assert_allclose(transform(inverse(placing), np.zeros(3)), [0, 0, height], atol=1e-9)
    ahead = transform(inverse(placing), np.array([0.0, 0.0, 1.0]))
    assert abs(ahead[0]) < 1e-9, "the line of sight, laid on the floor, is the y axis"
    assert ahead[1] > 0
    if abs(elevation) < 80:
        assert placing[0, 0] > 0, "x points to the right in the image"


def test_straight_overhead_the_floor_has_the_axes_of_the_image() -> None:
    placing = floor_to_camera(Plane(np.array([0.0, 0.0, -1.0]), 2.0))
    np.testing.assert_allclose(placing, pose(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 2.0])), atol=1e-12)
    tilted = rotation_from_rotvec(np.array([1e-4, 0.0, 0.0])) @ np.array([0.0, 0.0, -1.0])
    np.testing.assert_allclose(floor_to_camera(Plane(tilted, 2.0)), placing, atol=1e-3)

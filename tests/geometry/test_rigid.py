"""Rigid motions: group laws, rotations against scipy's, cameras that look where they are told, and what is no rigid motion."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from viewgain.errors import ConfigError
from viewgain.geometry import (
    cross_matrix,
    inverse,
    look_at,
    nearest_rotation,
    pose,
    require_rigid,
    rotation_from_rotvec,
    transform,
)  # fmt: skip

ROUNDING = 1e-12
"""A few dozen operations on numbers of size up to 10 in double precision."""

vectors = arrays(float, 3, elements=st.floats(-10, 10))
rotvecs = arrays(float, 3, elements=st.floats(-3, 3))
poses = st.builds(lambda rotvec, shift: pose(rotation_from_rotvec(rotvec), shift), rotvecs, vectors)
clouds = arrays(float, st.tuples(st.integers(0, 5), st.just(3)), elements=st.floats(-10, 10))


@given(poses, clouds)
def test_the_inverse_takes_points_back(a_to_b: np.ndarray, points: np.ndarray) -> None:
    np.testing.assert_allclose(transform(inverse(a_to_b), transform(a_to_b, points)), points, atol=1e-11)
    np.testing.assert_allclose(inverse(a_to_b) @ a_to_b, np.eye(4), atol=1e-11)


@given(poses, poses, clouds)
def test_transforming_twice_is_transforming_by_the_product(b_to_c: np.ndarray, a_to_b: np.ndarray, points: np.ndarray) -> None:
    np.testing.assert_allclose(transform(b_to_c, transform(a_to_b, points)), transform(b_to_c @ a_to_b, points), atol=1e-11)


def test_a_pose_turns_first_and_shifts_then() -> None:
    quarter_turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moved = transform(pose(quarter_turn, np.array([10.0, 0.0, 0.0])), np.array([[1.0, 2.0, 3.0]]))
    np.testing.assert_allclose(moved, [[8.0, 1.0, 3.0]], atol=ROUNDING)


def test_points_keep_their_shape_and_an_empty_cloud_stays_empty() -> None:
    assert transform(np.eye(4), np.empty((0, 3))).shape == (0, 3)
    assert transform(np.eye(4), np.zeros((2, 5, 3))).shape == (2, 5, 3)
    assert transform(np.eye(4), np.zeros(3)).shape == (3,)


@given(rotvecs)
def test_rotations_are_those_of_scipy(rotvec: np.ndarray) -> None:
    np.testing.assert_allclose(rotation_from_rotvec(rotvec), Rotation.from_rotvec(rotvec).as_matrix(), atol=ROUNDING)


@example(np.array([3e-13, -2e-13, 0.0]))
@given(arrays(float, 3, elements=st.floats(-1e-9, 1e-9)))
def test_tiny_rotations_keep_their_first_order(rotvec: np.ndarray) -> None:
    """The derivatives of the whole package are steps of this size; a rotation lost to rounding would be a zero derivative."""
    np.testing.assert_allclose(rotation_from_rotvec(rotvec) - np.eye(3), cross_matrix(rotvec), atol=1e-17, rtol=1e-6)


@given(vectors, vectors)
def test_the_cross_matrix_is_the_cross_product(v: np.ndarray, w: np.ndarray) -> None:
    np.testing.assert_allclose(cross_matrix(v) @ w, np.cross(v, w), atol=1e-11)


@given(rotvecs, arrays(float, (3, 3), elements=st.floats(-0.2, 0.2)))
def test_the_nearest_rotation_is_a_rotation_and_no_worse_than_the_true_one(rotvec: np.ndarray, error: np.ndarray) -> None:
    truth = rotation_from_rotvec(rotvec)
    found = nearest_rotation(truth + error)
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=ROUNDING)
    assert np.linalg.det(found) > 0
    assert np.linalg.norm(found - truth - error) <= np.linalg.norm(error) + ROUNDING


def test_the_nearest_rotation_to_a_reflection_is_still_a_rotation() -> None:
    found = nearest_rotation(np.diag([1.0, 1.0, -0.5]))
    np.testing.assert_allclose(found, np.eye(3), atol=ROUNDING)


@given(vectors, vectors)
def test_a_camera_looks_at_its_target_upright(eye: np.ndarray, target: np.ndarray) -> None:
    sight = target - eye
    if np.linalg.norm(sight) < 1e-3:
        return
    up = np.array([0.0, 0.0, 1.0])
    camera_to_world = look_at(eye, target, up)
    seen = transform(inverse(camera_to_world), target)
    np.testing.assert_allclose(seen, [0, 0, np.linalg.norm(sight)], atol=1e-9)
    np.testing.assert_allclose(camera_to_world[:3, 3], eye, atol=0)
    rotation = camera_to_world[:3, :3]
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(rotation) > 0
    level = np.linalg.norm(np.cross(sight, up)) / np.linalg.norm(sight)
    if level > 1e-3:
        assert abs(rotation[2, 0]) < 1e-9, "x, to the right in the image, is level"
        assert rotation[2, 1] < 0, "y, down in the image, points down in the world"


@pytest.mark.parametrize(("target", "up"), [
    ([0, 0, 0], [0, 0, 1]), ([0, 0, 9], [0, 0, 1]), ([3, 0, 3], [1, 0, 0]), ([0, -4, 3], [0, 1, 0]),
])  # fmt: skip
def test_a_camera_can_look_along_up(target: list[float], up: list[float]) -> None:
    eye = np.array([0.0, 0.0, 3.0])
    camera_to_world = look_at(eye, np.array(target, dtype=float), np.array(up, dtype=float))
    assert require_rigid(camera_to_world, "camera").shape == (4, 4)
    seen = transform(inverse(camera_to_world), np.array(target, dtype=float))
    np.testing.assert_allclose(seen, [0, 0, np.linalg.norm(np.array(target) - eye)], atol=ROUNDING)


def test_straight_down_image_up_is_the_world_x_axis() -> None:
    camera_to_world = look_at(np.array([0.0, 0.0, 2.0]), np.zeros(3), np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(-camera_to_world[:3, 1], [1, 0, 0], atol=ROUNDING)


def test_a_camera_cannot_look_at_itself() -> None:
    with pytest.raises(ConfigError, match="eye and target are the same point"):
        look_at(np.ones(3), np.ones(3), np.array([0.0, 0.0, 1.0]))


@given(poses)
def test_rigid_motions_are_accepted_as_they_are(a_to_b: np.ndarray) -> None:
    np.testing.assert_allclose(require_rigid(a_to_b, "pose"), a_to_b, atol=ROUNDING)


def test_a_rotation_rounded_to_three_digits_is_put_right() -> None:
    rounded = pose(np.round(rotation_from_rotvec(np.array([0.3, -0.4, 0.5])), 4), np.array([1.0, 2.0, 3.0]))
    rotation = require_rigid(rounded, "pose")[:3, :3]
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=ROUNDING)
    np.testing.assert_allclose(rotation, rounded[:3, :3], atol=2e-4)


def changed(row: int, column: int, value: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[row, column] = value
    return matrix


@pytest.mark.parametrize(
    "matrix",
    [np.eye(3), np.zeros((4, 4)), changed(2, 2, -1), changed(0, 0, 1.01), changed(0, 1, 0.1), changed(0, 3, np.nan),
     changed(1, 3, np.inf), changed(3, 0, 1.0), changed(3, 3, 2.0), np.ones((2, 4, 4)), 2 * np.eye(4)],
)  # fmt: skip
def test_what_is_no_rigid_motion_is_refused_by_name(matrix: np.ndarray) -> None:
    with pytest.raises(ConfigError, match="the pose of arm 7") as caught:
        require_rigid(matrix, "the pose of arm 7")
    assert "\n" not in str(caught.value)

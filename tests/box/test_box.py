"""The box as a shape: corners, floor, small steps, and small motions in two frames."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.box.cases import boxes
from tests.oracles.derivatives import along_steps
from tests.oracles.rays import corners_of
from viewgain.box import FACES, FLOOR, PARAMETERS, PLANE_NORMALS, Box, adjoint
from viewgain.geometry import inverse, pose, rotation_from_rotvec, transform

rotvecs = arrays(float, 3, elements=st.floats(-3, 3))
shifts = arrays(float, 3, elements=st.floats(-2, 2))
poses = st.builds(lambda rotvec, shift: pose(rotation_from_rotvec(rotvec), shift), rotvecs, shifts)


def box_by_hand() -> Box:
    return Box(np.eye(4), np.array([2.0, 4.0, 6.0]))


def test_a_box_stands_on_its_origin_with_z_up() -> None:
    corners = box_by_hand().corners()
    np.testing.assert_allclose(corners.min(axis=0), [-1, -2, 0])
    np.testing.assert_allclose(corners.max(axis=0), [1, 2, 6])
    np.testing.assert_allclose(box_by_hand().centre, [0, 0, 3])
    assert box_by_hand().volume == 48
    assert len({tuple(corner) for corner in corners}) == 8


@given(boxes)
def test_corners_are_those_of_the_pose_and_the_extents(box: Box) -> None:
    np.testing.assert_allclose(box.corners(), corners_of(box), atol=1e-12)
    np.testing.assert_allclose(box.corners().mean(axis=0), box.centre, atol=1e-12)


@given(boxes)
def test_the_floor_carries_the_bottom_corners_and_has_the_others_above(box: Box) -> None:
    height = box.floor.height(box.corners())
    np.testing.assert_allclose(height, np.repeat([0, box.extents[2]], 4), atol=1e-12)


@given(boxes)
def test_each_face_plane_carries_four_corners_and_has_the_box_behind_it(box: Box) -> None:
    local = transform(inverse(box.box_to_camera), box.corners())
    for face in range(FLOOR):
        along = local @ PLANE_NORMALS[face]
        front = along > along.max() - 1e-9
        assert front.sum() == 4
        assert FACES[face] == "top" or FACES[face] == ("+-"[face % 2] + "xy"[face // 2])
    np.testing.assert_allclose(PLANE_NORMALS[FLOOR], [0, 0, 1])


@given(boxes, poses)
def test_another_frame_moves_the_box_rigidly(box: Box, camera_to_other: np.ndarray) -> None:
    other = box.in_frame(camera_to_other)
    np.testing.assert_allclose(other.corners(), transform(camera_to_other, box.corners()), atol=1e-11)
    np.testing.assert_array_equal(other.extents, box.extents)


@given(boxes)
def test_a_step_is_a_tangent_in_the_boxs_own_frame(box: Box) -> None:
    """First order: a corner moves by w x p + t + (its share of the change of extents), all in the box's axes."""
    rotation = box.box_to_camera[:3, :3]
    slopes = along_steps(lambda moved: moved.corners(), box, 1e-6)
    local = transform(inverse(box.box_to_camera), box.corners())
    unit = local / box.extents
    for k in range(3):
        axis = np.eye(3)[k]
        np.testing.assert_allclose(slopes[:, :, k], np.cross(axis, local) @ rotation.T, atol=1e-8)
        np.testing.assert_allclose(slopes[:, :, 3 + k], np.tile(rotation[:, k], (8, 1)), atol=1e-8)
        np.testing.assert_allclose(slopes[:, :, 6 + k], unit[:, [k]] * rotation[:, k], atol=1e-8)


@given(boxes, arrays(float, 6, elements=st.floats(-1, 1)))
def test_a_motion_and_its_opposite_cancel(box: Box, motion: np.ndarray) -> None:
    there = pose(rotation_from_rotvec(motion[:3]), motion[3:])
    back = inverse(there)
    rotvec_back = -motion[:3]
    moved = box.moved(np.concatenate([motion, np.zeros(3)])).moved(np.concatenate([rotvec_back, back[:3, 3], np.zeros(3)]))
    np.testing.assert_allclose(moved.box_to_camera, box.box_to_camera, atol=1e-11)
    np.testing.assert_array_equal(moved.extents, box.extents)


def test_a_step_of_nothing_is_the_same_box() -> None:
    moved = box_by_hand().moved(np.zeros(PARAMETERS))
    np.testing.assert_array_equal(moved.box_to_camera, np.eye(4))
    np.testing.assert_array_equal(moved.extents, [2, 4, 6])


@given(poses, arrays(float, 6, elements=st.floats(-1, 1)))
def test_the_adjoint_expresses_a_small_motion_in_another_frame(a_to_b: np.ndarray, motion: np.ndarray) -> None:
    """Moving in frame a and changing to b is changing to b and moving by the adjoint there, to first order."""
    small = 1e-6 * motion
    in_a = pose(rotation_from_rotvec(small[:3]), small[3:])
    there = adjoint(a_to_b) @ small
    in_b = pose(rotation_from_rotvec(there[:3]), there[3:])
    np.testing.assert_allclose(a_to_b @ in_a, in_b @ a_to_b, atol=1e-10)  # second order: (1e-6 * 4)^2


@given(poses, poses)
def test_adjoints_multiply_as_the_motions_do(b_to_c: np.ndarray, a_to_b: np.ndarray) -> None:
    np.testing.assert_allclose(adjoint(b_to_c) @ adjoint(a_to_b), adjoint(b_to_c @ a_to_b), atol=1e-10)
    np.testing.assert_allclose(adjoint(inverse(a_to_b)), np.linalg.inv(adjoint(a_to_b)), atol=1e-9)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_growing_an_extent_grows_the_box_both_ways_along_the_floor_and_upwards_only(axis: int) -> None:
    step = np.zeros(PARAMETERS)
    step[6 + axis] = 1.0
    before, after = box_by_hand().corners(), box_by_hand().moved(step).corners()
    low, high = after.min(axis=0) - before.min(axis=0), after.max(axis=0) - before.max(axis=0)
    expected = {0: (-0.5, 0.5), 1: (-0.5, 0.5), 2: (0.0, 1.0)}[axis]
    np.testing.assert_allclose((low[axis], high[axis]), expected)

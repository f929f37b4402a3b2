"""The record of a scene: reflectivities, planes and motion."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.oracles.shapes import box_mesh
from viewgain.errors import ConfigError
from viewgain.geometry import pose, rotation_from_rotvec, transform
from viewgain.scenes import FLOOR, GREY, Scene, standing_box, wall

BOX = standing_box(np.array([0.4, 0.3, 0.2]))


def test_reflectivity_is_grey_unless_said_and_in_the_order_of_the_bodies() -> None:
    mesh = box_mesh(BOX)
    np.testing.assert_array_equal(Scene((BOX,), (mesh,)).body_reflectivity, [GREY] * 3)
    np.testing.assert_array_equal(Scene((BOX,), (mesh,), reflectivity=(0.1, 0.2, 0.3)).body_reflectivity, [0.1, 0.2, 0.3])


@pytest.mark.parametrize("wrong", [(0.5,), (0.5, 0.5, 0.5), (0.0, 0.5), (1.2, 0.5), (np.nan, 0.5), (-0.1, 0.5)])
def test_reflectivities_that_make_no_sense_are_refused(wrong: tuple[float, ...]) -> None:
    with pytest.raises(ConfigError, match="scene"):
        Scene((BOX,), reflectivity=wrong)


@given(st.floats(-7, 7), st.floats(0.1, 5))
def test_a_wall_stands_at_its_distance_and_faces_the_origin(azimuth: float, distance: float) -> None:
    plane = wall(azimuth, distance)
    foot = distance * np.array([np.cos(azimuth), np.sin(azimuth), 0.3])
    assert plane.height(np.zeros(3)) == pytest.approx(distance)
    assert plane.height(foot * [1, 1, 0] + [0, 0, 2.0]) == pytest.approx(0, abs=1e-9)
    assert plane.normal[2] == 0


@given(st.tuples(*[st.floats(-3, 3)] * 6))
def test_moving_a_scene_moves_every_body_alike(motion: tuple[float, ...]) -> None:
    move = pose(rotation_from_rotvec(np.array(motion[:3])), np.array(motion[3:]))
    scene = Scene((BOX,), (box_mesh(BOX),), (FLOOR, wall(1.0, 2.0)), (0.1, 0.2, 0.3, 0.4))
    moved, points = scene.moved(move), np.random.default_rng(0).normal(size=(5, 3))
    np.testing.assert_allclose(moved.boxes[0].corners(), transform(move, BOX.corners()), atol=1e-12)
    np.testing.assert_allclose(moved.meshes[0].vertices, transform(move, scene.meshes[0].vertices), atol=1e-12)
    for before, after in zip(scene.planes, moved.planes, strict=True):
        np.testing.assert_allclose(after.height(transform(move, points)), before.height(points), atol=1e-9)
    assert moved.reflectivity == scene.reflectivity

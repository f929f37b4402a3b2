"""Jitter: inside its bounds, repeatable, and the rotation is Blender's."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.rigs.cameras import EYE, UP, orbit, seen_from, turn
from viewgain.errors import ConfigError
from viewgain.geometry import inverse
from viewgain.rigs import RIGS, Jitter, Rig, Station, Target, place, poses, rig
from viewgain.rigs._place import turned

BOX = Target.at(np.array([0.3, -0.2, 0.25]), np.array([0.6, 0.3, 0.5]), yaw=0.4)
FLIP = np.diag([1.0, -1.0, -1.0])
SEEDS = st.integers(0, 2**32)


def blender_angles(camera: np.ndarray) -> np.ndarray:
    """(3,) XYZ Euler angles that Blender would show: rotations about the world's x, then y, then z, of a camera with y up."""
    return np.asarray(Rotation.from_matrix(camera[:3, :3] @ FLIP).as_euler("xyz"))


@given(SEEDS, st.sampled_from(sorted(RIGS)))
def test_a_seed_reproduces_every_bit_and_no_generator_is_no_jitter(seed: int, name: str) -> None:
    options = {"elevation": 0.6, "distance": 1.0}
    one, other = (poses(rig(name), BOX, rng=np.random.default_rng(seed), **options) for _ in range(2))
    np.testing.assert_array_equal(one, other)
    exact = poses(rig(name), BOX, **options)
    still = poses(replace(rig(name), jitter=Jitter()), BOX, rng=np.random.default_rng(seed), **options)
    np.testing.assert_array_equal(still, exact)
    assert np.allclose(one, exact) == (rig(name).jitter == Jitter())


@given(SEEDS)
def test_the_irregular_four_stay_within_their_degrees_and_per_cent(seed: int) -> None:
    exact = np.array([seen_from(BOX.centre, camera) for camera in poses(rig("irregular4"), BOX)])
    found = np.array([seen_from(BOX.centre, camera) for camera in poses(rig("irregular4"), BOX, rng=np.random.default_rng(seed))])
    assert np.all(np.abs((found[:, 0] - exact[:, 0] + 180) % 360 - 180) <= 5 + 1e-9)
    assert np.all(np.abs(found[:, 1] - exact[:, 1]) <= 3 + 1e-9)
    assert np.all(np.abs(found[:, 2] / exact[:, 2] - 1) <= 0.05 + 1e-9)


@given(SEEDS)
def test_the_paper_stays_within_its_centimetres_and_radians(seed: int) -> None:
    """The position along the sides of the box, the rotation by Blender's angles."""
    jitter = rig("paper4").jitter
    shaken = poses(rig("paper4"), BOX, rng=np.random.default_rng(seed))
    shift = (shaken - poses(rig("paper4"), BOX))[:, :3, 3] @ BOX.target_to_world[:3, :3]
    low, high = np.transpose(jitter.position)
    assert np.all((shift >= low - 1e-12) & (shift <= high + 1e-12))
    steady = replace(rig("paper4"), jitter=replace(jitter, rotation=Jitter().rotation))
    aimed = poses(steady, BOX, rng=np.random.default_rng(seed))
    np.testing.assert_array_equal(aimed[:, :3, 3], shaken[:, :3, 3])  # one bound changed leaves the other draws alone
    low, high = np.transpose(jitter.rotation)
    for camera, upright in zip(shaken, aimed, strict=True):
        added = blender_angles(camera) - blender_angles(upright)
        added[2] = (added[2] + np.pi) % (2 * np.pi) - np.pi
        assert np.all((added >= low - 1e-9) & (added <= high + 1e-9))


def test_all_of_the_bounds_is_used_evenly() -> None:
    """Of 4000 cameras: a uniform mean is within 4 of its standard errors, and the ends are nearly reached."""
    jitter = rig("paper4").jitter
    moving = np.ptp(jitter.bounds, axis=1) > 0
    low, high = jitter.bounds[moving].T
    shares = (jitter.draw(4000, np.random.default_rng(7))[:, moving] - low) / (high - low)
    assert np.sum(moving) == 9
    np.testing.assert_allclose(shares.mean(axis=0), 0.5, atol=4 / np.sqrt(12 * 4000))
    assert np.all((shares >= 0) & (shares <= 1))
    assert shares.min(axis=0).max() < 0.01
    assert shares.max(axis=0).min() > 0.99


def test_the_aim_moves_along_the_sides_of_the_box_and_the_camera_stays() -> None:
    shift = np.array([0.05, -0.02, 0.08])
    missed = replace(rig("paper4"), jitter=Jitter(aim=tuple((value, value) for value in shift)))
    aim = BOX.top_corner(0) + BOX.target_to_world[:3, :3] @ shift
    found, exact = poses(missed, BOX, rng=np.random.default_rng(0)), poses(rig("paper4"), BOX)
    np.testing.assert_array_equal(found[:, :3, 3], exact[:, :3, 3])
    for camera in found:
        sight = aim - camera[:3, 3]
        np.testing.assert_allclose(camera[:3, 2], sight / np.linalg.norm(sight), atol=1e-12)


@given(st.floats(-3, 3), st.floats(-1.4, 1.4), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_the_rotation_is_added_to_blenders_angles(azimuth: float, elevation: float, x: float, y: float, z: float) -> None:
    camera = orbit(np.zeros(3), azimuth, elevation, 1.0)[:3, :3]
    angles = blender_angles(camera) + np.array([x, y, z])
    np.testing.assert_allclose(
        turned(camera, np.array([x, y, z])), Rotation.from_euler("xyz", angles).as_matrix() @ FLIP, atol=1e-9
    )


def test_x_tilts_up_y_rolls_and_z_pans_left() -> None:
    level = orbit(np.zeros(3), np.pi, 0.0, 1.0)[:3, :3]  # looks along +x, level; its right is -y
    ahead, right = np.array([1.0, 0.0, 0.0]), np.array([0.0, -1.0, 0.0])
    assert turned(level, np.array([0.1, 0.0, 0.0]))[2, 2] == pytest.approx(np.sin(0.1))
    rolled = turned(level, np.array([0.0, 0.1, 0.0]))
    np.testing.assert_allclose(rolled[:, 2], ahead, atol=1e-12)
    assert abs(rolled[2, 0]) == pytest.approx(np.sin(0.1))
    assert turned(level, np.array([0.0, 0.0, 0.1]))[:, 2] @ right == pytest.approx(-np.sin(0.1))


def test_a_camera_on_its_side_can_be_turned_too() -> None:
    side = np.column_stack([-UP, np.cross(np.array([1.0, 0.0, 0.0]), -UP), [1.0, 0.0, 0.0]])
    np.testing.assert_allclose(turned(side, np.array([0.0, 0.0, 1e-15])), side, atol=1e-9)


@given(SEEDS, st.floats(-np.pi, np.pi))
def test_anchored_and_in_the_world_share_their_jitter(seed: int, azimuth: float) -> None:
    camera = orbit(BOX.centre, azimuth, 0.6, 1.1)
    shaky = replace(rig("ring8"), jitter=rig("paper4").jitter)
    one = camera @ place(shaky, BOX, inverse(camera), camera, rng=np.random.default_rng(seed))
    other = poses(shaky, BOX, azimuth=azimuth, elevation=0.6, distance=1.1, rng=np.random.default_rng(seed))
    np.testing.assert_allclose(one, other, atol=1e-8)


def test_a_pose_of_its_own_is_moved_and_turned_only() -> None:
    there = orbit(BOX.centre, 1.0, 0.5, 1.2)
    wide = Jitter(azimuth=(1.0, 1.0), distance=(0.5, 0.5), position=((0.1, 0.1), (0.0, 0.0), (0.0, 0.0)), aim=((1.0, 1.0),) * 3,
                  rotation=((0.0, 0.0), (0.0, 0.0), (0.2, 0.2)))  # fmt: skip
    (found,) = poses(Rig(name="t", stations=(Station(camera_to_world=there),), jitter=wide), BOX, rng=np.random.default_rng(0))
    np.testing.assert_allclose(found[:3, 3], there[:3, 3] + 0.1 * BOX.target_to_world[:3, 0], atol=1e-12)
    np.testing.assert_allclose(found[:3, :3], (turn(0.2) @ there)[:3, :3], atol=1e-12)
    np.testing.assert_allclose(EYE, np.eye(4))  # nobody wrote into what they were given


@pytest.mark.parametrize(
    "bounds",
    [{"azimuth": (0.1, -0.1)}, {"elevation": (0.0, np.inf)}, {"distance": (-1.0, 0.0)}, {"aim": ((0.0, np.nan),) * 3}],
    ids=str,
)
def test_senseless_bounds_are_refused(bounds: dict[str, object]) -> None:
    with pytest.raises(ConfigError, match="jitter"):
        Jitter(**bounds)


def test_the_bounds_are_in_the_order_of_the_fields() -> None:
    names = [field.name for field in fields(Jitter)]
    assert names == ["azimuth", "elevation", "distance", "position", "aim", "rotation"]
    np.testing.assert_array_equal(Jitter(rotation=((0, 0), (0, 0), (0, 1))).bounds[11], [0, 1])
    assert Jitter().bounds.shape == (12, 2)

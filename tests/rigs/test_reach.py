"""Where a camera may stand: each limit by hand, and cones that stay where the world has them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.rigs.cameras import EYE, UP, direction, turn
from viewgain.errors import ConfigError
from viewgain.geometry import inverse, pose
from viewgain.rigs import KeepOut, Rig, Station, Target, poses, refusals, rig

BOX = Target.at(np.array([0.0, 0.0, 0.1]), np.array([0.4, 0.3, 0.2]))


def at(*places: tuple[float, float, float]) -> np.ndarray:
    return np.stack([pose(np.eye(3), np.array(place)) for place in places])


def cell(**limits: object) -> Rig:
    return Rig(name="cell", stations=(Station(),), **limits)


def test_distance_counts_to_the_surface_and_height_from_the_floor_by_hand() -> None:
    """Faces at x = 0.2, y = 0.15, z = 0.2; the third camera is off a corner, (0.3, 0.4, 0) away from it: 0.5 m."""
    cameras = at((0.5, 0.0, 0.1), (0.0, 0.0, 0.6), (0.5, 0.55, 0.2), (0.0, 0.0, 0.1))
    near = {0.29: [None] * 3, 0.31: ["too near", None, None], 0.41: ["too near", "too near", None], 0.51: ["too near"] * 3}
    for limit, expected in near.items():
        assert list(refusals(cell(min_distance=limit), cameras, BOX)) == [*expected, "too near"]
    far = {0.49: [None, None, "too far"], 0.39: [None, "too far", "too far"], 0.51: [None] * 3}
    for limit, expected in far.items():
        assert list(refusals(cell(min_distance=0.1, max_distance=limit), cameras, BOX)) == [*expected, "too near"]
    heights = refusals(cell(min_height=0.15, max_height=0.5), cameras, BOX)
    assert heights == ("too low", "too high", None, "too near")


def test_a_point_has_distance_to_itself() -> None:
    spot = Target.at(np.array([0.0, 0.0, 0.5]))
    assert refusals(cell(min_distance=0.4), at((0.0, 0.0, 0.89), (0.0, 0.0, 0.91)), spot) == ("too near", None)


def test_without_limits_of_its_own_a_rig_has_the_defaults() -> None:
    cameras = at((0.0, 0.0, 0.44), (0.0, 0.0, 0.46), (1.0, 0.0, 0.04), (0.0, 0.0, 99.0))
    assert refusals(cell(), cameras, BOX) == ("too near", None, "too low", None)
    below = poses(rig("pcnbv33"), BOX, distance=1.0)[25:]
    assert set(refusals(rig("pcnbv33"), below, BOX)) == {"too low"}


@given(st.floats(0.05, 3.0), st.floats(-np.pi, np.pi), st.floats(-1.5, 1.5))
def test_a_cone_keeps_out_exactly_its_directions(half_angle: float, azimuth: float, elevation: float) -> None:
    axis = 3.0 * direction(0.7, 0.4)
    towards = direction(azimuth, elevation)
    angle = np.arccos(np.clip(towards @ axis / 3.0, -1, 1))
    if abs(angle - half_angle) < 1e-6:
        return
    stays = cell(keep_out=(KeepOut(axis=axis, half_angle=half_angle),), min_height=-9.0)
    (reason,) = refusals(stays, at(tuple(BOX.centre + 2.0 * towards)), BOX)
    assert (reason == "kept out") == (angle < half_angle)


def test_a_cone_may_stand_anywhere_and_there_may_be_several() -> None:
    mount = KeepOut(axis=-UP, half_angle=np.deg2rad(30), apex=np.array([0.0, 0.0, 2.0]))
    base = KeepOut(axis=np.array([-1.0, 0.0, 0.0]), half_angle=np.deg2rad(45))
    cameras = at((0.0, 0.0, 1.0), (0.56, 0.0, 1.0), (0.59, 0.0, 1.0), (0.0, 0.0, 2.1), (-1.0, 0.1, 0.5))
    assert refusals(cell(keep_out=(mount, base)), cameras, BOX) == ("kept out", "kept out", None, None, "kept out")


@given(st.floats(-np.pi, np.pi))
def test_cones_stay_in_the_world_when_the_floor_has_a_frame_of_its_own(angle: float) -> None:
    floor_to_world = turn(angle, np.array([1.0, 2.0, 0.3]))
    cones = (
        KeepOut(axis=direction(0.3, 0.2), half_angle=0.6),
        KeepOut(axis=direction(-2.0, 0.1), half_angle=0.4, apex=np.array([0.2, 0.1, 0.4])),
    )
    cameras = poses(rig("hemisphere60"), Target(EYE, BOX.extents), distance=1.0)
    in_world = Target(EYE, BOX.extents)
    expected = refusals(cell(keep_out=cones, min_height=-9.0), cameras, in_world)
    assert {None, "kept out"} == set(expected)
    in_floor = Target(inverse(floor_to_world), BOX.extents)
    found = refusals(
        cell(keep_out=cones, min_height=-9.0), inverse(floor_to_world) @ cameras, in_floor, floor_to_world=floor_to_world
    )
    assert found == expected


def test_without_a_world_only_vertical_cones_at_the_target_are_known() -> None:
    overhead = at((0.0, 0.0, 1.0), (1.0, 0.0, 0.5))
    ceiling = KeepOut(axis=UP, half_angle=0.3)
    assert refusals(cell(keep_out=(ceiling,)), overhead, BOX, floor_to_world=None) == ("kept out", None)
    for cone in (KeepOut(axis=UP, half_angle=0.3, apex=np.zeros(3)), KeepOut(axis=np.array([1.0, 0.0, 0.0]), half_angle=0.3)):
        with pytest.raises(ConfigError, match=r"cell.*camera_to_world"):
            refusals(cell(keep_out=(cone,)), overhead, BOX, floor_to_world=None)


@pytest.mark.parametrize(
    "values",
    [{"axis": np.zeros(3)}, {"axis": np.ones(2)}, {"axis": np.array([np.nan, 0, 1])}, {"half_angle": 0.0}, {"half_angle": 4.0},
     {"apex": np.ones(4)}, {"apex": np.array([np.inf, 0, 0])}],
    ids=str,
)  # fmt: skip
def test_a_senseless_cone_is_refused(values: dict[str, object]) -> None:
    with pytest.raises(ConfigError, match="cone"):
        KeepOut(**{"axis": UP, "half_angle": 0.5, **values})


@pytest.mark.parametrize(
    "limits",
    [{"min_distance": np.nan}, {"min_height": np.inf}, {"max_distance": 0.2}, {"max_height": np.nan}, {"stations": ()}],
    ids=str,
)
def test_senseless_limits_are_refused(limits: dict[str, object]) -> None:
    with pytest.raises(ConfigError, match="rig t"):
        Rig(**{"name": "t", "stations": (Station(),), **limits})

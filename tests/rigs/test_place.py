"""Where stations stand: anchored at a camera, or in the world; both the same geometry."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.rigs.cameras import EYE, UP, orbit, seen_from, turn
from viewgain.errors import ConfigError
from viewgain.geometry import inverse, look_at, pose, require_rigid, rotation_from_rotvec, transform
from viewgain.rigs import RIGS, Rig, Station, Target, place, poses, rig

POINT = np.array([0.3, -0.2, 0.25])
"""World."""
SPOT = Target.at(POINT)
BOX = Target.at(POINT, np.array([0.6, 0.3, 0.5]), yaw=0.4)
SIZED = [name for name in sorted(RIGS) if name != "paper4_unnormalised"]
"""Presets that need no extents."""
ANGLE = st.floats(-np.pi, np.pi)


def placed(stations: Rig, camera: np.ndarray, target: Target = SPOT, **options: float) -> np.ndarray:
    """The stations' poses in the world, for a camera (world, floor z = 0)."""
    return np.asarray(camera @ place(stations, target, inverse(camera), camera, **options))


@given(ANGLE, st.floats(0.1, 1.4), st.floats(0.5, 2), st.floats(-0.5, 0.5), st.floats(-0.2, 0.2), st.sampled_from(SIZED))
def test_every_station_is_a_camera_that_looks_at_the_target_upright(
    azimuth: float, elevation: float, distance: float, roll: float, aside: float, name: str
) -> None:
    camera = orbit(POINT, azimuth, elevation, distance) @ pose(rotation_from_rotvec(np.array([aside, -aside, roll])), np.zeros(3))
    for station in placed(rig(name), camera):
        require_rigid(station, "station")
        seen = transform(inverse(station), POINT)
        np.testing.assert_allclose(seen[:2], 0, atol=1e-9)
        assert seen[2] > 0.1
        if seen_from(POINT, station)[1] < 89:
            np.testing.assert_allclose(station[2, 0], 0, atol=1e-9, err_msg="level")
            assert station[2, 1] < 0


@given(ANGLE, st.floats(0.2, 1.4), st.floats(0.5, 2), st.sampled_from(["ring8", "ring5"]))
def test_the_ring_keeps_height_and_distance_and_starts_where_the_camera_is(
    azimuth: float, elevation: float, distance: float, name: str
) -> None:
    camera = orbit(POINT, azimuth, elevation, distance)
    stations = placed(rig(name), camera)
    np.testing.assert_allclose(stations[0], camera, atol=1e-6)
    np.testing.assert_allclose(stations[:, 2, 3], camera[2, 3], atol=1e-9)
    around = [seen_from(POINT, station) for station in stations]
    np.testing.assert_allclose([each[2] for each in around], distance, rtol=1e-9)
    steps = np.diff([each[0] for each in around]) % 360
    np.testing.assert_allclose(steps, 360 / len(stations), atol=1e-6)  # anticlockwise from above: to the camera's right


def test_a_low_camera_is_lifted_to_ten_degrees() -> None:
    for station in placed(rig("ring8"), orbit(POINT, 0.3, np.deg2rad(2), 1.0)):
        np.testing.assert_allclose(seen_from(POINT, station)[1], 10, atol=1e-9)


def test_positive_azimuth_is_to_the_right_of_the_camera() -> None:
    camera = orbit(POINT, 0.4, 0.5, 1.0)
    (station,) = placed(Rig(name="t", stations=(Station(azimuth=0.2),)), camera)
    assert (inverse(camera) @ station)[0, 3] > 0.1


@given(ANGLE, st.floats(0.1, 1.4))
def test_around_a_point_the_papers_stations_keep_the_present_azimuth(azimuth: float, elevation: float) -> None:
    """Horizontal offset d and height d tan(180 / 3.5) or d tan(180 / 2.9) degrees over the target, d = 1 and 1.3 m."""
    offsets = placed(rig("paper4"), orbit(POINT, azimuth, elevation, 1.0))[:, :3, 3] - POINT
    level = np.array([np.cos(azimuth), np.sin(azimuth)])
    np.testing.assert_allclose(offsets[:, :2], np.outer([1, 1, 1.3, 1.3], level), atol=1e-9)
    np.testing.assert_allclose(offsets[:, 2], [d * np.tan(np.pi / part) for d in (1, 1.3) for part in (3.5, 2.9)], rtol=1e-9)


@given(ANGLE)
def test_beside_a_box_the_papers_stations_take_the_corner_that_faces_the_camera(azimuth: float) -> None:
    camera = orbit(POINT, azimuth, 0.6, 1.5)
    corners = np.array([BOX.top_corner(k) for k in range(4)])
    gaps = np.sort(np.linalg.norm(corners - camera[:3, 3], axis=1))
    if gaps[1] - gaps[0] < 1e-6:
        return  # head-on: either will do
    nearest = corners[np.argmin(np.linalg.norm(corners - camera[:3, 3], axis=1))]
    for station in placed(rig("paper4"), camera, BOX):
        sight = nearest - station[:3, 3]
        np.testing.assert_allclose(station[:3, 2], sight / np.linalg.norm(sight), atol=1e-9)
        away, diagonal = station[:2, 3] - BOX.centre[:2], nearest[:2] - BOX.centre[:2]
        np.testing.assert_allclose(away / np.linalg.norm(away), diagonal / np.linalg.norm(diagonal), atol=1e-9)


def test_the_corners_of_a_target_go_round_anticlockwise() -> None:
    corners = np.array([Target.at(POINT, BOX.extents).top_corner(k) for k in range(5)]) - POINT
    np.testing.assert_allclose(corners[:4], [(0.3, 0.15, 0.25), (-0.3, 0.15, 0.25), (-0.3, -0.15, 0.25), (0.3, -0.15, 0.25)])
    np.testing.assert_allclose(corners[4], corners[0])


@pytest.mark.parametrize("target", [SPOT, BOX], ids=["point", "box"])
def test_the_corners_of_a_rig_go_round_from_the_first(target: Target) -> None:
    """In the world the first is the target's own (+x, +y); a point has no diagonals but quarter turns from the azimuth."""
    stations = Rig(name="t", stations=tuple(Station(corner=k, elevation=0.5, distance=1.0) for k in range(4)))
    away = poses(stations, target, azimuth=0.9)[:, :3, 3] - target.centre
    flat = np.arctan2(BOX.extents[1], BOX.extents[0])
    expected = 0.9 + np.arange(4) * np.pi / 2 if target is SPOT else 0.4 + np.array([flat, np.pi - flat, np.pi + flat, -flat])
    np.testing.assert_allclose(np.cos(np.arctan2(away[:, 1], away[:, 0]) - expected), 1, atol=1e-12)


@pytest.mark.parametrize("name", SIZED)
def test_a_camera_straight_overhead_has_stations_too(name: str) -> None:
    camera = look_at(POINT + 1.2 * UP, POINT, np.array([0.0, 1.0, 0.0]))
    stations = placed(rig(name), camera)
    assert np.all(np.isfinite(stations))
    for station in stations:
        require_rigid(station, "station")
    if name == "ring8":
        np.testing.assert_allclose(stations[0], camera, atol=1e-6)


def test_stations_keep_what_they_do_not_state_and_step_back_on_demand() -> None:
    camera = orbit(POINT, 0.4, np.deg2rad(40), 1.0)
    stations = (
        Station(azimuth=1.0),
        Station(elevation=0.3),
        Station(distance=0.8),
        Station(azimuth=0.5, elevation=1.0, distance=2.0),
    )
    for factor in (1.0, 1.5):
        found = [seen_from(POINT, station) for station in placed(Rig(name="t", stations=stations), camera, step_back=factor)]
        degrees = np.rad2deg(0.4)
        expected = [
            (degrees + np.rad2deg(1.0), 40, factor), (degrees, np.rad2deg(0.3), factor), (degrees, 40, 0.8),
            (degrees + np.rad2deg(0.5), np.rad2deg(1.0), 2.0),
        ]  # fmt: skip
        np.testing.assert_allclose(found, expected, atol=1e-6)


@given(ANGLE, st.floats(0.2, 1.4), st.floats(0.5, 2), ANGLE, st.sampled_from(sorted(RIGS)), st.booleans())
def test_turning_target_and_world_together_turns_the_poses(
    azimuth: float, elevation: float, distance: float, angle: float, name: str, jittered: bool
) -> None:
    motion = turn(angle, np.array([1.0, -2.0, 0.3]))
    moved = Target(motion @ BOX.target_to_world, BOX.extents)
    options = {"elevation": elevation, "distance": distance}
    here = poses(rig(name), BOX, azimuth=azimuth, rng=np.random.default_rng(1) if jittered else None, **options)
    there = poses(rig(name), moved, azimuth=azimuth + angle, rng=np.random.default_rng(1) if jittered else None, **options)
    np.testing.assert_allclose(there, motion @ here, atol=1e-8)


@given(ANGLE, st.floats(0.2, 1.4), st.floats(0.5, 2), st.sampled_from(["ring8", "hemisphere7", "pcnbv33"]))
def test_both_entry_points_agree(azimuth: float, elevation: float, distance: float, name: str) -> None:
    camera = orbit(POINT, azimuth, elevation, distance)
    anchored = placed(rig(name), camera, BOX)
    np.testing.assert_allclose(
        poses(rig(name), BOX, azimuth=azimuth, elevation=elevation, distance=distance), anchored, atol=1e-8
    )


@given(ANGLE, ANGLE)
def test_an_absolute_rig_stays_where_it_is_wherever_the_camera_stands(azimuth: float, angle: float) -> None:
    """The floor's frame may lie in the world in any way; the stations are those of the world."""
    camera = orbit(POINT, azimuth, 0.7, 1.1)
    floor_to_world = turn(angle, np.array([3.0, 1.0, 0.5]))
    in_floor = Target(inverse(floor_to_world) @ BOX.target_to_world, BOX.extents)
    found = camera @ place(rig("irregular4"), in_floor, inverse(camera) @ floor_to_world, camera)
    np.testing.assert_allclose(found, poses(rig("irregular4"), BOX), atol=1e-8)


def test_rig_order_is_kept() -> None:
    stations = rig("pcnbv33").stations
    backwards = replace(rig("pcnbv33"), stations=stations[::-1])
    np.testing.assert_array_equal(poses(backwards, BOX, distance=1.0), poses(rig("pcnbv33"), BOX, distance=1.0)[::-1])


def test_stations_with_a_pose_need_the_scans_and_use_it() -> None:
    there = pose(rotation_from_rotvec(np.array([0.0, np.pi, 0.0])), np.array([0.0, 0.0, 1.5]))
    fixed = Rig(name="fixed", stations=(Station(), Station(camera_to_world=there)))
    here = pose(EYE[:3, :3], np.array([1.0, 2.0, 3.0]))
    found = place(fixed, SPOT, turn(0.3, np.array([0.1, 0.2, -0.9])), here)
    np.testing.assert_allclose(here @ found[1], there, atol=1e-12)
    np.testing.assert_allclose(poses(fixed, SPOT, elevation=0.5, distance=1.0)[1], there, atol=1e-12)
    with pytest.raises(ConfigError, match=r"fixed: station 1 .*camera_to_world"):
        place(fixed, SPOT, EYE, None)
    with pytest.raises(ConfigError, match=r"irregular4: .*camera_to_world"):
        place(rig("irregular4"), SPOT, EYE, None)


@pytest.mark.parametrize(
    ("name", "given_values", "missing"),
    [
        ("ring8", {"distance": 1.0}, "elevation"),
        ("ring8", {"elevation": 0.5}, "distance"),
        ("pcnbv16", {"elevation": 0.5}, "distance"),
    ],
)
def test_in_the_world_open_values_must_be_given(name: str, given_values: dict[str, float], missing: str) -> None:
    with pytest.raises(ConfigError, match=missing):
        poses(rig(name), BOX, **given_values)


@pytest.mark.parametrize(
    "values",
    [{"distance": 0.0}, {"distance": np.nan}, {"azimuth": np.inf}, {"elevation": np.nan}, {"corner": 4}, {"unnormalised": True},
     {"camera_to_world": 2 * EYE}, {"camera_to_world": EYE, "azimuth": 1.0}, {"camera_to_world": EYE, "corner": 0}],
    ids=str,
)  # fmt: skip
def test_a_station_that_makes_no_sense_is_refused(values: dict[str, object]) -> None:
    with pytest.raises(ConfigError):
        Station(**values)


@pytest.mark.parametrize("extents", [[1.0, 2.0], [1.0, -0.1, 1.0], [np.nan, 1.0, 1.0]], ids=str)
def test_a_target_of_senseless_extents_is_refused(extents: list[float]) -> None:
    with pytest.raises(ConfigError, match="extents"):
        Target(EYE, np.array(extents))

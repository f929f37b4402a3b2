"""Decisions of the planner that a person can check: which view wins, when to stop, and what never wins."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.oracles.scenes import UNMIXED
from viewgain.camera import sensor
from viewgain.errors import ConfigError
from viewgain.measure import Measurement, measure
from viewgain.plan import NextView, directions_in_words, next_view
from viewgain.rigs import KeepOut, Rig, Station
from viewgain.scans import Scan
from viewgain.scenes import Scene, orbit_pose, standing_box
from viewgain.simulate import capture

CAMERA = sensor("pico_flexx").without_systematic()
TARGET = np.array([0.0, 0.0, 0.1])


def scan_of(
    extents: tuple[float, float, float], azimuth: float, elevation: float, *, distance: float = 1.1, aside: float = 0.0
) -> Scan:
    box = standing_box(np.array(extents))
    camera = orbit_pose(box.centre + np.array([0.0, aside, 0.0]), np.deg2rad(azimuth), np.deg2rad(elevation), distance)
    return capture(Scene((box,)), camera, CAMERA, rng=np.random.default_rng(1), effects=UNMIXED)


@pytest.fixture(scope="module")
def seen_well() -> Measurement:
    return measure(scan_of((0.4, 0.3, 0.2), 40, 38), camera=CAMERA)


@pytest.fixture(scope="module")
def plan(seen_well: Measurement) -> NextView:
    return next_view(seen_well, camera=CAMERA)


def test_candidate_zero_is_the_present_place_and_all_look_at_the_target(plan: NextView) -> None:
    for candidate in plan.candidates:
        to_target = plan.target - candidate.camera_to_current[:3, 3]
        assert np.allclose(candidate.camera_to_current[:3, 2], to_target / np.linalg.norm(to_target), atol=1e-9)
        assert np.linalg.norm(to_target) == pytest.approx(np.linalg.norm(plan.target))
    assert plan.candidates[0].travel == pytest.approx(0, abs=1e-9)


def test_positive_azimuth_moves_to_the_right(plan: NextView) -> None:
    assert plan.candidates[1].camera_to_current[0, 3] > 0.1
    assert "45 degrees to the right" in directions_in_words(plan.candidates[1].camera_to_current, plan.target, plan.up)
    assert "45 degrees to the left" in directions_in_words(plan.candidates[7].camera_to_current, plan.target, plan.up)


def test_a_hidden_depth_sends_the_camera_to_the_side() -> None:
    """Face-on and low: the depth is unseen, and may be over a metre. Staying cannot show it; a corner view does.

    Of a box that deep the nearest corner views show most; the opposite face bounds it only as well as the pose is known.
    """
    result = next_view(scan_of((0.25, 0.4, 0.35), 0, 11), camera=CAMERA)
    assert "open" in result.current.boxes[0].flags
    assert result.best in (1, 3, 5, 7)
    scores = [candidate.assessment.score for candidate in result.candidates]
    assert min(scores[k] for k in (1, 3, 5, 7)) > scores[0]
    assert min(scores[1], scores[7]) > scores[4]
    assert not result.stop


def test_a_box_at_the_border_is_brought_into_the_image() -> None:
    result = next_view(scan_of((0.4, 0.3, 0.25), 35, 40, distance=0.9, aside=0.45), camera=CAMERA)
    assert "cut" in result.current.boxes[0].flags
    assert result.best is not None
    assert result.candidates[result.best].assessment.prediction.cut is False


def test_a_camera_too_near_steps_back() -> None:
    near = next_view(scan_of((0.55, 0.5, 0.4), 30, 35, distance=0.85), camera=CAMERA)
    assert all(
        np.linalg.norm(c.camera_to_current[:3, 3] - near.target) > 1.1 * np.linalg.norm(near.target) for c in near.candidates
    )


def test_stations_below_the_floor_or_too_near_never_win(seen_well: Measurement) -> None:
    stations = (Station(elevation=-0.3), Station(distance=0.3), Station(azimuth=1.0, elevation=0.6))
    result = next_view(seen_well, Rig(name="t", stations=stations, min_distance=0.25), camera=CAMERA)
    assert [candidate.reachable for candidate in result.candidates] == [False, False, True]
    assert result.best == 2
    nowhere = next_view(seen_well, Rig(name="t", stations=stations[:2], min_distance=0.25), camera=CAMERA)
    assert nowhere.best is None
    assert nowhere.reason == "no_reachable_view"


def test_every_limit_of_the_rig_counts(seen_well: Measurement) -> None:
    """The stations stand 0.27, 0.47 and 1.2 m over the floor, 0.6 m or more from the box; the last is straight overhead."""
    stations = (Station(elevation=0.2, distance=0.85), Station(elevation=0.45, distance=0.85), Station(elevation=np.pi / 2))
    for limits, reachable in (
        ({}, [True, True, True]),
        ({"max_distance": 0.3}, [False, False, False]),
        ({"max_height": 0.4}, [True, False, False]),
        ({"keep_out": (KeepOut(axis=np.array([0.0, 0.0, 1.0]), half_angle=0.3),)}, [True, True, False]),
    ):
        result = next_view(seen_well, Rig(name="t", stations=stations, **limits), camera=CAMERA)
        assert [candidate.reachable for candidate in result.candidates] == reachable, limits


def test_a_keep_out_cone_of_the_world_stays_where_it_is_in_the_world() -> None:
    """The scan was taken from azimuth 40 degrees; the robot's base is at 130, which is the ring's station 2."""
    scan = scan_of((0.4, 0.3, 0.2), 40, 38)
    base = KeepOut(axis=np.array([np.cos(np.deg2rad(130)), np.sin(np.deg2rad(130)), 0.0]), half_angle=np.deg2rad(47))
    cell = Rig(name="cell", stations=tuple(Station(azimuth=k * np.pi / 4) for k in range(8)), keep_out=(base,))
    reachable = [candidate.reachable for candidate in next_view(scan, cell, camera=CAMERA).candidates]
    assert reachable == [k != 2 for k in range(8)]  # 38 degrees of elevation from the axis; its neighbours are 56 from it
    with pytest.raises(ConfigError, match=r"cell.*camera_to_world"):
        next_view(replace(scan, camera_to_world=None), cell, camera=CAMERA)


def test_the_papers_stations_look_at_the_top_corner_that_faces_the_camera(seen_well: Measurement) -> None:
    box = seen_well.boxes[0].box
    corners = box.corners()[4:]
    nearest = corners[np.argmin(np.linalg.norm(corners, axis=1))]
    for candidate in next_view(seen_well, "paper4", camera=CAMERA).candidates:
        sight = nearest - candidate.camera_to_current[:3, 3]
        np.testing.assert_allclose(candidate.camera_to_current[:3, 2], sight / np.linalg.norm(sight), atol=1e-9)


def test_it_stops_exactly_when_the_chance_exceeds_the_confidence(seen_well: Measurement) -> None:
    chance = next_view(seen_well, camera=CAMERA, tolerance=0.005).within_tolerance
    assert 0.05 < chance < 0.999
    assert next_view(seen_well, camera=CAMERA, tolerance=0.005, confidence=chance - 1e-3).stop
    assert not next_view(seen_well, camera=CAMERA, tolerance=0.005, confidence=chance + 1e-3).stop


def test_turning_the_box_by_a_quarter_changes_nothing() -> None:
    """The box with its sides renamed is the same box: scores must not know the difference."""
    one = next_view(scan_of((0.4, 0.3, 0.2), 30, 38), camera=CAMERA)
    other = next_view(scan_of((0.3, 0.4, 0.2), 120, 38), camera=CAMERA)
    for first, second in zip(one.candidates, other.candidates, strict=True):
        assert first.assessment.score == pytest.approx(second.assessment.score, abs=0.03)


def test_an_unmeasurable_lump_is_still_planned_for() -> None:
    rng = np.random.default_rng(3)
    bare = capture(Scene(()), orbit_pose(TARGET, 0.0, 0.7, 1.1), CAMERA, rng=rng, effects=UNMIXED)
    ranges = np.linalg.norm(bare.organised(), axis=-1)
    rows, columns = np.mgrid[: ranges.shape[0], : ranges.shape[1]]
    bump = np.exp(-(((rows - 85) / 25.0) ** 2 + ((columns - 112) / 30.0) ** 2))
    lump = Scan.from_range(np.nan_to_num(ranges - 0.25 * bump * (bump > 0.05)), bare.intrinsics)
    result = next_view(lump, camera=CAMERA)
    assert result.candidates
    assert result.reason is None
    assert not result.stop


def test_a_bare_floor_gives_the_reason_and_no_candidates() -> None:
    floor = capture(Scene(()), orbit_pose(TARGET, 0.0, 0.7, 1.1), CAMERA, rng=np.random.default_rng(2), effects=UNMIXED)
    result = next_view(floor)
    assert (result.reason, result.candidates, result.best, result.stop) == ("nothing_on_floor", (), None, False)


def test_the_json_form_is_plain(plan: NextView) -> None:
    again = json.loads(json.dumps(plan.to_dict(), allow_nan=False))
    assert again["best"] == plan.best
    assert np.allclose(
        [c["camera_to_current"] for c in again["candidates"]], [c.camera_to_current for c in plan.candidates], atol=1e-6
    )


@pytest.mark.parametrize("options", [{"tolerance": 0.0}, {"tolerance": 1.0}, {"confidence": 1.0}, {"objective": "beauty"}])
def test_senseless_options_are_refused(options: dict[str, object], seen_well: Measurement) -> None:
    with pytest.raises(ConfigError):
        next_view(seen_well, **options)

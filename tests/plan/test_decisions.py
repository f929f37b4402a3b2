"""Decisions of the planner that a person can check: which view wins, when to stop, and what never wins."""

import json
from pathlib import Path

import numpy as np
import pytest

from viewgain.camera import sensor
from viewgain.errors import ConfigError
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.measure import Measurement, measure
from viewgain.plan import RIGS, NextView, Rig, Station, directions_in_words, next_view, place, rig
from viewgain.scans import Scan
from viewgain.simulate import Scene, capture, orbit_pose, standing_box

CAMERA = sensor("pico_flexx").without_systematic()
TARGET = np.array([0.0, 0.0, 0.1])


def scan_of(
    extents: tuple[float, float, float], azimuth: float, elevation: float, *, distance: float = 1.1, aside: float = 0.0
) -> Scan:
    box = standing_box(np.array(extents))
    camera = orbit_pose(box.centre + np.array([0.0, aside, 0.0]), np.deg2rad(azimuth), np.deg2rad(elevation), distance)
    return capture(Scene((box,)), camera, CAMERA, rng=np.random.default_rng(1))


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
    """Face-on and low: the depth is unseen. Staying, or going to the opposite face, cannot show it; a corner view does."""
    result = next_view(scan_of((0.25, 0.4, 0.35), 0, 11), camera=CAMERA)
    assert "open" in result.current.boxes[0].flags
    assert result.best not in (0, 4)
    scores = [candidate.assessment.score for candidate in result.candidates]
    assert min(scores[k] for k in (1, 3, 5, 7)) > max(scores[0], scores[4])
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
    bare = capture(Scene(()), orbit_pose(TARGET, 0.0, 0.7, 1.1), CAMERA, rng=rng)
    ranges = np.linalg.norm(bare.organised(), axis=-1)
    rows, columns = np.mgrid[: ranges.shape[0], : ranges.shape[1]]
    bump = np.exp(-(((rows - 85) / 25.0) ** 2 + ((columns - 112) / 30.0) ** 2))
    lump = Scan.from_range(np.nan_to_num(ranges - 0.25 * bump * (bump > 0.05)), bare.intrinsics)
    result = next_view(lump, camera=CAMERA)
    assert result.candidates
    assert result.reason is None
    assert not result.stop


def test_a_bare_floor_gives_the_reason_and_no_candidates() -> None:
    floor = capture(Scene(()), orbit_pose(TARGET, 0.0, 0.7, 1.1), CAMERA, rng=np.random.default_rng(2))
    result = next_view(floor)
    assert (result.reason, result.candidates, result.best, result.stop) == ("nothing_on_floor", (), None, False)


def test_the_json_form_is_plain(plan: NextView) -> None:
    again = json.loads(json.dumps(plan.to_dict(), allow_nan=False))
    assert again["best"] == plan.best
    assert np.allclose(
        [c["camera_to_current"] for c in again["candidates"]], [c.camera_to_current for c in plan.candidates], atol=1e-6
    )


def test_pcnbv33_points_where_the_public_list_points(data_dir: Path) -> None:
    """The public list is y-up; ours turns about z. Compare the sets of angles and their order."""
    public = np.loadtxt(data_dir / "views" / "viewspace_shapenet_33.txt")
    elevation, azimuth = np.arcsin(public[:, 1]), np.arctan2(public[:, 0], public[:, 2])
    ours = RIGS["pcnbv33"].stations
    assert len(ours) == 33
    assert np.allclose([s.elevation for s in ours], elevation, atol=1e-9)
    turn = np.array([s.azimuth for s in ours])[1:] - azimuth[1:]
    assert np.allclose(np.cos(turn), 1, atol=1e-9)


def test_absolute_stations_need_a_pose_and_use_it() -> None:
    there = pose(rotation_from_rotvec(np.array([0.0, np.pi, 0.0])), np.array([0.0, 0.0, 1.5]))
    absolute = Rig(name="abs", stations=(Station(camera_to_world=there),))
    here = pose(np.eye(3), np.array([1.0, 2.0, 3.0]))
    (placed,) = place(absolute, TARGET, np.eye(4), here)
    assert np.allclose(here @ placed, there)
    with pytest.raises(ConfigError, match="camera_to_world"):
        place(absolute, TARGET, np.eye(4), None)


@pytest.mark.parametrize(
    "text",
    ["", "[[view]]\nazimut_deg = 3\n", "[[view]]\ndistance_m = -1\n", "view = 3\n", "speed = 2\n[[view]]\n", "[[view]\n",
     '[[view]]\nazimuth_deg = "left"\n', "[[view]]\ncamera_to_world = [[1, 2], [3, 4]]\n"],
)  # fmt: skip
def test_a_bad_rig_file_is_named_in_one_line(text: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(ConfigError, match=r"bad\.toml") as error:
        rig(str(path))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("options", [{"tolerance": 0.0}, {"tolerance": 1.0}, {"confidence": 1.0}, {"objective": "beauty"}])
def test_senseless_options_are_refused(options: dict[str, object], seen_well: Measurement) -> None:
    with pytest.raises(ConfigError):
        next_view(seen_well, **options)

"""``viewgain next`` as a user runs it."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from viewgain.camera import sensor
from viewgain.cli import main
from viewgain.cli._text import decider_in_words, decision_in_words
from viewgain.plan import AROUND, FusedTrial, looked_at, next_view
from viewgain.scans import read_scan, write_scan
from viewgain.scenes import Scene, orbit_pose, standing_box
from viewgain.simulate import capture

FIRST_KEYS = {"schema", "rig", "objective", "policy", "current", "candidates", "best", "stop"}
KEYS = FIRST_KEYS | {"p_within_tolerance", "tolerance", "confidence", "reason", "abstention", "p_nearly_best"}
VERDICT_KEYS = {"score", "score_sigma", "volume_sigma_m3", "p_within_tolerance", "reachable"}
CANDIDATE_KEYS = VERDICT_KEYS | {"index", "camera_to_current", "faces", "cut", "border_share"}


def plan_of(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    assert main(["next", *arguments, "--json"]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    return json.loads(line)


def test_json_has_every_documented_key(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan = plan_of([str(scans / "one.png")], capsys)
    assert set(plan) == KEYS
    assert [set(candidate) for candidate in plan["candidates"]] == [CANDIDATE_KEYS] * 8
    assert plan["candidates"][plan["best"]]["reachable"]


def test_a_rig_of_ones_own_is_followed(scans: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig = tmp_path / "mine.toml"
    rig.write_text('name = "mine"\n[[view]]\nazimuth_deg = 90\ndistance_m = 0.8\n[[view]]\nelevation_deg = -20\n')
    plan = plan_of([str(scans / "one.png"), "--rig", str(rig)], capsys)
    assert plan["rig"] == "mine"
    assert [candidate["reachable"] for candidate in plan["candidates"]] == [True, False]
    assert plan["best"] == 0


def test_two_posed_scans_are_fused_and_surer(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = plan_of([str(scans / "one.ply")], capsys)
    poses = ["--pose", str(scans / "one_pose.txt"), str(scans / "two_pose.txt")]
    both = plan_of([str(scans / "one.ply"), str(scans / "two.ply"), *poses], capsys)
    assert both["current"]["boxes"][0]["volume_sigma_m3"] < one["current"]["boxes"][0]["volume_sigma_m3"]


def test_two_scans_without_poses_are_fused_in_the_last_ones_frame(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    two = plan_of([str(scans / "two_unposed.ply")], capsys)
    both = plan_of([str(scans / "one_unposed.ply"), str(scans / "two_unposed.ply")], capsys)
    assert len(both["current"]["scans"]) == 2
    assert np.allclose(both["current"]["camera_poses"][-1], np.eye(4))
    centres = [np.array(plan["current"]["boxes"][0]["box_to_camera"])[:3, 3] for plan in (two, both)]
    assert np.allclose(*centres, atol=0.01)
    assert both["p_within_tolerance"] >= two["p_within_tolerance"]


def test_a_last_scan_without_the_box_gives_no_place_to_start_from(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        main(["next", str(scans / "one_unposed.ply"), str(scans / "two_unposed.ply"), str(scans / "floor_unposed.ply"), "--json"])
        == 2
    )
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "floor_unposed.ply shares no box" in captured.err


def test_a_tight_tolerance_keeps_going_and_a_wide_one_stops(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert not plan_of([str(scans / "one.png"), "--tolerance", "0.001"], capsys)["stop"]
    assert plan_of([str(scans / "one.png"), "--tolerance", "0.2"], capsys)["stop"]


def test_the_words_say_where_to_go_or_to_stop(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["next", str(scans / "one.png"), "--tolerance", "0.001"]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    assert last.startswith("P(volume error < 0.1%) is ")


@pytest.mark.parametrize(
    ("stop", "chance", "said"),
    [
        (True, 0.97, "0.970, over the 0.95"),
        (False, 0.9, "0.900, under the 0.95"),
        (False, 0.97, "0.970, but a dimension is open"),
    ],
)
def test_the_words_and_the_chance_agree(scans: Path, stop: bool, chance: float, said: str) -> None:
    """A likely volume is not enough where a dimension is open, and is then not said to be too unlikely."""
    plan = next_view(read_scan(scans / "one.png"), "ring8")
    assert said in decision_in_words(replace(plan, stop=stop, within_tolerance=chance))


def test_a_view_for_coverage_is_not_explained_by_the_volume(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["next", str(scans / "one.png"), "--objective", "coverage", "--policy", "network", "--rig", "pcnbv16"]) == 0
    table, last = capsys.readouterr().out.rsplit("\n", 2)[:2]
    assert last.startswith("View ")
    assert "newly covered" in last
    assert "asked for" not in last
    assert "nothing" not in table, "which faces a candidate would see is for who predicts them to say"


@pytest.mark.parametrize(("pose", "chosen"), [(True, "compact-pcnbv16-object"), (False, "compact-pcnbv16-camera")])
def test_where_no_network_is_named_the_one_that_chooses_best_decides(
    pose: bool, chosen: str, scans: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scan = [str(scans / "one.ply"), "--pose", str(scans / "one_pose.txt")] if pose else [str(scans / "one_unposed.ply")]
    asked = [*scan, "--objective", "coverage", "--policy", "network", "--rig", "pcnbv16"]
    scores = [
        [candidate["score"] for candidate in plan_of([*asked, *named], capsys)["candidates"]]
        for named in ([], ["--model", chosen])
    ]
    assert scores[0] == scores[1]


def test_the_volume_is_abstained_from_below_the_chance_asked_for(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The chance is said whoever decides, an abstention has it as its reason, and the more is asked the fewer views are named."""
    plain = plan_of([str(scans / "one.png"), "--tolerance", "0.001"], capsys)
    chance = plain["p_nearly_best"]
    assert 0 < chance < 1
    told = [
        plan_of([str(scans / "one.png"), "--tolerance", "0.001", "--abstain", f"{limit:.4f}"], capsys)
        for limit in (chance / 2, (1 + chance) / 2)
    ]
    assert [plan["best"] for plan in told] == [plain["best"], None]
    assert [plan["reason"] for plan in told] == [None, "abstains"]
    assert f"is {chance:.2f}, under the {(1 + chance) / 2:.2f} asked for" in told[1]["abstention"]
    assert {plan["p_nearly_best"] for plan in told} == {chance}
    assert [plan["candidates"] for plan in told] == [plain["candidates"]] * 2
    assert main(["next", str(scans / "one.png"), "--tolerance", "0.001", "--abstain", "1", "--policy", "expected"]) == 0
    assert "No view is named: view " in capsys.readouterr().out


def test_the_words_say_the_chance(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["next", str(scans / "one.png"), "--tolerance", "0.001"]) == 0
    last = " ".join(capsys.readouterr().out.splitlines()[-1:])
    assert "Chance that no other view is better by 2 points of volume error: " in last
    assert last.endswith(" %.")


def test_a_thing_that_is_no_box_is_still_planned_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = "simulate --scene object --category mug --size 0.4 --rig ring2 --without multipath --formats npz --out"
    assert main([*command.split(), str(tmp_path)]) == 0
    capsys.readouterr()
    plan = plan_of([str(tmp_path / "view00_000.npz")], capsys)
    assert (plan["current"]["boxes"], plan["stop"], plan["reason"]) == ([], False, None)


def test_a_bare_floor_has_a_reason_and_exit_3(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["next", str(scans / "floor.npz"), "--json"]) == 3
    plan = json.loads(capsys.readouterr().out)
    assert plan["reason"] == "nothing_on_floor"
    assert plan["candidates"] == []


WRONG = [("--rig", "ring0"), ("--tolerance", "2"), ("--confidence", "0"), ("--rig", "none.toml"), ("--abstain", "1.5")]


@pytest.mark.parametrize(("option", "value"), WRONG)
def test_bad_options_are_one_line_and_exit_2(option: str, value: str, scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["next", str(scans / "one.png"), option, value]) == 2
    (error,) = capsys.readouterr().err.splitlines()[-1:]
    assert value.strip("0.") in error or str(float(value)) in error


def test_a_network_that_nobody_would_ask_is_refused(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for policy in ("auto", "model", "expected"):
        assert main(["next", str(scans / "one.png"), "--policy", policy, "--model", "mine.onnx"]) == 2
        captured = capsys.readouterr()
        (error,) = captured.err.splitlines()
        assert f"--model: got mine.onnx, and --policy {policy} asks none that is named" in error
        assert captured.out == ""


def test_whoever_decides_the_model_says_what_each_view_would_show(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The policy expected scores by the error; what a view would teach is told beside it, as the policy model has it."""
    by_model, by_error = (plan_of([str(scans / "one.png"), "--policy", name], capsys) for name in ("model", "expected"))
    assert (by_model["policy"], by_error["policy"]) == ("model", "expected")
    for one, other in zip(by_model["candidates"], by_error["candidates"], strict=True):
        assert {**one, "score": None} == {**other, "score": None}
        assert one["score"] != other["score"]
        assert 0 <= other["score"] <= 1


def test_who_decides_by_itself_depends_on_what_is_known_and_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A box seen whole: the model. A front whose depth nobody sees: model and network, and as if that had been asked for."""
    box = standing_box(np.array([0.32, 0.26, 0.3]))
    for name, elevation, decides in (("whole", 35.0, "model"), ("front", 4.0, "combined")):
        view = orbit_pose(box.centre, 0.5 if name == "whole" else 0.0, np.deg2rad(elevation), 1.1)
        scan = capture(Scene((box,)), view, sensor("pico_flexx"), rng=np.random.default_rng(4))
        write_scan(scan, tmp_path / f"{name}.npz")
        arguments = [str(tmp_path / f"{name}.npz"), "--camera", "pico_flexx", "--tolerance", "0.001"]
        by_itself, asked = (plan_of([*arguments, *more], capsys) for more in ([], ["--policy", decides]))
        assert by_itself["policy"] == decides
        assert by_itself == asked
        assert main(["next", *arguments]) == 0
        words = capsys.readouterr().out
        assert ("every dimension is bounded" in words) == (decides == "model")
        assert ("Decided by model and network together" in words) == (decides == "combined")
        assert main(["next", *arguments, "--policy", decides]) == 0
        assert "Decided by" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("policy", "boxes", "rejected", "words"),
    [
        ("model", ("box",), (), "every dimension is bounded"),
        ("combined", ("box",), (), "model and network together"),
        ("combined", (), ("fitted",), "model and network together"),
        ("combined", (), (None,), "by the network: nothing could be measured"),
        ("combined", (), (), "of the boxes that would look like this and stand at the place"),
    ],
)
def test_the_words_name_those_who_had_a_say(
    policy: str, boxes: tuple[str, ...], rejected: tuple[str | None, ...], words: str
) -> None:
    """A rejected object that a box was fitted to is planned for with that box: then the model has its half."""
    blobs = tuple(SimpleNamespace(estimate=each) for each in rejected)
    plan = SimpleNamespace(policy=policy, current=SimpleNamespace(boxes=boxes, rejected=blobs))
    assert words in decider_in_words(plan)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def wall(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A carton of a metre so near that it fills the image: its top passes for the floor; and the same scan without its pose."""
    box, folder = standing_box(np.array([1.0, 1.1, 0.56]), yaw=0.5), tmp_path_factory.mktemp("wall")
    camera = orbit_pose(box.centre, np.deg2rad(140), np.deg2rad(32), 0.85)
    scan = capture(Scene((box,)), camera, sensor("pico_flexx").without_systematic(), rng=np.random.default_rng(3))
    write_scan(scan, folder / "wall.npz")
    write_scan(replace(scan, camera_to_world=None), folder / "unposed.npz")
    return folder


PLACE = ["--place", "0.05", "-0.05", "0.3"]


def test_a_place_is_as_exact_for_the_command_as_for_the_policies(wall: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = [str(wall / "wall.npz"), "--camera", "pico_flexx", *PLACE]
    said = [plan_of([*arguments, *sigma], capsys) for sigma in ([], ["--place-sigma", str(AROUND)], ["--place-sigma", "0.3"])]
    assert said[0] == said[1] != said[2]


def test_told_the_place_it_leads_away_from_a_wall_of_cardboard(wall: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = [str(wall / "wall.npz"), "--camera", "pico_flexx"]
    assert main(["next", *arguments]) == 3
    capsys.readouterr()
    assert main(["next", *arguments, *PLACE]) == 0
    words = capsys.readouterr().out
    assert "nothing_on_floor" in words
    assert "stand at the place" in words
    plan = plan_of([*arguments, *PLACE], capsys)
    assert (plan["policy"], plan["stop"], plan["current"]["reason"]) == ("combined", False, "nothing_on_floor")
    middle = np.array([0.0, 0.0, 0.85])  # what the camera looks at: the carton's centre
    poses = np.array([candidate["camera_to_current"] for candidate in plan["candidates"]])
    target = looked_at(poses)
    assert target is not None
    assert np.linalg.norm(target - middle) < 0.3  # known to 10 cm per axis; a place in the camera's frame is 0.6 m off
    assert np.linalg.norm(poses[plan["best"], :3, 3] - middle) > 1.4
    assert plan_of([*arguments, *PLACE], capsys) == plan


def test_rehearsals_say_how_sure_each_score_is(
    scans: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("viewgain.plan._rehearsed.MOST", 4)
    arguments = [str(scans / "one.png"), "--tolerance", "0.001", "--policy"]  # more than is known yet
    expected, rehearsed = (plan_of([*arguments, policy], capsys) for policy in ("expected", "rehearsed"))
    assert rehearsed["policy"] == "rehearsed"
    assert rehearsed["candidates"][rehearsed["best"]]["reachable"]
    tried = [candidate for candidate in rehearsed["candidates"] if candidate["score_sigma"] is not None]
    assert len(tried) > 1
    for candidate in tried:  # of four rehearsals, and what was expected counts as four
        assert candidate["score_sigma"] == pytest.approx(np.sqrt(candidate["score"] * (1 - candidate["score"]) / 9), rel=1e-2)
        assert candidate["score"] != expected["candidates"][candidate["index"]]["score"]
    assert {candidate["score_sigma"] for candidate in expected["candidates"]} == {None}
    assert main(["next", *arguments, "rehearsed"]) == 0
    assert "note: trying views out in simulation first" in capsys.readouterr().err
    assert main(["next", *arguments, "rehearsed", "--objective", "coverage"]) == 2
    assert "got --policy rehearsed, which knows boxes only" in capsys.readouterr().err


def test_where_nothing_can_be_rehearsed_the_network_decides_the_one_that_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = "simulate --scene object --category mug --size 0.4 --rig ring2 --without multipath --formats npz --out"
    assert main([*command.split(), str(tmp_path)]) == 0
    capsys.readouterr()
    scan = str(tmp_path / "view00_000.npz")
    named = ["--model", "pose_scores-irregular4-camera"]
    for more in ([], named):
        rehearsed, network = (plan_of([scan, "--policy", policy, *more], capsys) for policy in ("rehearsed", "network"))
        assert rehearsed["policy"] == "rehearsed"
        assert {**rehearsed, "policy": "network"} == network
    by_name, by_default = (plan_of([scan, "--policy", "rehearsed", *more], capsys) for more in (named, []))
    assert [each["score"] for each in by_name["candidates"]] != [each["score"] for each in by_default["candidates"]]


def test_rehearsals_are_of_all_scans_together(
    scans: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    known: list[int] = []

    def noting(trial: FusedTrial, index: int, camera_to_current: np.ndarray) -> float:
        known.append(len(trial.known))
        return 0.5

    monkeypatch.setattr("viewgain.plan._rehearsed.MOST", 4)
    monkeypatch.setattr(FusedTrial, "outcome", noting)
    for count, names in ((1, ["one.png"]), (2, ["one.png", "two.png"]), (2, ["one_unposed.ply", "two_unposed.ply"])):
        known.clear()
        plan_of([*(str(scans / name) for name in names), "--tolerance", "0.001", "--policy", "rehearsed"], capsys)
        assert known
        assert set(known) == {count}


def test_coverage_asks_for_an_object_on_a_floor_as_ever(wall: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--objective", "coverage", "--policy", "network", "--rig", "pcnbv16"]
    assert main(["next", str(wall / "wall.npz"), "--camera", "pico_flexx", *PLACE, *arguments]) == 3
    assert "nothing_on_floor" in capsys.readouterr().err


def test_a_place_that_makes_no_sense_is_refused_in_one_line(wall: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for scan, more, words in (
        ("wall", [*PLACE, "--place-sigma", "0"], "standard deviation of 0.0 m, wanted 0.0001 m or more"),
        ("wall", ["--place-sigma", "0.05"], "--place-sigma: got 0.05 and no place, wanted --place X Y Z"),
        ("wall", ["--place", "nan", "0", "0"], "wanted three numbers of 10000 m at most"),
        ("unposed", PLACE, "without a pose, wanted camera_to_world"),
    ):
        assert main(["next", str(wall / f"{scan}.npz"), *more]) == 2
        error = capsys.readouterr().err
        assert words in error
        assert error.count("\n") == 1


def test_best_is_the_top_of_the_reachable_scores_up_to_a_tie(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan = plan_of([str(scans / "one.png")], capsys)
    scores = np.array([c["score"] for c in plan["candidates"] if c["reachable"]])
    assert plan["candidates"][plan["best"]]["score"] >= 1 - 1.031 * (1 - scores.max())

"""``viewgain evaluate volume`` through the real command: figures by hand, going on, and what goes wrong."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from viewgain.cli import main
from viewgain.evaluation import VolumeSettings, case_errors, choice, volume_case
from viewgain.evaluation._box_results import rig_digest
from viewgain.evaluation._claim import claim
from viewgain.evaluation._volume_case import VolumeCase
from viewgain.gain import volume_estimator
from viewgain.measure import POSE_SIGMA, fuse
from viewgain.plan import FarthestPolicy
from viewgain.scans import Scan
from viewgain.simulate import draw_range_error

ARGUMENTS = ("--boxes", "2", "--captures", "2", "--estimator", "lines_published", "--side", "0.2", "0.5", "--seed", "5")


def evaluated(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict[str, Any]:
    assert main(["evaluate", "volume", "--json", *ARGUMENTS, *map(str, arguments)]) == 0
    content: dict[str, Any] = json.loads(capsys.readouterr().out)
    return content


def test_the_table_is_that_of_scans_by_hand_and_a_second_run_takes_what_is_kept(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "results"
    first = evaluated(capsys, "--policies", "farthest", "random", "oracle", "--out", out)
    settings = VolumeSettings(seed=5, captures=2, estimator="lines_published", side=(0.2, 0.5))
    errors = []
    for number in range(2):
        case = volume_case(settings, number)
        table = case_errors(case)
        costs = np.where(np.isnan(table), 1.0, np.minimum(np.abs(table), 1.0))
        errors.append(costs[choice(case, FarthestPolicy()).position, :2].mean())
    rows = {row["name"]: row for row in first["rows"]}
    assert list(rows) == ["farthest", "uniform guess", "oracle"]
    assert rows["farthest"]["shares"]["mean"][2] == pytest.approx(np.mean(errors))
    kept = sorted((out / "boxes").iterdir())
    assert [file.name for file in kept] == ["box00000.json", "box00001.json"]
    marked = json.loads(kept[0].read_text())
    marked["errors"] = [[0.25] * 4] * 4
    kept[0].write_text(json.dumps(marked))
    again = {row["name"]: row for row in evaluated(capsys, "--policies", "farthest", "random", "oracle", "--out", out)["rows"]}
    assert again["farthest"]["shares"]["mean"][2] == pytest.approx((0.25 + errors[1]) / 2)
    (out / "volume.md").unlink()
    (out / "volume.md").mkdir()
    assert main(["evaluate", "volume", *ARGUMENTS, "--policies", "farthest", "--out", str(out)]) == 4
    said = [line for line in capsys.readouterr().err.splitlines() if "error" in line]
    assert [line.partition(": cannot")[0] for line in said] == [f"viewgain: error: {out / 'volume.md'}"]
    (out / "volume.md").rmdir()
    assert evaluated(capsys, "--policies", "farthest", "random", "oracle", "--out", out)["boxes"] == 2
    assert (out / "volume.md").read_text().startswith("## Next best view for volume: 2 fresh boxes of seed 5")
    assert main(["evaluate", "volume", *ARGUMENTS, "--captures", "3", "--out", str(out)]) == 2
    assert "holds results of other settings" in capsys.readouterr().err
    for content in (b"{", b"[]", b'{"errors": [[0.1]]}', b'{"errors": "\xff"}'):
        kept[1].write_bytes(content)
        assert main(["evaluate", "volume", *ARGUMENTS, "--out", str(out)]) == 2
        said = capsys.readouterr().err
        assert f"{kept[1]}: is damaged" in said
        assert "Traceback" not in said


def test_parts_of_a_run_join_to_the_whole(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    def run(out: str, *arguments: str) -> dict[str, Any]:
        return evaluated(capsys, "--policies", "farthest", *arguments, "--out", tmp_path / out)

    part, other = run("part"), run("other", "--first", "1")
    assert (part["first"], other["first"]) == (0, 1)
    heading = "## Next best view for volume: 2 fresh boxes of seed 5 from number 1 on,"
    assert (tmp_path / "other" / "volume.md").read_text().startswith(heading)
    ours, theirs = tmp_path / "part" / "boxes", tmp_path / "other" / "boxes"
    assert [file.name for file in sorted(theirs.iterdir())] == ["box00001.json", "box00002.json"]
    assert (ours / "box00001.json").read_bytes() == (theirs / "box00001.json").read_bytes()
    (theirs / "box00002.json").rename(ours / "box00002.json")
    made = [file.stat().st_mtime_ns for file in sorted(ours.iterdir())]
    whole = run("part", "--boxes", "3")
    assert [file.stat().st_mtime_ns for file in sorted(ours.iterdir())] == made
    overlap = run("part", "--boxes", "2", "--first", "1")
    assert overlap["rows"][0]["shares"] == other["rows"][0]["shares"]
    assert whole["boxes"] == 3


def test_scans_by_other_cameras_are_added_to_what_is_kept(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """The slow twin gives the case another camera, one for each scan; what was kept before stays as it was."""
    evaluated(capsys, "--policies", "random", "--out", tmp_path)
    files = [tmp_path / "boxes" / f"box0000{number}.json" for number in range(2)]
    before = [json.loads(file.read_text()) for file in files]
    (row,) = evaluated(capsys, "--policies", "informed", "--out", tmp_path)["rows"]
    after = [json.loads(file.read_text()) for file in files]
    assert [{key: value for key, value in each.items() if key != "errors_by_others"} for each in after] == before
    case = volume_case(VolumeSettings(seed=5, captures=2, estimator="lines_published", side=(0.2, 0.5)), 0)
    rng = np.random.default_rng([5, 0x7635, 0])
    measured = volume_estimator("lines_published", case.camera)
    for k in range(2):
        camera = replace(case.scans, error=draw_range_error(case.camera, rng=rng))
        for view in np.flatnonzero(case.reachable):
            scan = camera.scan(int(view), 5 + k)
            error = np.nan if scan is None else measured(scan) / case.box.volume - 1
            kept = after[0]["errors_by_others"][view][k]
            assert (np.nan if kept is None else kept) == pytest.approx(error, nan_ok=True)
    chosen = [np.argmin(np.mean(costs_of(each["errors_by_others"]), axis=1)) for each in after]
    spent = [costs_of(each["errors"])[place, :2].mean() for place, each in zip(chosen, after, strict=True)]
    assert row["shares"]["mean"][2] == pytest.approx(np.mean(spent))
    files[1].write_text(json.dumps({**after[1], "errors_by_others": [[0.1]]}))
    assert main(["evaluate", "volume", *ARGUMENTS, "--out", str(tmp_path)]) == 2
    assert f"{files[1]}: is damaged" in capsys.readouterr().err


def costs_of(rows: list[list[float | None]]) -> np.ndarray:
    """Costs of errors as a file has them, in a rig all of which can be reached."""
    return np.array([[1.0 if error is None else min(abs(error), 1.0) for error in row] for row in rows])


def test_the_default_estimators_decisions_come_with_a_chance_and_a_picture(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Of boxes that are kept no scan is taken but those to decide by."""
    settings = VolumeSettings(seed=5, captures=2)
    claim(tmp_path, {"rig_stations": rig_digest(settings), **settings.to_dict()}, results=tmp_path / "boxes")
    for number in range(3):
        kept = {
            "box": number,
            "size_m": [0.3, 0.2, 0.1],
            "present": 0,
            "errors": [[0.01 * (view + number)] * 4 for view in range(4)],
        }
        (tmp_path / "boxes" / f"box{number:05d}.json").write_text(json.dumps(kept))
    options = ["--boxes", "3", "--captures", "2", "--seed", "5", "--policies", "expected", "farthest", "random", "--out"]
    assert main(["evaluate", "volume", "--json", *options, str(tmp_path)]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)["rows"]}
    assert rows["uniform guess"]["sure"] is None
    for name in ("expected", "farthest"):
        sure = rows[name]["sure"]
        assert [each["share"] for each in sure["kept"]] == [0.5, 0.7, 0.9, 1.0]
        assert sum(group["count"] for group in sure["bins"]) == 3
        assert all(0 <= group["said"] <= 1 for group in sure["bins"])
        assert sure["kept"][-1]["nearly"] == pytest.approx(rows[name]["shares"]["mean"][1])
        assert sure["area_by_truth"] <= sure["area"]["value"]
    text = (tmp_path / "volume.md").read_text()
    assert "Confidence: the chance, known when choosing" in text
    assert (tmp_path / "volume.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_fused_errors_are_those_of_both_scans_measured_together(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """The slow twin takes each pair of scans anew, with poses off as the camera's belief is, and fuses the two as any others."""
    arguments = ("--boxes", "2", "--captures", "2", "--side", "0.15", "0.4", "--rig", "ring2", "--fused")
    assert main(["evaluate", "volume", *arguments, "--policies", "random", "--json", "--out", str(tmp_path)]) == 0
    (row,) = json.loads(capsys.readouterr().out)["rows"]
    kept = [json.loads((tmp_path / "boxes" / f"box0000{number}.json").read_text()) for number in range(2)]
    costs = [np.minimum(np.abs(np.array(each["errors"])[:, :2]), 1.0) for each in kept]
    assert row["shares"]["mean"][2] == pytest.approx(np.mean(costs))
    case = volume_case(VolumeSettings(captures=2, side=(0.15, 0.4), rig="ring2", fused=True), 0)
    assert kept[0]["present"] == case.present
    assert case.reachable.all()
    for view in range(2):
        for number in range(4):
            first, second = believed(case, case.present, 4), believed(case, view, number)
            (box,) = fuse([first, second], camera="pico_flexx").boxes
            assert kept[0]["errors"][view][number] == pytest.approx(np.prod(box.dimensions) / np.prod(kept[0]["size_m"]) - 1)


def test_whoever_is_told_the_place_decides_otherwise_and_the_page_says_how_far_off_it_is(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Boxes of a metre, seen from 85 cm: half of a side is out of sight, and where the middle is says how long it is."""
    network = "pose_scores-irregular4-camera"
    names = ("expected", "expected_around", f"combined:{network}", f"combined_around:{network}")
    large = ("--side", "0.7", "1.2", "--boxes", "5", "--captures", "2", "--estimator", "lines_published", "--seed", "9")
    assert main(["evaluate", "volume", *large, "--off-centre", "0.05", "--policies", *names, "--out", str(tmp_path)]) == 0
    page = capsys.readouterr().out
    assert "the rig's middle 5 cm per axis off the box's centre" in page
    assert all(f"| {name} |" in page for name in names)
    content = json.loads((tmp_path / "volume.json").read_text())
    undecided = {row["name"]: row["undecided"] for row in content["rows"] if row["name"] in names}
    assert undecided["expected"] > 0 == undecided["expected_around"]
    assert main(["evaluate", "volume", *large, "--policies", "farthest", "--out", str(tmp_path)]) == 2
    assert "holds results of other settings" in capsys.readouterr().err
    assert main(["evaluate", "volume", *large, "--off-centre", "-1"]) == 2
    assert "got -1.0 m off centre" in capsys.readouterr().err


@pytest.mark.slow
def test_who_rehearses_knows_which_estimator_will_measure(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """The published lines miss from where the default estimator does not; a rehearsal with them shows it."""
    asked = ("--side", "0.15", "0.4", "--boxes", "3", "--captures", "4", "--estimator", "lines_published", "--seed", "5")
    names = ("expected_around", "rehearsed_around")
    assert main(["evaluate", "volume", *asked, "--policies", *names, "--out", str(tmp_path), "--workers", "2"]) == 0
    content = json.loads((tmp_path / "volume.json").read_text())
    mean = {row["name"]: row["shares"]["mean"][2] for row in content["rows"]}
    assert mean["rehearsed_around"] < mean["expected_around"]
    assert "| rehearsed_around |" in capsys.readouterr().out


def believed(case: VolumeCase, view: int, number: int) -> Scan:
    """Return a scan with its pose turned and moved by what the camera does not know of it."""
    scan = case.scans.scan(view, number)
    assert scan is not None
    rng = np.random.default_rng([case.scans.seed, view, number, 1])
    miss = np.eye(4)
    miss[:3, :3] = Rotation.from_rotvec(rng.normal(0.0, POSE_SIGMA[1], 3)).as_matrix()
    miss[:3, 3] = rng.normal(0.0, POSE_SIGMA[0], 3)
    return replace(scan, camera_to_world=case.scans.camera_to_world(view, number) @ miss)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--boxes", "1"], "wanted 2 or more"),
        (["--first", "-1"], "first box -1, wanted 0 or more"),
        (["--policies", "wizard"], "'wizard' is not known"),
        (["--policies", "model"], "'model' is not known; choose from expected,"),
        (["--policies", "farthest", "network:nowhere.onnx"], "nowhere.onnx: no such file"),
        (["--policies", "combined:nowhere.onnx"], "nowhere.onnx: no such file"),
        (["--side", "nan", "0.5"], "sides (nan, 0.5)"),
        (["--rig", "paper4", "--policies", "farthest", "expected_around"], "rig paper4, whose stations look at a corner"),
        (["--rig", "paper4", "--policies", "rehearsed_around"], "rig paper4, whose stations look at a corner"),
        (["--distance", "inf"], "distance inf"),
        (["--elevation", "nan"], "elevation nan"),
        (["--estimator", "eye"], "estimator: got 'eye'"),
        (["--fused", "--estimator", "lines_mended"], "cannot fuse"),
    ],
)
def test_bad_questions_end_in_one_line(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", "volume", *arguments]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1

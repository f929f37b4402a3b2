"""``viewgain measure`` as a user runs it: what stands on stdout, what on stderr, and the exit code."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

from tests.cli.conftest import EXTENTS
from viewgain.cli import main

TRUTH = np.sort(EXTENTS)[::-1]


def lines(capsys: pytest.CaptureFixture[str]) -> list[dict[str, object]]:
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


@pytest.mark.parametrize("name", ["one.png", "one.ply"])
def test_json_is_one_line_with_the_box_in_it(name: str, scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / name), "--json", "--camera", "pico_flexx"]) == 0
    (result,) = lines(capsys)
    (box,) = result["boxes"]
    assert np.allclose(box["dimensions_m"], TRUTH, atol=0.006)
    assert result["reason"] is None
    assert all(low <= value <= high for value, (low, high) in zip(box["dimensions_m"], box["interval90_m"], strict=True))


def test_many_scans_give_one_result_each_and_the_worst_code(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "one.png"), str(scans / "floor.npz"), str(scans / "two.png"), "--json"]) == 3
    results = lines(capsys)
    assert [len(result["boxes"]) for result in results] == [1, 0, 1]
    assert results[1]["reason"] == "nothing_on_floor"


def test_a_bad_file_does_not_stop_the_others(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "missing.ply"), str(scans / "one.png"), "--json"]) == 2
    captured = capsys.readouterr()
    assert len(captured.out.splitlines()) == 1
    (error,) = [line for line in captured.err.splitlines() if "error" in line]
    assert "missing.ply" in error


def test_csv_has_a_row_per_box_and_one_for_a_reason(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "one.png"), str(scans / "floor.npz"), "--csv"]) == 3
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert len(rows) == 2
    assert float(rows[0]["length_m"]) == pytest.approx(TRUTH[0], abs=0.006)
    assert rows[0]["reason"] == ""
    assert rows[1]["reason"] == "nothing_on_floor"


def test_fusing_uses_poses(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    both = [str(scans / "one.ply"), str(scans / "two.ply")]
    poses = ["--pose", str(scans / "one_pose.txt"), str(scans / "two_pose.txt")]
    assert main(["measure", *both, *poses, "--fuse", "--json"]) == 0
    (result,) = lines(capsys)
    (box,) = result["boxes"]
    assert len(result["scans"]) == 2
    assert np.allclose(box["dimensions_m"], TRUTH, atol=0.004)
    centre = np.array(box["box_to_world"])[:3, 3]
    assert np.allclose(centre, [0, 0, EXTENTS[2] / 2], atol=0.01)


def test_fusing_without_poses_says_where_the_cameras_stood(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "one_unposed.ply"), str(scans / "two_unposed.ply"), "--fuse", "--json"]) == 0
    (result,) = lines(capsys)
    (box,) = result["boxes"]
    assert np.allclose(box["dimensions_m"], TRUTH, atol=0.006)
    first, last = (np.array(pose) for pose in result["camera_poses"])
    assert np.allclose(last, np.eye(4))
    one, two = (np.loadtxt(scans / f"{name}_pose.txt") for name in ("one", "two"))
    expected = np.linalg.inv(two) @ one
    half_turn = half_turn_about(two, np.array(box["box_to_camera"]))
    away = [np.linalg.norm(first[:3, 3] - other[:3, 3]) for other in (expected, half_turn @ expected)]
    assert min(away) < 0.03  # of one box alone nobody knows which way round it is


def half_turn_about(camera_to_world: np.ndarray, box_to_camera: np.ndarray) -> np.ndarray:
    """Return half a turn about the upright line through the box, in the camera's frame."""
    up, centre = camera_to_world[2, :3], box_to_camera[:3, 3]
    turn = np.eye(4)
    turn[:3, :3] = 2 * np.outer(up, up) - np.eye(3)
    turn[:3, 3] = centre - turn[:3, :3] @ centre
    return turn


def test_fusing_tells_what_it_left_out_and_what_it_cannot_know(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [str(scans / f"{name}_unposed.ply") for name in ("one", "two", "floor")]
    assert main(["measure", *files, "--fuse"]) == 0
    notes = [line for line in capsys.readouterr().err.splitlines() if line.startswith("viewgain: note:")]
    (left_out,) = [note for note in notes if "left out" in note]
    assert "floor_unposed.ply" in left_out
    assert any("half a turn" in note for note in notes)


def test_without_fusing_there_are_no_camera_poses(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    poses = ["--pose", str(scans / "one_pose.txt"), str(scans / "two_pose.txt")]
    both = [str(scans / "one_unposed.ply"), str(scans / "two_unposed.ply")]
    assert main(["measure", *both, "--json"]) == 0
    assert main(["measure", *both, *poses, "--fuse", "--json"]) == 0
    assert not any("camera_poses" in result for result in lines(capsys))


def test_fusing_some_with_poses_and_some_without_is_one_line(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "one_unposed.ply"), str(scans / "floor.npz"), "--fuse", "--json"]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "one_unposed.ply: has no camera pose" in captured.err


def test_an_empty_scene_gives_the_floor(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "one.png"), "--floor", str(scans / "floor.npz"), "--json"]) == 0
    (result,) = lines(capsys)
    assert np.allclose(result["boxes"][0]["dimensions_m"], TRUTH, atol=0.006)


def test_the_table_names_every_quantity_with_its_unit(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "one.png")]) == 0
    out = capsys.readouterr().out
    assert all(word in out for word in ("length", "width", "height", "volume", " mm", " l ", "(vertical)", "90 %"))


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ([], "scan"),
        (["one.png", "--json", "--csv"], "--csv"),
        (["one.png", "--camera", "nikon"], "nikon"),
        (["one.ply", "two.ply", "--pose", "one_pose.txt"], "1 poses"),
        (["one.png", "--intrinsics", "one_pose.txt"], "one_pose.txt"),
        (["one.ply", "--pose", "floor.npz"], "floor.npz"),
    ],
)
def test_bad_usage_is_one_line_and_exit_2(
    arguments: list[str], word: str, scans: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    full = [argument if argument.startswith("-") or argument == "nikon" else str(scans / argument) for argument in arguments]
    assert main(["measure", *full]) == 2
    captured = capsys.readouterr()
    error = [line for line in captured.err.splitlines() if "error" in line]
    assert len(error) == 1, captured.err
    assert word in error[0]
    assert "Traceback" not in captured.err

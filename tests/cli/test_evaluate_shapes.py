"""``viewgain evaluate shapes`` from end to end."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from viewgain.cli import main

ARGUMENTS = ("--objects", "2", "--seed", "5", "--rig", "ring4", "--categories", "bench", "--size", "0.4", "0.6")
CUBE = """OFF
8 12 0
0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1
3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7
"""


def evaluated(capsys: pytest.CaptureFixture[str], *more: str | Path) -> dict[str, Any]:
    assert main(["evaluate", "shapes", *ARGUMENTS, "--json", *map(str, more)]) == 0
    answer: dict[str, Any] = json.loads(capsys.readouterr().out)
    return answer


def test_what_came_of_objects_is_kept_and_judged_anew(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "shapes"
    whole = evaluated(capsys, "--policies", "columns", "rear_side_voxel", "farthest", "random", "oracle", "--out", out)
    rows = {row["name"]: row for row in whole["rows"]}
    assert list(rows) == ["columns", "rear_side_voxel", "farthest", "uniform guess", "oracle"]
    assert rows["uniform guess"]["closed"]["mean"] == [0.0, 0.0]
    assert rows["oracle"]["closed"]["mean"] == pytest.approx([1.0, 1.0])
    assert whole["first"]["mean"][0] > rows["oracle"]["error"]["mean"][0]  # a second view of a bench shows more of its hull
    files = sorted((out / "objects").iterdir())
    kept = [json.loads(file.read_text()) for file in files]
    assert [each["category"] for each in kept] == ["bench", "bench"]
    costs = [np.nanmean(np.minimum(np.abs(np.array(each["errors"], dtype=float)[0, :, :2]), 1)) for each in kept]
    assert rows["uniform guess"]["error"]["mean"][0] == pytest.approx(np.mean(costs))
    assert (out / "shapes.md").read_text().startswith("## The second view of objects of any shape: 2 fresh procedural objects")
    again = evaluated(capsys, "--policies", "random", "oracle", "--out", out)
    assert [row["error"]["mean"] for row in again["rows"]] == [
        rows[name]["error"]["mean"] for name in ("uniform guess", "oracle")
    ]
    assert main(["evaluate", "shapes", *ARGUMENTS, "--captures", "3", "--out", str(out)]) == 2
    assert "holds results of other settings" in capsys.readouterr().err
    for content in ("{", '{"first": [0.1], "errors": []}', '{"first": [0.1, 0.1], "errors": [[[0.1]]]}'):
        files[1].write_text(content)
        assert main(["evaluate", "shapes", *ARGUMENTS, "--policies", "random", "--out", str(out)]) == 2
        assert f"{files[1]}: is damaged" in capsys.readouterr().err


def test_meshes_of_a_folder_are_measured(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "cube").mkdir()
    (tmp_path / "cube" / "one.off").write_text(CUBE)
    options = ("--objects", "2", "--rig", "ring4", "--size", "0.6", "0.6", "--meshes", str(tmp_path))
    assert main(["evaluate", "shapes", *options, "--policies", "farthest", "random", "oracle", "--json"]) == 0
    table = json.loads(capsys.readouterr().out)
    assert table["settings"]["meshes"] == str(tmp_path)
    farthest = table["rows"][0]["error"]["mean"]
    assert max(farthest) < 0.15  # two opposite views show a cube of 35 cm but for the camera's noise
    assert farthest[0] < table["first"]["mean"][0]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--objects", "1"], "wanted 2 or more"),
        (["--policies", "wizard"], "'wizard' is not known; choose from columns,"),
        (["--policies", "network:nowhere.onnx"], "nowhere.onnx: no such file"),
        (["--categories", "ghost"], "got ghost, wanted some of"),
        (["--meshes", "nowhere"], "nowhere"),
        (["--size", "nan", "0.5"], "sizes (nan, 0.5)"),
    ],
)
def test_bad_questions_end_in_one_line(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", "shapes", *arguments]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1

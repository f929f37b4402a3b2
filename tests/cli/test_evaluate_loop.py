"""``viewgain evaluate loop`` through the real command: going on, whoever works and in whatever order, and what goes wrong."""

import json
from pathlib import Path
from typing import Any

import pytest

from viewgain.cli import main

ARGUMENTS = (
    "--boxes", "2", "--seed", "4", "--rig", "ring3", "--side", "0.15", "0.4", "--most-views", "2", "--tolerance", "0.03",
)  # fmt: skip


def evaluated(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict[str, Any]:
    assert main(["evaluate", "loop", "--json", *ARGUMENTS, *map(str, arguments)]) == 0
    content: dict[str, Any] = json.loads(capsys.readouterr().out)
    return content


def test_what_is_kept_is_taken_and_the_rest_played_as_in_a_fresh_run(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "results"
    evaluated(capsys, "--policies", "random", "covariance", "--out", out)
    went_on = evaluated(capsys, "--policies", "oracle", "ring", "covariance", "random", "--out", out)
    fresh = evaluated(capsys, "--policies", "random", "covariance", "ring", "oracle", "--workers", "2")
    assert {row["name"]: row for row in went_on["rows"]} == {row["name"]: row for row in fresh["rows"]}
    assert [row["name"] for row in went_on["rows"]] == ["oracle", "ring", "covariance", "random"]
    assert {key: fresh[key] for key in ("settings", "boxes", "columns")} == {
        key: went_on[key] for key in ("settings", "boxes", "columns")
    }
    assert json.loads((out / "loop.json").read_text()) == went_on
    assert (out / "loop.md").read_text().startswith("## Closed loop: 2 fresh boxes of seed 4, rig ring3")
    assert (out / "loop.png").read_bytes().startswith(b"\x89PNG")
    kept = sorted((out / "boxes").iterdir())
    assert [file.name for file in kept] == ["box00000.json", "box00001.json"]
    marked = json.loads(kept[0].read_text())
    assert sorted(marked) == ["covariance", "oracle", "random", "ring"]
    marked["ring"]["final"] = 0.75
    kept[0].write_text(json.dumps(marked))
    again = evaluated(capsys, "--policies", "ring", "--out", out)
    assert again["rows"][0]["means"]["mean"][4] == pytest.approx((0.75 + json.loads(kept[1].read_text())["ring"]["final"]) / 2)
    assert main(["evaluate", "loop", *ARGUMENTS, "--tolerance", "0.04", "--out", str(out)]) == 2
    assert "holds results of other settings" in capsys.readouterr().err
    kept[1].write_text('{"ring": [')
    assert main(["evaluate", "loop", *ARGUMENTS, "--policies", "ring", "--out", str(out)]) == 2
    error = capsys.readouterr().err
    assert "is damaged" in error
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--boxes", "1"], "wanted 2 or more"),
        (["--most-views", "1"], "1 views at most"),
        (["--tolerance", "2"], "tolerance 2.0"),
        (["--confidence", "0"], "confidence 0.0"),
        (["--policies", "wizard"], "'wizard' is not known"),
        (["--policies", "ring", "ring"], "each once"),
        (["--policies", "network:nowhere.onnx"], "nowhere.onnx"),
        (["--rig", "nowhere"], "rig 'nowhere'"),
        (["--camera", "eye"], "camera 'eye'"),
        (["--workers", "0"], "0 workers"),
    ],
)
def test_bad_questions_end_in_one_line(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", "loop", *arguments]) == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if not line.startswith("boxes")]
    assert len([line for line in lines if line.strip()]) == 1
    assert words in lines[-1]

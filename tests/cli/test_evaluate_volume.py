"""``viewgain evaluate volume`` through the real command: figures by hand, going on, and what goes wrong."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from viewgain.cli import main
from viewgain.evaluation import VolumeSettings, case_errors, choice, volume_case
from viewgain.plan import FarthestPolicy

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
    again = evaluated(capsys, "--policies", "farthest", "random", "oracle", "--out", out)
    assert again["rows"][1]["shares"]["mean"][2] != first["rows"][1]["shares"]["mean"][2]
    assert (out / "volume.md").read_text().startswith("## Next best view for volume: 2 fresh boxes of seed 5")
    assert main(["evaluate", "volume", *ARGUMENTS, "--captures", "3", "--out", str(out)]) == 2
    assert "holds results of other settings" in capsys.readouterr().err
    kept[1].write_text("{")
    assert main(["evaluate", "volume", *ARGUMENTS, "--out", str(out)]) == 2
    assert "is damaged" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--boxes", "1"], "wanted 2 or more"),
        (["--policies", "wizard"], "'wizard' is not known"),
        (["--estimator", "eye"], "estimator: got 'eye'"),
        (["--fused", "--estimator", "lines_mended"], "cannot fuse"),
    ],
)
def test_bad_questions_end_in_one_line(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", "volume", *arguments]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1

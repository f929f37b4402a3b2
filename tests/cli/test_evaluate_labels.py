"""``viewgain evaluate labels``, and a network trained and judged on labels with terms, through the real commands."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from viewgain.cli import main
from viewgain.datasets import Dataset, object_errors, with_target
from viewgain.inference import Scorer

PLAIN = "histogram:lines_published:soft"
BOTH = f"{PLAIN}+incidence+border"
SMALL = """
makes = "a small network"
[network]
kind = "compact"
views = 4
points = 64
neighbours = 8
width = 8
centres = [16, 8]
[data]
frame = "camera"
whole_scan = true
validate_on = "samples"
validation_share = 0.2
target = "histogram:lines_published:soft"
divisions = ["same_box", "other_box"]
[training]
iterations = 4
batch = 4
log_every = 2
validate_every = 4
"""


def labels(capsys: pytest.CaptureFixture[str], data: Dataset, *arguments: object) -> dict[str, Any]:
    assert main(["evaluate", "labels", "--json", "--data", str(data.folder), *map(str, arguments)]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    table: dict[str, Any] = json.loads(line)
    return table


def outcome(errors: np.ndarray) -> list[float]:
    """Return what scans from one position of one box cost, how many are near zero, how many are missed: one scan at a time."""
    cost = near = missed = 0.0
    for error in errors:
        cost += 1.0 if np.isnan(error) else min(abs(error), 1.0)
        near += abs(error) <= 0.025
        missed += np.isnan(error)
    return [cost / len(errors), near / len(errors), missed / len(errors)]


def test_the_table_is_what_the_chosen_scans_measure(data: Dataset, capsys: pytest.CaptureFixture[str]) -> None:
    table = labels(capsys, data, "--targets", PLAIN, f"{PLAIN}+incidence=1e6", BOTH)
    errors = object_errors(data, "lines_published")
    worth = np.array([[outcome(row) for row in errors[box]] for box in (0, 1, 2)])
    assert (table["boxes"], table["positions"], table["scans"]) == ([0, 1, 2], 4, len(data))
    rows = {row["name"]: row for row in table["rows"]}
    first = np.array(rows[PLAIN]["best"])
    for target in (PLAIN, f"{PLAIN}+incidence=1e6", BOTH):
        row, scored = rows[target], with_target(data, target)
        best = [0, 0, 0]
        for sample in scored:
            best[sample.object] = int(np.argmax(sample.in_rig_order(sample.targets[target])))
        assert row["best"] == best
        assert row["other_boxes"] == int(np.sum(first != best))
        assert row["other_scans"] == 16 * row["other_boxes"]
        own = worth[np.arange(3), best]
        np.testing.assert_allclose(row["outcomes"]["mean"], own.mean(axis=0), rtol=1e-12)
        if target != PLAIN:
            np.testing.assert_allclose(row["difference"]["mean"], (own - worth[np.arange(3), first]).mean(axis=0), atol=1e-12)
    assert rows[f"{PLAIN}+incidence=1e6"]["other_boxes"] > 0  # else nothing was tried
    assert rows[PLAIN]["difference"] is None
    np.testing.assert_allclose(rows["a position at random"]["outcomes"]["mean"], worth.mean(axis=(0, 1)), rtol=1e-12)
    least = rows["the position of least mean error"]
    assert least["outcomes"]["mean"][0] == pytest.approx(worth[:, :, 0].min(axis=1).mean())
    (always,) = (row for name, row in rows.items() if name.startswith("always position"))
    assert always["outcomes"]["mean"][0] == pytest.approx(worth[:, :, 0].mean(axis=0).min())
    for row in table["rows"]:
        assert row["outcomes"]["low"] <= row["outcomes"]["mean"] <= row["outcomes"]["high"]


def test_equal_labels_have_equal_intervals_and_the_terms_are_shown(data: Dataset, capsys: pytest.CaptureFixture[str]) -> None:
    table = labels(capsys, data, "--targets", PLAIN, f"{PLAIN}+border=0")
    one, other = table["rows"][:2]
    assert one["best"] == other["best"]
    assert one["outcomes"] == other["outcomes"]
    assert other["difference"] == {"mean": [0.0] * 3, "low": [0.0] * 3, "high": [0.0] * 3}
    weighed = {row["name"]: row for row in table["chosen_by"]}
    assert list(weighed) == ["near zero error", "incidence", "border"]
    assert weighed["border"]["by_position"] == [1.0] * 4  # the paper's positions hold these boxes whole
    assert 0 < weighed["incidence"]["widest"] < 1


def test_what_is_printed_and_written_is_the_same(data: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", "labels", "--data", str(data.folder), "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert printed == (tmp_path / "labels.md").read_text()
    table = json.loads((tmp_path / "labels.json").read_text())
    assert [row["name"] for row in table["rows"]][:4] == [PLAIN, f"{PLAIN}+incidence", f"{PLAIN}+border", BOTH]
    assert f"| {BOTH} | " + " | ".join(map(str, table["rows"][3]["best"])) + " |" in printed


@pytest.mark.slow
def test_a_network_is_trained_and_judged_by_labels_with_terms(
    data: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recipe, run, model = tmp_path / "small.toml", tmp_path / "run", tmp_path / "both.onnx"
    recipe.write_text(SMALL)
    assert main(["train", str(recipe), "--data", str(data.folder), "--target", BOTH, "--out", str(run)]) == 0
    assert json.loads((run / "run.json").read_text())["recipe"]["data"]["target"] == BOTH
    assert main(["export", str(run), "--out", str(model)]) == 0
    assert Scorer.load(str(model)).card.training["target"] == BOTH
    capsys.readouterr()
    arguments = ["--json", "--data", str(data.folder), "--models", str(model), "--target", BOTH]
    assert main(["evaluate", "table2", *arguments]) == 0
    table = json.loads(capsys.readouterr().out)
    assert table["target"] == BOTH
    chosen = labels(capsys, data, "--targets", BOTH)["rows"][0]["best"]
    assert list(table["labels"].values()) == chosen
    assert "both" in {row["name"] for row in table["rows"]}
    assert main(["train", "--resume", str(run), "--target", PLAIN]) == 2
    assert "--target" in capsys.readouterr().err


def test_bad_questions_end_in_one_line(data: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recipe = tmp_path / "small.toml"
    recipe.write_text(SMALL)
    shade, folder = f"{PLAIN}+shade", str(data.folder)
    for command, words in [
        (["evaluate", "labels", "--data", folder, "--targets", PLAIN, shade], "got the term 'shade', wanted incidence or border"),
        (["evaluate", "labels", "--data", folder, "--targets", PLAIN, PLAIN], "wanted one or more, each once"),
        (["evaluate", "labels", "--data", folder, "--targets"], "wanted one or more, each once"),
        (["evaluate", "labels", "--data", folder, "--estimator", "default"], "has no errors"),
        (["evaluate", "table2", "--data", folder, "--target", shade], "got the term 'shade', wanted incidence or border"),
        (["train", str(recipe), "--data", folder, "--target", shade, "--out", str(tmp_path / "run")], "got the term 'shade'"),
    ]:
        assert main(command) == 2
        *bar, line = capsys.readouterr().err.strip().splitlines()
        assert line.startswith("viewgain: error: ")
        assert words in line
        assert not bar or command[0] == "train"  # which draws its bar first

"""``viewgain evaluate table2`` through the real command: floors by hand, a network, folds, and what goes wrong."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from viewgain.cli import main
from viewgain.datasets import Dataset
from viewgain.errors import ConfigError
from viewgain.evaluation import leave_out
from viewgain.inference import ModelCard, Scorer
from viewgain.network import NetworkSettings, export_onnx
from viewgain.network import build as build_network

TARGET = "histogram:lines_published:soft"


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A network of fresh weights that takes whole scans."""
    file = tmp_path_factory.mktemp("models") / "fresh.onnx"
    settings = NetworkSettings(kind="compact", views=4, points=64, neighbours=8, width=8, centres=(16, 8))
    card = ModelCard(
        name="fresh", task="t", kind="compact", rig="paper4", views=4, points=64, frame="camera", normalisation="metres"
    )
    export_onnx(build_network(settings, generator=torch.Generator().manual_seed(1)), settings, card, file)
    return file


def evaluated(capsys: pytest.CaptureFixture[str], data: Dataset, *arguments: object) -> list[dict[str, Any]]:
    assert main(["evaluate", "table2", "--json", "--data", str(data.folder), *map(str, arguments)]) == 0
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def test_the_shares_are_those_by_hand(data: Dataset, model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (table,) = evaluated(capsys, data, "--models", model)
    best = {int(number): place for number, place in table["labels"].items()}
    assert (table["same_boxes"], table["other_boxes"]) == ([0, 1], [2])
    rows = {row["name"]: row for row in table["rows"]}
    assert rows["uniform guess"]["same"]["mean"] == [0.25]
    position = int(np.bincount([best[0], best[1]], minlength=4).argmax())
    assert rows["constant absolute position"]["other"]["mean"] == [float(best[2] == position)]
    assert rows["constant relative answer"]["same"]["mean"] == [0.25]
    scorer, right = Scorer.load(model), []
    test = set(data.part("same_box", "test").tolist())
    for index in sorted(test & set(data.part("other_box", "train").tolist())):
        sample = data[index]
        scores = np.roll(scorer.scores(sample.points, frame="camera", seed=index), sample.view)
        right.append(int(np.argmax(scores)) == best[sample.object])
    assert rows["fresh"]["same"]["mean"] == [pytest.approx(np.mean(right))]
    assert rows["fresh"]["milliseconds"] > 0


def test_every_fold_trains_without_its_boxes(data: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    own = tmp_path / "small.toml"
    own.write_text(
        'makes = "a small network"\n[network]\nkind = "compact"\nviews = 4\npoints = 64\nneighbours = 8\nwidth = 8\n'
        'centres = [16, 8]\n[data]\nframe = "camera"\nwhole_scan = true\nvalidate_on = "samples"\nvalidation_share = 0.2\n'
        'divisions = ["same_box", "other_box"]\n[training]\niterations = 4\nbatch = 4\nlog_every = 2\nvalidate_every = 4\n'
    )
    arguments = ("--folds", 2, "--leave", 1, "--recipe", own, "--minutes", 5, "--out", tmp_path / "out")
    _, folds = evaluated(capsys, data, *arguments)
    held = [each["other_boxes"] for each in folds["folds"]]
    assert [tuple(each) for each in held] == leave_out([0, 1, 2], 1, most=2)
    for each in folds["folds"]:
        record = json.loads((tmp_path / "out" / "folds" / str(each["other_boxes"][0]) / "run" / "run.json").read_text())
        assert record["recipe"]["data"]["without"] == each["other_boxes"]
        assert record["facts"]["training"]["objects"] == 2
        assert each["target"] == TARGET
    again = evaluated(capsys, data, *arguments)
    assert again[1] == folds
    assert "## Table 2 over 2 choices" in (tmp_path / "out" / "table2.md").read_text()
    _refused(data, own, tmp_path / "out", capsys)
    _kept(data, arguments, tmp_path / "out", folds, capsys)


def _refused(data: Dataset, own: Path, out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Folds of other settings are not taken for those that are asked for; the recipe counts by what it says, not by its name."""
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    wanted = {"--folds": "2", "--leave": "1", "--recipe": str(own), "--minutes": "5", "--out": str(out)}
    text = own.read_text()
    for change, content in [
        ({"--minutes": "6"}, text),
        ({"--seed": "1"}, text),
        ({"--captures": "49"}, text),
        ({"--target": "tally:1,1,1,0:0"}, text),
        ({}, text.replace("iterations = 4", "iterations = 6")),
    ]:
        own.write_text(content)
        words = [word for pair in (wanted | change).items() for word in pair]
        assert main(["evaluate", "table2", "--data", str(data.folder), *words]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert "holds results of other settings" in line
    own.write_text(text)
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before


def _kept(
    data: Dataset, arguments: tuple[object, ...], out: Path, folds: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    """What is kept is taken as it is, and what is damaged is said."""
    held = folds["folds"][0]["other_boxes"]
    file = out / "folds" / "-".join(map(str, held)) / "table2.json"
    file.write_text(json.dumps(folds["folds"][0] | {"captures": 7}))
    assert evaluated(capsys, data, *arguments)[1]["folds"] == [folds["folds"][0] | {"captures": 7}, folds["folds"][1]]
    for content in (b"{", b"\xff", b"[]", json.dumps(folds["folds"][1]).encode()):
        file.write_bytes(content)
        assert main(["evaluate", "table2", "--data", str(data.folder), *map(str, arguments)]) == 2
        assert f"{file}: is damaged" in capsys.readouterr().err
    (out / "folds" / "settings.json").unlink()
    assert main(["evaluate", "table2", "--data", str(data.folder), *map(str, arguments)]) == 2
    assert "settings that nobody knows" in capsys.readouterr().err


def test_choices_of_boxes_are_all_there_and_different() -> None:
    every = leave_out(range(5), 2)
    assert sorted(every) == sorted({tuple(sorted(each)) for each in every})
    assert len(every) == 10
    assert leave_out(range(5), 2, most=3) == every[:3]
    assert leave_out(range(5), 2, seed=1) != every
    with pytest.raises(ConfigError, match="fewer than there are"):
        leave_out(range(3), 3)


@pytest.mark.parametrize("name", ["table2.json", "table2.md"])
def test_a_table_that_cannot_be_written_is_exit_code_4(
    name: str, data: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).mkdir()
    assert main(["evaluate", "table2", "--data", str(data.folder), "--out", str(tmp_path)]) == 4
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"viewgain: error: {tmp_path / name}: cannot be written")


def test_bad_questions_end_in_one_line(data: Dataset, capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, words in [
        (["--folds", "1"], "add --out"),
        (["--target", "histogram:default:soft"], "has no errors"),
        (["--models", "nowhere.onnx"], "no such file"),
    ]:
        assert main(["evaluate", "table2", "--data", str(data.folder), *arguments]) == 2
        assert words in capsys.readouterr().err

"""``viewgain evaluate table1`` through the real command: figures against torch and by hand, and what goes wrong."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from tests.datasets.engines import Inline
from tests.oracles.networks_on_disk import exported, small_settings
from viewgain.cli import main
from viewgain.datasets import CoverageSettings, Dataset, build, plan_of
from viewgain.datasets import recipe as data_recipe

LIMITS = [0.0, 0.05, 0.03, 0.01, 0.005]


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """Three mugs and three chairs, from two views each."""
    tiny = data_recipe("coverage_paper_tiny")
    assert isinstance(tiny.content, CoverageSettings)
    folder = tmp_path_factory.mktemp("data")
    build(plan_of(replace(tiny, content=replace(tiny.content, starts=2, per_category=3))), folder, engine=Inline())
    return Dataset(folder)


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, Any]]:
    """Networks of fresh weights that take every point of a sample."""
    folder = tmp_path_factory.mktemp("models")
    made = {}
    for name, kind in [("told", "compact_view"), ("untold", "compact")]:
        path = folder / f"{name}.onnx"
        made[name] = (path, exported(path, small_settings(kind, points=512), seed=3))
    return made


def tables(capsys: pytest.CaptureFixture[str], *arguments: object) -> list[dict[str, Any]]:
    assert main(["evaluate", "table1", "--json", *map(str, arguments)]) == 0
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def lost_by(data: Dataset, index: int, network: Any, *, told: bool) -> float:
    """Return what a network gives away on one sample, in rig order, through torch."""
    sample = data[index]
    points = torch.from_numpy(np.unique(sample.points, axis=0))[None]
    state = np.roll(sample.state, sample.view)
    with torch.no_grad():
        seen = torch.from_numpy(state.astype(np.float32))[None] if told else None
        scores = network(points, torch.ones(points.shape[:2], dtype=torch.bool), seen)[0].double().numpy()
    gains = np.roll(sample.targets["gain_published"].astype(float), sample.view)
    ranked = scores if told else np.roll(scores, sample.view)
    open_views = [view for view in range(16) if not state[view]]
    chosen = max(open_views, key=lambda view: ranked[view])
    return float(max(gains[view] for view in open_views) - gains[chosen])


def test_the_shares_of_networks_are_those_of_torch_by_hand(
    data: Dataset, models: dict[str, tuple[Path, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    both = tables(capsys, "--data", data.folder, "--models", models["told"][0], models["untold"][0])
    assert [table["split"] for table in both] == ["same_category", "other_category"]
    seen, unseen = (set(data.part("other_category", part).tolist()) for part in ("train", "test"))
    wanted_rows = [seen & set(data.part("same_category", "test").tolist()), unseen]
    first, second = ({row["name"]: row["shares"]["mean"] for row in table["rows"]} for table in both)
    assert both[0]["kept"] == []
    for each in both[1]["kept"]:
        assert each["shares"]["mean"] == pytest.approx(np.divide(second[each["name"]], first[each["name"]]))
    for table, rows in zip(both, wanted_rows, strict=True):
        assert (table["rig"], table["frame"], table["views"], table["samples"]) == ("pcnbv16", "object", 16, len(rows))
        by_name = {row["name"]: row for row in table["rows"]}
        for name in ("told", "untold"):
            lost = np.array([lost_by(data, row, models[name][1], told=name == "told") for row in sorted(rows)])
            assert by_name[name]["shares"]["mean"] == pytest.approx([np.mean(lost <= limit + 1e-6) for limit in LIMITS])
            assert by_name[name]["milliseconds"] > 0
        assert by_name["oracle"]["shares"]["mean"] == [1.0] * 5
        (paired,) = [each for each in table["differences"] if (each["first"], each["second"]) == ("untold", "told")]
        apart = np.subtract(by_name["untold"]["shares"]["mean"], by_name["told"]["shares"]["mean"])
        assert paired["shares"]["mean"] == pytest.approx(apart)


def test_the_constant_answer_is_chosen_on_training_rows_alone(data: Dataset, capsys: pytest.CaptureFixture[str]) -> None:
    (table,) = tables(capsys, "--data", data.folder, "--split", "other_category", "--floors-only")
    learned = np.intersect1d(data.part("same_category", "train"), data.part("other_category", "train"))
    best = [int(np.argmax(data[row].targets["gain_published"])) for row in learned.tolist()]
    assert table["constant_samples"] == len(learned) > 0
    (offset,) = table["offsets"]
    assert table["constant_chosen"] == "training"
    assert best.count(offset) == max(best.count(view) for view in range(16))
    gains = [data[row].targets["gain_published"] for row in data.part("other_category", "test").tolist()]
    exact = np.mean([each[offset] == each.max() for each in gains])
    assert {row["name"]: row for row in table["rows"]}["constant answer"]["shares"]["mean"][0] == pytest.approx(exact)


@pytest.mark.slow
def test_the_command_prints_a_table_and_writes_it(data: Dataset, models: dict[str, tuple[Path, Any]], tmp_path: Path) -> None:
    command = [sys.executable, "-m", "viewgain", "evaluate", "table1", "--data", data.folder, "--models", models["untold"][0]]
    done = subprocess.run([*command, "--out", tmp_path / "a"], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout == (tmp_path / "a" / "table1.md").read_text()
    assert done.stdout.count("| untold |") == 4  # its row and the gap that it closes, in two tables
    assert "object frame" in done.stdout
    assert "rig pcnbv16, 16 views" in done.stdout
    lines = (tmp_path / "a" / "table1.json").read_text().splitlines()
    assert [json.loads(line)["split"] for line in lines] == ["same_category", "other_category"]


def without_times(table: dict[str, Any]) -> dict[str, Any]:
    """Return a table without what no seed decides."""
    return {**table, "rows": [{**row, "milliseconds": None} for row in table["rows"]]}


def test_the_same_seed_gives_the_same_intervals(data: Dataset, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ("--data", data.folder, "--split", "other_category", "--seed", 7)
    first, again = ([without_times(table) for table in tables(capsys, *arguments)] for _ in range(2))
    assert first == again


def test_wrong_input_is_one_line_and_exit_code_2(
    data: Dataset, models: dict[str, tuple[Path, Any]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = small_settings("compact")
    exported(tmp_path / "ring.onnx", settings, rig="ring16")
    exported(tmp_path / "camera.onnx", settings, frame="camera")
    (tmp_path / "untold.onnx").write_bytes(models["untold"][0].read_bytes())
    (tmp_path / "broken.onnx").write_bytes(models["untold"][0].read_bytes()[:500])
    for arguments, word in [
        (("--data", tmp_path), "holds no data set"),
        (("--data", data.folder, "--models", tmp_path / "ring.onnx"), "rig ring16, not of pcnbv16"),
        (("--data", data.folder, "--models", tmp_path / "camera.onnx"), "camera frame"),
        (("--data", data.folder, "--models", tmp_path / "none.onnx"), "no such file"),
        (("--data", data.folder, "--models", tmp_path / "broken.onnx"), "cannot be read as a network"),
        (("--data", data.folder, "--models", models["untold"][0], tmp_path / "untold.onnx"), "different names"),
        (("--data", data.folder, "--target", "gain", "--floors-only"), "gain_published, gain_union"),
        ((), "got no objects, wanted one of --data"),
        (("--data", data.folder, "--fresh", "2"), "got --data and --fresh"),
        (("--fresh", "9", "--models", tmp_path / "ring.onnx"), "rig ring16, not of pcnbv16"),
        (("--fresh", "9", "--models", tmp_path / "camera.onnx"), "camera frame"),
        (("--fresh", "0"), "wanted at least 1"),
        (("--fresh", "1", "--seed", "-1"), "wanted 0 or more"),
        (("--fresh", "1", "--limit", "1"), "--limit with --fresh"),
        (("--meshes", tmp_path / "none"), "none"),
        (("--meshes", tmp_path, "--split", "same_category"), "got --split with --meshes"),
        (("--data", data.folder, "--models", models["untold"][0], "--floors-only"), "one of them"),
    ]:
        assert main(["evaluate", "table1", *map(str, arguments)]) == 2
        said = capsys.readouterr().err.strip()
        assert said.startswith("viewgain: error:")
        assert "\n" not in said
        assert word in said


def test_a_folder_that_cannot_be_written_is_exit_code_4(
    data: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    arguments = ("--data", data.folder, "--split", "other_category", "--out", tmp_path / "file" / "under")
    assert main(["evaluate", "table1", *map(str, arguments)]) == 4
    assert "cannot be made" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["table1.json", "table1.md", "table1.png"])
def test_a_file_that_cannot_be_written_is_exit_code_4(
    name: str, data: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).mkdir()
    arguments = ("--data", data.folder, "--split", "other_category", "--floors-only", "--out", tmp_path)
    assert main(["evaluate", "table1", *map(str, arguments)]) == 4
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"viewgain: error: {tmp_path / name}: cannot be written")
    assert not list(tmp_path.glob(".*"))


def test_the_help_names_every_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    said = capsys.readouterr().out
    for name in ("table1", "table2", "coverage", "volume"):
        assert f"viewgain evaluate {name} " in said

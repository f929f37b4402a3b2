"""Networks for volume from data to file: views that differ in number, what cannot be reached, and the planner that uses them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.datasets.engines import Inline
from viewgain.cli import main
from viewgain.datasets import Dataset, build, plan_of, recipe
from viewgain.errors import DataError
from viewgain.inference import Scorer, around_middle
from viewgain.training import Batches, load_examples, training_recipe


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six boxes on random rigs of three to five stations."""
    folder = tmp_path_factory.mktemp("data") / "volume"
    build(plan_of(recipe("volume_random_tiny")), folder, engine=Inline())
    return folder


def test_examples_hold_every_candidate_with_its_pose(data: Path) -> None:
    settings = training_recipe("volume_tiny").data
    opened = Dataset(data)
    examples = load_examples(opened, settings, views=5, seed=0, with_poses=True)
    assert examples.candidates is not None
    assert examples.valid is not None
    assert len(examples) == len(opened)
    for index in range(len(opened)):
        sample, count = opened[index], len(opened[index].candidates)
        assert examples.valid[index, :count].numpy().tolist() == sample.reachable.tolist()
        assert not examples.valid[index, count:].any()
        own = examples.targets[index, :count][examples.valid[index, :count]].numpy()
        assert own == pytest.approx(sample.targets["volume_alone"][sample.reachable])
        assert examples.candidates[index, :count].numpy() == pytest.approx(sample.candidates)
    assert torch.all(examples.targets[~examples.valid] < -1)
    with pytest.raises(DataError, match="wanted at most 3"):
        load_examples(opened, settings, views=3, seed=0, with_poses=True)
    batches = Batches(examples, settings, rows=np.arange(len(examples)), batch=4, points=32, uses_state=False, seed=1)
    first, again = batches.at(3), batches.at(3)
    assert first.told is not None
    assert first.told.shape == (4, 5, 4, 4)
    assert torch.equal(first.told, again.told if again.told is not None else torch.zeros(0))


def test_a_network_is_trained_exported_and_asked_on_fresh_boxes(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run, file = tmp_path / "run", tmp_path / "volume.onnx"
    assert main(["train", "volume_tiny", "--data", str(data), "--out", str(run)]) == 0
    assert main(["export", str(run), "--out", str(file)]) == 0
    record = json.loads((run / "run.json").read_text())
    assert 0 < record["facts"]["floors"]["view at random"]["exact"] <= 1
    capsys.readouterr()
    arguments = ["--boxes", "2", "--captures", "2", "--estimator", "lines_published", "--side", "0.2", "0.4", "--seed", "8"]
    policies = ["--policies", f"network:{file}", f"combined:{file}", "random"]
    assert main(["evaluate", "volume", "--json", *arguments, *policies]) == 0
    table = json.loads(capsys.readouterr().out)
    assert [row["name"] for row in table["rows"]] == [*policies[1:3], "uniform guess"]
    assert all(row["undecided"] == 0 for row in table["rows"])
    assert 0 < table["rows"][0]["milliseconds"] < table["rows"][1]["milliseconds"]
    out, copy = tmp_path / "loop", tmp_path / "copy.onnx"
    looped = ["--boxes", "2", "--rig", "ring2", "--most-views", "2", "--side", "0.2", "0.3", "--out", str(out), "--json"]
    assert main(["evaluate", "loop", *looped, *policies]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert [(row["name"], row["undecided"]) for row in rows] == [(name, 0) for name in policies[1:]]
    copy.write_bytes(file.read_bytes())
    kept = [each.read_text() for each in sorted((out / "boxes").iterdir())]
    assert main(["evaluate", "loop", *looped, "--policies", f"network:{copy}"]) == 0  # known by what it holds: not played again
    assert json.loads(capsys.readouterr().out)["rows"][0]["errors"] == rows[0]["errors"]
    assert [each.read_text() for each in sorted((out / "boxes").iterdir())] == kept
    assert main(["simulate", "--out", str(tmp_path / "scans"), "--seed", "3"]) == 0
    scan = next((tmp_path / "scans").rglob("*.npz"))
    capsys.readouterr()
    ranked = {}
    for policy in ("network", "combined"):
        assert main(["next", str(scan), "--policy", policy, "--model", str(file), "--json"]) == 0
        ranked[policy] = json.loads(capsys.readouterr().out)
        assert (ranked[policy]["policy"], len(ranked[policy]["candidates"])) == (policy, 8)
    assert ranked["network"]["candidates"] != ranked["combined"]["candidates"]
    two = ["--model", str(file), str(file)]
    assert main(["next", str(scan), "--policy", "network", *two]) == 2
    assert "wanted one that was trained for volumes" in capsys.readouterr().err
    assert main(["evaluate", "volume", *arguments, "--policies", "network:nowhere.onnx"]) == 2
    assert "no such file" in capsys.readouterr().err


def test_of_whole_scans_only_what_lies_about_the_middle_is_learned_from(tmp_path: Path) -> None:
    folder, run, file = tmp_path / "boxes", tmp_path / "run", tmp_path / "paper.onnx"
    assert main(["dataset", "build", "boxes_paper_tiny", "--out", str(folder)]) == 0
    opened, settings = Dataset(folder), replace(training_recipe("volume_paper_tally").data, target="tally:1,1,0,0:0")
    near = load_examples(opened, settings, views=4, seed=0)
    whole = load_examples(opened, replace(settings, within=0.0), views=4, seed=0)
    assert torch.all(near.counts < whole.counts)
    rows = np.intersect1d(*(opened.part(division, "train") for division in settings.divisions))
    for points, count, row in zip(near.points, near.counts, rows.tolist(), strict=True):
        sample = opened[row]
        kept = around_middle(sample.points, 0.75)
        held = points[:count].double().numpy()
        assert len(held) == min(len(kept), settings.resident)
        assert np.linalg.norm(held - held.mean(axis=0), axis=1).max() < 1.5
        assert {tuple(each) for each in held} <= {tuple(each) for each in kept.astype(np.float16).astype(float)}
    trained = ["train", "volume_paper_tally", "--data", str(folder), "--out", str(run), "--iterations", "3"]
    trained += ["--target", settings.target]
    assert main(trained) == 0
    assert main(["export", str(run), "--out", str(file)]) == 0
    scorer, sample = Scorer.load(file), opened[0]
    assert scorer.card.within == settings.within
    assert "within 0.75 m" in file.with_suffix(".md").read_text()
    near_alone = around_middle(sample.points, 0.75)
    assert scorer.scores(sample.points).tolist() == scorer.scores(near_alone).tolist()

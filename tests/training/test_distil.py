"""Distillation: the student follows the teacher, in its own order of views; a teacher that means something else is refused."""

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.oracles.networks_on_disk import card_of, exported, small_settings
from tests.training.conftest import changed
from tests.training.test_train import Stop, losses, stop_after
from viewgain.cli import main
from viewgain.datasets import Dataset
from viewgain.errors import ConfigError, ModelError, TrainingError
from viewgain.inference import Scorer
from viewgain.network import scores_of
from viewgain.training import (
    Batch,
    Batches,
    DataSettings,
    RunFolder,
    TrainingRecipe,
    export_run,
    in_order,
    load_examples,
    load_trained,
    open_teacher,
    read_checkpoint,
    resume,
    start,
    symmetries,
)
from viewgain.training._teacher import _by_rule, check_teacher

MOST_POINTS = 64


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Networks of fresh weights by name."""
    made = tmp_path_factory.mktemp("teachers")
    exported(made / "blind.onnx", small_settings("compact"), seed=3)
    exported(made / "told.onnx", small_settings("compact_view"), seed=4)
    exported(made / "sure.onnx", small_settings("compact", uncertainty="gaussian"), seed=3)
    exported(made / "seen.onnx", small_settings("compact"), seed=3, normalisation="seen_box")
    exported(made / "camera.onnx", small_settings("compact"), frame="camera")
    exported(made / "other_rig.onnx", small_settings("compact"), rig="hemisphere16")
    exported(made / "fewer.onnx", small_settings("compact", views=8), rig="pcnbv16")
    exported(made / "other_scores.onnx", small_settings("compact"), training={"target": "gain_union"})
    return made


def taught_by(teacher: Path, *, weight: float = 1.0, kind: str = "compact", **tables: dict[str, object]) -> TrainingRecipe:
    network = {"kind": kind, **tables.pop("network", {})}
    return changed(network=network, distil={"teacher": str(teacher), "weight": weight}, **tables)


def batch_of(data: Dataset, recipe: TrainingRecipe, **settings: object) -> Batch:
    """Return the second batch of 16 drawn rows."""
    examples = load_examples(data, recipe.data, views=16, seed=0)
    teacher = open_teacher(recipe, "pcnbv16", "cpu")
    source = Batches(
        examples, DataSettings(resident=MOST_POINTS, **settings), rows=np.arange(len(examples)), batch=16,
        points=recipe.network.points, uses_state=recipe.network.with_view_state, seed=3, teacher=teacher,
        symmetries=symmetries(examples.poses, "object") if settings.get("symmetry") else None,
    )  # fmt: skip
    return source.at(1)


def answers(path: Path, batch: Batch) -> np.ndarray:
    return np.asarray(Scorer.load(path).run(batch.points.numpy(), batch.mask.numpy(), batch.states))


@pytest.mark.parametrize("symmetry", [False, True])
@pytest.mark.parametrize(("name", "kind"), [("blind", "compact"), ("told", "compact_view")])
def test_what_is_taught_is_what_the_teacher_says_of_the_cloud(
    name: str, kind: str, symmetry: bool, folder: Path, data: Dataset
) -> None:
    recipe = taught_by(folder / f"{name}.onnx", kind=kind, network={"points": 64})
    batch = batch_of(data, recipe, symmetry=symmetry)
    np.testing.assert_allclose(batch.taught, answers(folder / f"{name}.onnx", batch), atol=1e-6)


def test_noise_and_hidden_points_are_the_student_s_alone(folder: Path, data: Dataset) -> None:
    recipe = taught_by(folder / "blind.onnx")
    plain, disturbed = batch_of(data, recipe), batch_of(data, recipe, jitter=0.01, dropout=0.8)
    assert not torch.equal(plain.points, disturbed.points)
    assert torch.equal(plain.taught, disturbed.taught)
    alone = changed()
    assert torch.equal(batch_of(data, alone).points, plain.points)  # a teacher changes nothing of what is drawn


def test_a_teacher_with_the_view_state_speaks_in_the_order_of_a_student_without(folder: Path, data: Dataset) -> None:
    told = batch_of(data, taught_by(folder / "told.onnx", kind="compact_view"))
    blind = batch_of(data, taught_by(folder / "told.onnx"))
    present = told.states.argmax(1).tolist()
    by_hand = [np.roll(scores, -view) for scores, view in zip(told.taught.numpy(), present, strict=True)]
    np.testing.assert_array_equal(blind.taught, np.stack(by_hand))
    assert len(set(present)) > 1


def test_a_teacher_has_its_own_rule_and_its_uncertainty_is_left_out(folder: Path, data: Dataset) -> None:
    batch = batch_of(data, taught_by(folder / "seen.onnx", network={"points": 64}))
    cloud = batch.points[2][batch.mask[2]].double().numpy()
    np.testing.assert_allclose(batch.taught[2], Scorer.load(folder / "seen.onnx").scores(cloud), atol=1e-5)
    assert not np.allclose(batch.taught, answers(folder / "seen.onnx", batch), atol=1e-4)
    sure = batch_of(data, taught_by(folder / "sure.onnx", network={"points": 64}))
    np.testing.assert_allclose(sure.taught, answers(folder / "sure.onnx", sure)[..., 0], atol=1e-6)


def test_a_student_of_weight_1_follows_its_teacher_and_not_the_labels(folder: Path, data: Dataset, tmp_path: Path) -> None:
    path = folder / "blind.onnx"
    steps = {"iterations": 60, "validate_every": 20}
    examples = load_examples(data, changed().data, views=16, seed=0)
    ((_, batch),) = in_order(examples, np.arange(32), batch=32, points=64, uses_state=False)
    teacher, labels = torch.from_numpy(answers(path, batch)), batch.targets
    apart = {}
    for name, recipe in (("taught", taught_by(path, training=steps)), ("alone", changed(training=steps))):
        start(recipe, tmp_path / name, data=data.folder)
        with torch.no_grad():
            found = scores_of(load_trained(tmp_path / name).module(batch.points, batch.mask))
        apart[name] = [float((found - wanted).square().mean()) for wanted in (teacher, labels)]
    assert apart["taught"][0] < 0.5 * apart["taught"][1]
    assert apart["alone"][1] < 0.8 * apart["taught"][1]
    assert apart["taught"][0] < 0.5 * apart["alone"][0]


def test_a_run_teaches_as_its_exported_file_does(data: Dataset, tmp_path: Path) -> None:
    start(changed(network={"kind": "compact_view"}), tmp_path / "run", data=data.folder)
    export_run(tmp_path / "run", tmp_path / "net.onnx")
    by_run = batch_of(data, taught_by(tmp_path / "run"))
    by_file = batch_of(data, taught_by(tmp_path / "net.onnx"))
    torch.testing.assert_close(by_run.taught, by_file.taught, rtol=0, atol=2e-3)  # the file holds half floats
    assert float(by_run.taught.std()) > 1e-3


@pytest.mark.parametrize("stopped", [3, 8])
def test_resume_with_a_teacher_is_exact_to_the_bit(stopped: int, folder: Path, data: Dataset, tmp_path: Path) -> None:
    recipe = taught_by(folder / "told.onnx", weight=0.7, loss={"ranking": "listwise"})
    recipe = replace(recipe, distil=replace(recipe.distil, temperature=0.1))
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    start(recipe, whole, data=data.folder)
    with pytest.raises(Stop):
        start(recipe, killed, data=data.folder, watch=stop_after(stopped))
    resume(killed)
    assert losses(killed) == losses(whole)
    found, wanted = (read_checkpoint(each / "best.safetensors").tensors for each in (killed, whole))
    assert all(torch.equal(found[key], wanted[key]) for key in wanted)


def test_a_run_goes_on_with_its_own_teacher_wherever_that_lies(folder: Path, data: Dataset, tmp_path: Path) -> None:
    moved, run = tmp_path / "moved.onnx", tmp_path / "run"
    moved.write_bytes((folder / "blind.onnx").read_bytes())
    with pytest.raises(Stop):
        start(taught_by(moved), run, data=data.folder, watch=stop_after(5))
    moved.rename(tmp_path / "elsewhere.onnx")
    with pytest.raises(ModelError, match="no such file"):
        resume(run)
    with pytest.raises(TrainingError, match="not the file"):
        resume(run, teacher=folder / "told.onnx")
    assert resume(run, teacher=tmp_path / "elsewhere.onnx").step == 12
    with pytest.raises(Stop):
        start(changed(), tmp_path / "alone", data=data.folder, watch=stop_after(5))
    with pytest.raises(ConfigError, match="has none"):
        resume(tmp_path / "alone", teacher=folder / "told.onnx")


def test_a_teacher_that_scores_poses_is_refused() -> None:
    card = card_of(small_settings("compact"), kind="pose_scores")
    with pytest.raises(ConfigError, match="scores poses"):
        check_teacher(card, taught_by(Path("a.onnx")), "pcnbv16")


@pytest.mark.parametrize(("within", "fits"), [(0.75, True), (0.0, False), (0.5, False)])
def test_a_teacher_looks_at_what_the_student_looks_at(within: float, fits: bool) -> None:
    card = card_of(small_settings("compact"), frame="camera", normalisation="metres", within=0.75)
    recipe = taught_by(Path("a.onnx"))
    recipe = replace(recipe, data=replace(recipe.data, frame="camera", whole_scan=True, within=within))
    with nullcontext() if fits else pytest.raises(ConfigError, match=f"points within 0.75, wanted {within}"):
        check_teacher(card, recipe, "pcnbv16")
    points = torch.rand(2, 40, 3) + torch.tensor([0.0, 0.0, 1.5])
    assert torch.equal(_by_rule(points, torch.ones(2, 40, dtype=torch.bool), card), points)


@pytest.mark.parametrize(
    ("name", "kind", "word"),
    [
        ("other_rig", "compact", "rig hemisphere16"),
        ("fewer", "compact", "views 8"),
        ("camera", "compact", "frame camera"),
        ("other_scores", "compact", "gain_union"),
        ("blind", "compact_view", "not told"),
    ],
)
def test_a_teacher_that_means_something_else_is_refused(name: str, kind: str, word: str, folder: Path) -> None:
    with pytest.raises(ConfigError, match=word):
        open_teacher(taught_by(folder / f"{name}.onnx", kind=kind), "pcnbv16", "cpu")


def test_a_table_without_sense_is_refused(tmp_path: Path) -> None:
    for table in ({"weight": 0.5}, {"teacher": ""}, {"teacher": "a", "weight": 0.0}, {"teacher": "a", "temperature": 0.0}):
        with pytest.raises(ConfigError, match="distil"):
            changed(distil=table)
    with pytest.raises(TrainingError, match="holds no run"):
        open_teacher(taught_by(tmp_path), "pcnbv16", "cpu")


def test_the_command_names_a_teacher_and_the_card_does_too(
    folder: Path, data: Dataset, recipe_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run, teacher = tmp_path / "run", folder / "blind.onnx"
    arguments = ["train", str(recipe_file), "--data", str(data.folder), "--out", str(run), "--device", "cpu"]
    assert main([*arguments, "--teacher", str(teacher)]) == 0
    record = RunFolder(run).read()
    assert record.recipe.distil.teacher == str(teacher)
    assert record.facts["teacher"]["name"] == "small"
    assert export_run(run, tmp_path / "net.onnx").training["teacher"] == "small, weight 0.5"
    assert main([*arguments[:4], "--out", str(tmp_path / "b"), "--teacher", str(tmp_path / "none.onnx")]) == 2
    assert "no such file" in capsys.readouterr().err

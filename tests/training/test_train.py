import json
import os
import pickle
from pathlib import Path

import pytest
import torch

from tests.training.conftest import changed
from viewgain.datasets import Dataset
from viewgain.errors import ConfigError, DataError, TrainingError
from viewgain.network import NetworkSettings, build
from viewgain.training import (
    Checkpoint,
    Means,
    RunFolder,
    TrainingRecipe,
    load_examples,
    load_trained,
    newest_good,
    read_checkpoint,
    resume,
    start,
    write_checkpoint,
)


class Stop(Exception):  # noqa: N818 - it stands for a kill
    """Ends a run in the middle."""


def stop_after(steps: int):  # type: ignore[no-untyped-def]
    def watch(step: int, progress: object) -> None:
        if step == steps:
            raise Stop

    return watch


def losses(folder: Path) -> list[tuple[int, object]]:
    """Return what of the metrics must be the same on every run."""
    return [(line["step"], line.get("validation", line.get("loss"))) for line in RunFolder(folder).metrics()]


@pytest.fixture(scope="module")
def whole(data: Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run from start to end."""
    folder = tmp_path_factory.mktemp("runs") / "whole"
    outcome = start(changed(), folder, data=data.folder)
    assert (outcome.reason, outcome.step) == ("iterations", 12)
    return folder


def test_the_loss_falls(data: Dataset, tmp_path: Path) -> None:
    start(changed(training={"iterations": 60}), tmp_path / "run", data=data.folder)
    curve = [line["loss"] for line in RunFolder(tmp_path / "run").metrics() if "loss" in line]
    assert curve[-1] < 0.5 * curve[0]


def test_a_run_explains_itself(whole: Path, data: Dataset) -> None:
    record = RunFolder(whole).read()
    assert record.recipe == changed()
    assert record.plan == data.manifest.plan
    assert record.facts["versions"]["torch"] == torch.__version__
    assert record.facts["training"] == {"samples": 16, "objects": 1}
    assert record.facts["floors"]["view at random"]["exact"] == pytest.approx(1 / 15)  # the present view cannot be chosen
    assert [step for step, _ in losses(whole)] == [2, 4, 4, 6, 8, 8, 10, 12, 12]


@pytest.mark.parametrize("stopped", [1, 5, 8, 11])
def test_resume_is_exact_to_the_bit(stopped: int, whole: Path, data: Dataset, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    with pytest.raises(Stop):
        start(changed(), folder, data=data.folder, watch=stop_after(stopped))
    outcome = resume(folder)
    assert (outcome.reason, outcome.step) == ("iterations", 12)
    assert losses(folder) == losses(whole)
    for name in ("best.safetensors", "checkpoints/step-000000012.safetensors"):
        found, wanted = read_checkpoint(folder / name), read_checkpoint(whole / name)
        assert found.tensors.keys() == wanted.tensors.keys()
        assert all(torch.equal(found.tensors[key], wanted.tensors[key]) for key in wanted.tensors)


@pytest.mark.parametrize("damage", ["cut", "bit", "empty"])
def test_with_the_last_checkpoint_damaged_the_one_before_is_used(damage: str, whole: Path, data: Dataset, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    with pytest.raises(Stop):
        start(changed(), folder, data=data.folder, watch=stop_after(9))
    newest = folder / "checkpoints" / "step-000000008.safetensors"
    content = bytearray(newest.read_bytes())
    content[-5] ^= 1
    newest.write_bytes({"cut": content[: len(content) // 2], "bit": content, "empty": b""}[damage])
    found = newest_good(folder / "checkpoints")
    assert found is not None
    assert found.state["step"] == 6
    resume(folder)
    assert losses(folder) == losses(whole)


def test_with_every_checkpoint_damaged_it_says_so(data: Dataset, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    with pytest.raises(Stop):
        start(changed(), folder, data=data.folder, watch=stop_after(9))
    for path in (folder / "checkpoints").iterdir():
        path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(TrainingError, match="damaged"):
        resume(folder)


def test_nothing_is_unpickled(tmp_path: Path) -> None:
    class Evil:
        def __reduce__(self) -> tuple[object, tuple[str]]:
            return os.mkdir, (str(tmp_path / "ran"),)

    path = tmp_path / "step-000000001.safetensors"
    path.write_bytes(pickle.dumps(Evil()))
    with pytest.raises(TrainingError, match="cannot be read"):
        read_checkpoint(path)
    assert not (tmp_path / "ran").exists()


def test_a_checkpoint_comes_back_whole(tmp_path: Path) -> None:
    tensors = {
        "a.b": torch.randn(3, 2),
        "c": torch.tensor(7),
        "half": torch.ones(2, dtype=torch.bfloat16),
        "none": torch.zeros(0),
    }
    write_checkpoint(tmp_path / "x", Checkpoint(tensors=tensors, state={"step": 3, "best": None}))
    found = read_checkpoint(tmp_path / "x")
    assert found.state == {"step": 3, "best": None}
    assert all(torch.equal(found.tensors[name], tensor) for name, tensor in tensors.items())
    assert list(found.part("a")) == ["b"]


def test_only_the_last_two_checkpoints_stay(whole: Path) -> None:
    assert sorted(path.name[-9 - 12 :] for path in (whole / "checkpoints").iterdir()) == [
        "000000010.safetensors",
        "000000012.safetensors",
    ]


def test_a_gradient_that_is_no_number_stops_the_run_and_spares_the_weights(data: Dataset, tmp_path: Path) -> None:
    recipe = changed(training={"learning_rate": 1e18, "average": 0.0})
    outcome = start(recipe, tmp_path / "run", data=data.folder)
    assert outcome.reason == "not_finite"
    assert outcome.step < 12
    last = newest_good(tmp_path / "run" / "checkpoints")
    assert last is not None
    assert all(torch.isfinite(tensor).all() for tensor in last.part("model").values())


def test_it_stops_when_nothing_gets_better(data: Dataset, tmp_path: Path) -> None:
    recipe = changed(training={"learning_rate": 1e-30, "average": 0.0, "patience": 2, "iterations": 100})
    outcome = start(recipe, tmp_path / "run", data=data.folder)
    assert (outcome.reason, outcome.step) == ("early_stop", 12)
    assert outcome.best is not None
    assert outcome.best["step"] == 4


def test_it_stops_at_the_time_limit_and_goes_on_with_another(data: Dataset, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    outcome = start(changed(), folder, data=data.folder, means=Means(minutes=1e-6))
    assert (outcome.reason, outcome.step) == ("minutes", 2)
    assert load_trained(folder).figures["step"] == 2
    assert resume(folder).step == 12


def test_the_figures_of_the_best_weights_are_those_of_the_network_that_is_loaded(whole: Path) -> None:
    trained = load_trained(whole)
    found = [line["validation"] for line in RunFolder(whole).metrics() if "validation" in line]
    assert trained.figures["loss"] == min(each["loss"] for each in found)
    assert not trained.module.training


def test_the_state_of_the_rest_of_the_program_is_left_alone(data: Dataset, recipe: TrainingRecipe, tmp_path: Path) -> None:
    before = torch.get_rng_state()
    start(recipe, tmp_path / "run", data=data.folder)
    assert torch.equal(before, torch.get_rng_state())


@pytest.mark.parametrize("kind", ["pc_nbv", "pc_nbv_noview", "compact_view"])
def test_every_kind_trains(kind: str, data: Dataset, tmp_path: Path) -> None:
    network = {"kind": kind, "shared": [16], "head": [8]}
    recipe = changed(network=network, training={"iterations": 4}, loss={"ranking": "listwise", "kind": "half_sum"})
    assert start(recipe, tmp_path / "run", data=data.folder).step == 4


def test_half_precision_and_symmetry_train(data: Dataset, tmp_path: Path) -> None:
    recipe = changed(data={"symmetry": True}, training={"precision": "bfloat16", "iterations": 4})
    assert start(recipe, tmp_path / "run", data=data.folder).reason == "iterations"


def test_motions_that_leave_a_place_vacant_are_shown_only_where_the_recipe_says_so(data: Dataset, tmp_path: Path) -> None:
    """The first loss is of the same weights and samples: only how they are shown differs, and what counts of their scores."""
    settings = {"iterations": 1, "log_every": 1, "validate_every": 1}
    shown = []
    for name, keys in {"two": {"symmetry": True}, "again": {"symmetry": True}, "all": {"symmetry": True, "vacant": 1}}.items():
        start(changed(data=keys, training=settings), tmp_path / name, data=data.folder)
        shown.append(losses(tmp_path / name)[0])
    assert shown[0] == shown[1] != shown[2]
    with pytest.raises(ConfigError, match="vacant"):
        changed(data={"vacant": 1})


def test_wrong_folders_are_refused(whole: Path, data: Dataset, recipe: TrainingRecipe, tmp_path: Path) -> None:
    with pytest.raises(TrainingError, match="holds a run already"):
        start(recipe, whole, data=data.folder)
    with pytest.raises(TrainingError, match="holds no run"):
        resume(tmp_path / "nowhere")
    with pytest.raises(DataError, match="holds no data set"):
        start(recipe, tmp_path / "run", data=tmp_path / "nowhere")
    with pytest.raises(ConfigError, match="--data"):
        start(recipe, tmp_path / "other")
    with pytest.raises(TrainingError, match="holds no run"):
        load_trained(tmp_path)


def test_other_data_than_it_began_with_is_refused(whole: Path, data: Dataset, tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.mkdir()
    manifest = json.loads((data.folder / "manifest.json").read_text())
    (other / "manifest.json").write_text(json.dumps({**manifest, "plan": "0" * 64}))
    with pytest.raises(DataError, match="other data"):
        resume(whole, data=other)


@pytest.mark.parametrize("content", ["", "{}", '{"schema": 9}', "[1]"])
def test_a_damaged_run_record_is_one_line(content: str, tmp_path: Path) -> None:
    (tmp_path / "run.json").write_text(content)
    with pytest.raises(TrainingError, match=r"run\.json"):
        RunFolder(tmp_path).read()


@pytest.mark.parametrize("stopped", [5, 8])
def test_in_half_precision_the_loss_falls_and_resume_is_exact_to_the_bit(stopped: int, data: Dataset, tmp_path: Path) -> None:
    recipe = changed(training={"precision": "bfloat16", "iterations": 40}, network={"kind": "compact_view"})
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    start(recipe, whole, data=data.folder)
    curve = [line["loss"] for line in RunFolder(whole).metrics() if "loss" in line]
    assert curve[-1] < 0.5 * curve[0]
    single = changed(training={"iterations": 40}, network={"kind": "compact_view"})
    start(single, tmp_path / "single", data=data.folder)
    assert losses(tmp_path / "single") != losses(whole)  # it does something
    with pytest.raises(Stop):
        start(recipe, killed, data=data.folder, watch=stop_after(stopped))
    resume(killed)
    assert losses(killed) == losses(whole)
    found, wanted = (read_checkpoint(each / "checkpoints" / "step-000000040.safetensors").tensors for each in (killed, whole))
    assert all(torch.equal(found[key], wanted[key]) for key in wanted)
    assert all(wanted[key].dtype == torch.float32 for key in wanted if key.startswith("model."))


@pytest.mark.parametrize("kind", ["pc_nbv", "compact"])
@pytest.mark.parametrize("uncertainty", ["none", "evidential"])
def test_the_loss_is_in_single_precision_whatever_the_network_computes_in(
    kind: str, uncertainty: str, data: Dataset, tmp_path: Path
) -> None:
    loss = {"kind": "mean" if uncertainty == "none" else uncertainty, "ranking": "listwise"}
    network = {"kind": kind, "shared": [16], "head": [8], "uncertainty": uncertainty}
    recipe = changed(
        network=network, loss=loss, training={"precision": "bfloat16", "iterations": 1, "log_every": 1, "validate_every": 1}
    )
    start(recipe, tmp_path / "run", data=data.folder)
    (line,) = [line["loss"] for line in RunFolder(tmp_path / "run").metrics() if "loss" in line]
    assert float(torch.tensor(line).bfloat16()) != line  # more digits than a half has


def test_a_network_learns_from_where_a_cloud_was_seen_if_that_is_in_its_loss(data: Dataset, tmp_path: Path) -> None:
    beliefs = []
    for weight in (0.0, 1.0):
        recipe = changed(
            network={"width": 16},
            training={"iterations": 60, "batch": 16, "learning_rate": 3e-3, "average": 0.0, "validate_every": 60},
            loss={"presence_weight": weight, "weight_decay": 0.0},
        )
        start(recipe, tmp_path / f"run{weight}", data=data.folder)
        network = load_trained(tmp_path / f"run{weight}").module
        examples = load_examples(data, recipe.data, views=16, seed=0)
        points = examples.points[:, :32].float()
        _, presence = network.located(points, torch.ones(points.shape[:2], dtype=torch.bool))
        beliefs.append(torch.log_softmax(presence, dim=1).gather(1, examples.views[:, None]).mean().item())
    assert beliefs[1] > beliefs[0] + 0.1


def test_only_networks_that_say_from_where_a_cloud_was_seen_can_be_taught_it() -> None:
    with pytest.raises(ConfigError, match="presence_weight"):
        changed(network={"kind": "pc_nbv_noview"}, loss={"presence_weight": 0.1})
    with pytest.raises(ConfigError, match="from where"):
        build(NetworkSettings(kind="pc_nbv_noview", views=4)).located(torch.zeros(1, 5, 3), torch.ones(1, 5, dtype=torch.bool))

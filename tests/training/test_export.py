import json
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.training.conftest import changed
from viewgain.cli import main
from viewgain.datasets import Dataset
from viewgain.errors import TrainingError
from viewgain.inference import Metric, Scorer
from viewgain.network import half_rounded
from viewgain.training import load_trained, read_metrics, start
from viewgain.training._export import FROM_ONE_VIEW, card_of


@pytest.fixture(scope="module")
def run(data: Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "run"
    start(changed(), folder, data=data.folder)
    return folder


def test_the_exported_file_answers_as_the_best_weights_do(run: Path, data: Dataset, tmp_path: Path) -> None:
    figures = [Metric(name="exact position", split="other objects", value=50.0, interval=(40.0, 60.0), unit="%")]
    table = [{"name": "exact position", "split": "other objects", "value": 50, "interval": [40, 60], "unit": "%"}]
    (tmp_path / "figures.json").write_text(json.dumps(table))
    out = tmp_path / "net.onnx"
    source = ["--source", "two shapes", "--licence", "Apache-2.0", "--metrics", str(tmp_path / "figures.json")]
    assert main(["export", str(run), "--out", str(out), *source]) == 0
    scorer, trained = Scorer.load(out), load_trained(run)
    points = data[3].points[:32]
    with torch.inference_mode():
        wanted = half_rounded(trained.module)(torch.from_numpy(points)[None], None, None)[0].numpy()
    np.testing.assert_allclose(scorer.scores(points), wanted, atol=1e-5)
    card = scorer.card
    assert (card.rig, card.frame, card.order, card.kind) == ("pcnbv16", "object", "present_first", "compact")
    assert card.trained_on[0].licence == "Apache-2.0"
    assert set(card.metrics[0].floors) == {"view at random", "constant offset"}
    assert card.metrics[-1] == figures[0]


def test_only_a_network_that_has_to_find_its_place_wants_the_cloud_of_one_scan(data: Dataset, tmp_path: Path) -> None:
    limits = {}
    for kind, rig in (("compact", "pcnbv16"), ("compact", ""), ("compact_view", "pcnbv16")):
        start(changed(network={"kind": kind, "rig": rig}), tmp_path / f"{kind}{rig}", data=data.folder)
        limits[kind, rig] = card_of(load_trained(tmp_path / f"{kind}{rig}")).limits
    assert [FROM_ONE_VIEW in each for each in limits.values()] == [True, False, False]


def test_a_damaged_file_of_best_weights_is_refused(data: Dataset, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    start(changed(), folder, data=data.folder)
    (folder / "best.safetensors").write_bytes((folder / "best.safetensors").read_bytes()[:-9])
    with pytest.raises(TrainingError, match="best"):
        load_trained(folder)


def test_usage_of_export(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", str(tmp_path), "--out", str(tmp_path / "x.onnx")]) == 2
    assert "holds no run" in capsys.readouterr().err
    assert main(["export", str(run), "--out", str(tmp_path / "x.onnx"), "--source", "a"]) == 2
    assert main(["export", str(run), "--out", str(tmp_path / "x.bin")]) == 2
    assert main(["export", str(run), "--out", str(tmp_path / "no" / "x.onnx")]) == 4


def test_a_file_that_lists_no_figures_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text("3")
    with pytest.raises(TrainingError, match="figures"):
        read_metrics(tmp_path / "a.json")

"""Networks that say how sure they are, through training, validation and export."""

from pathlib import Path

import numpy as np
import pytest
import torch

from tests.training.conftest import changed
from viewgain.datasets import Dataset
from viewgain.errors import ConfigError
from viewgain.inference import Scorer
from viewgain.network import half_rounded, sigma_of
from viewgain.training import RunFolder, export_run, load_trained, start


@pytest.mark.parametrize("kind", ["gaussian", "evidential"])
def test_a_network_learns_how_sure_to_be_and_its_file_says_what_validation_showed(
    kind: str, data: Dataset, tmp_path: Path
) -> None:
    run = tmp_path / "run"
    steps = {"iterations": 60, "validate_every": 20}
    recipe = changed(network={"uncertainty": kind}, loss={"kind": kind, "ranking": "listwise"}, training=steps)
    start(recipe, run, data=data.folder)
    curve = [line["loss"] for line in RunFolder(run).metrics() if "loss" in line]
    assert curve[-1] < curve[0]
    trained = load_trained(run)
    ratio = trained.figures["sigma_ratio"]
    assert ratio > 0
    card = export_run(run, tmp_path / "net.onnx")
    assert card.uncertainty
    assert kind in card.training["uncertainty"]
    points = data[3].points[:32]
    with torch.inference_mode():
        sigma = sigma_of(half_rounded(trained.module)(torch.from_numpy(points)[None]))[0].numpy()
    np.testing.assert_allclose(Scorer.load(tmp_path / "net.onnx").assessed(points).sigma, ratio * sigma, rtol=1e-3)


@pytest.mark.parametrize(
    ("uncertainty", "loss"), [("none", "gaussian"), ("gaussian", "mean"), ("evidential", "gaussian"), ("gaussian", "evidential")]
)
def test_a_loss_that_would_not_train_the_uncertainty_is_refused(uncertainty: str, loss: str) -> None:
    with pytest.raises(ConfigError, match="uncertainty"):
        changed(network={"uncertainty": uncertainty}, loss={"kind": loss})


def test_a_network_without_uncertainty_has_no_ratio(data: Dataset, tmp_path: Path) -> None:
    start(changed(training={"iterations": 4}), tmp_path / "run", data=data.folder)
    assert "sigma_ratio" not in load_trained(tmp_path / "run").figures

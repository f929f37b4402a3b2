"""Several networks together: the mixture of what they say."""

from pathlib import Path

import numpy as np
import pytest

from tests.oracles.networks_on_disk import exported, small_settings
from viewgain.errors import ConfigError, ModelError
from viewgain.inference import Ensemble, Scorer

POINTS = np.random.default_rng(0).uniform(-0.2, 0.2, (40, 3))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Networks of fresh weights by name."""
    made = tmp_path_factory.mktemp("networks")
    for seed, points in ((0, 64), (1, 32), (2, 64)):
        exported(made / f"plain{seed}.onnx", small_settings("compact", points=points), seed=seed)
        exported(made / f"sure{seed}.onnx", small_settings("compact", points=points, uncertainty="gaussian"), seed=seed)
    exported(made / "told.onnx", small_settings("compact_view"))
    exported(made / "camera.onnx", small_settings("compact"), frame="camera")
    exported(made / "rig.onnx", small_settings("compact"), rig="hemisphere16")
    return made


@pytest.mark.parametrize("name", ["plain0", "sure0"])
def test_an_ensemble_of_one_is_its_member(name: str, folder: Path) -> None:
    one, alone = Ensemble.load([folder / f"{name}.onnx"]), Scorer.load(folder / f"{name}.onnx")
    assert one.card == alone.card
    found, wanted = one.assessed(POINTS), alone.assessed(POINTS)
    np.testing.assert_array_equal(found.scores, wanted.scores)
    np.testing.assert_array_equal(found.sigma, wanted.sigma)


@pytest.mark.parametrize("name", ["plain", "sure"])
def test_mean_and_variance_are_those_of_draws_from_a_member_at_random(name: str, folder: Path) -> None:
    paths = [folder / f"{name}{seed}.onnx" for seed in range(3)]
    said = [Scorer.load(path).assessed(POINTS) for path in paths]
    rng = np.random.default_rng(1)
    draws = np.concatenate([
        each.scores + (0 if each.sigma is None else each.sigma) * rng.standard_normal((40_000, 16)) for each in said
    ])  # fmt: skip
    found = Ensemble.load(paths).assessed(POINTS)
    np.testing.assert_allclose(found.scores, np.mean([each.scores for each in said], axis=0), atol=1e-12)
    np.testing.assert_allclose(found.sigma, draws.std(axis=0), rtol=0.02)
    assert Ensemble.load(paths).card.uncertainty
    np.testing.assert_array_equal(Ensemble.load(paths).scores(POINTS), found.scores)


def test_twice_the_same_network_has_no_spread(folder: Path) -> None:
    twice = Ensemble.load([folder / "plain0.onnx"] * 2)
    np.testing.assert_allclose(twice.assessed(POINTS).sigma, 0, atol=1e-12)
    assert twice.card.parameters == 2 * Scorer.load(folder / "plain0.onnx").card.parameters
    assert "hemisphere16" in twice.refusal(rig="hemisphere16")


@pytest.mark.parametrize(("other", "word"), [("told", "order"), ("camera", "frame"), ("rig", "rig"), ("sure1", "uncertainty")])
def test_networks_that_mean_something_else_are_refused(other: str, word: str, folder: Path) -> None:
    with pytest.raises(ConfigError, match=word):
        Ensemble.load([folder / "plain0.onnx", folder / f"{other}.onnx"])


def test_none_and_missing_ones_are_refused(folder: Path) -> None:
    with pytest.raises(ConfigError, match="no network"):
        Ensemble([])
    with pytest.raises(ModelError, match="no such file"):
        Ensemble.load([folder / "plain0.onnx", folder / "none.onnx"])

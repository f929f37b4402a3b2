"""Export: the file computes what torch computes on the same rounded weights, stores halves, and carries its card."""

from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
import torch

from tests.oracles.networks_on_disk import card_of, exported, small_settings
from viewgain.errors import ConfigError
from viewgain.inference import CARD_KEY, ModelCard, Scorer
from viewgain.network import (
    Kind,
    NetworkSettings,
    build,
    export_onnx,
    half_rounded,
    log_variance_of,
    scores_of,
    sigma_of,
)

KINDS = tuple(kind for kind in get_args(Kind) if kind != "pose_scores")  # that one: test_pose_scores.py


def clouds(rng: np.random.Generator, batch: int, number: int, *, on_grid: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Points of an ellipsoid, ``on_grid`` full of neighbours at equal distances, and which of them are real: none twice."""
    points = rng.normal(size=(batch, number, 3))
    points *= np.array([0.45, 0.3, 0.15]) / np.linalg.norm(points, axis=-1, keepdims=True)
    if on_grid:
        points = np.round(points * 40) / 40
    mask = np.arange(number)[None] < rng.integers(number // 2, number + 1, size=batch)[:, None]
    for row, cloud in zip(mask, points, strict=True):
        first = np.zeros(number, dtype=bool)
        first[np.unique(cloud, axis=0, return_index=True)[1]] = True
        row &= first
    return points.astype(np.float32), mask


@pytest.mark.parametrize("uncertainty", ["none", "gaussian", "evidential"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_file_computes_what_torch_computes_for_any_batch_and_number(kind: Kind, uncertainty: str, tmp_path: Path) -> None:
    assert_file_is_as_torch(small_settings(kind, uncertainty=uncertainty), tmp_path / "n.onnx")


@pytest.mark.parametrize("kind", ["compact", "compact_view"])
def test_so_does_one_whose_views_look(kind: Kind, tmp_path: Path) -> None:
    assert_file_is_as_torch(small_settings(kind, rig="pcnbv16"), tmp_path / "n.onnx")


@pytest.mark.parametrize("kind", ["compact", "pc_nbv_noview"])
def test_so_does_one_that_standardises(kind: Kind, tmp_path: Path) -> None:
    assert_file_is_as_torch(replace(small_settings(kind), offset=(0.1, 0.0, 0.3), scale=0.4), tmp_path / "n.onnx", ties=False)


def assert_file_is_as_torch(settings: NetworkSettings, file: Path, *, ties: bool = True) -> None:
    """``ties``: also clouds with neighbours at equal distances; once such a cloud is moved, rounding decides between them."""
    network, rng = exported(file, settings), np.random.default_rng(0)
    scorer = Scorer.load(file)
    for batch, number in ((1, 64), (3, 64), (2, 9), (1, 203), (2, 512)):
        points, mask = clouds(rng, batch, number, on_grid=ties and batch == 2)
        state = (rng.random((batch, 16)) < 0.3).astype(np.float32) if settings.with_view_state else None
        with torch.no_grad():
            output = network(torch.from_numpy(points), torch.from_numpy(mask), None if state is None else torch.from_numpy(state))
        log_variance = log_variance_of(output)
        wanted = output if log_variance is None else torch.stack((scores_of(output), log_variance), dim=-1)
        np.testing.assert_allclose(scorer.run(points, mask, state), wanted.numpy(), rtol=0, atol=1e-5)


@pytest.mark.parametrize("uncertainty", ["gaussian", "evidential"])
def test_standard_deviations_are_those_of_torch_within_their_bounds_and_scaled(uncertainty: str, tmp_path: Path) -> None:
    settings = small_settings("pc_nbv_noview", uncertainty=uncertainty)
    network = build(settings, generator=torch.Generator().manual_seed(2))
    with torch.no_grad():  # a bias far out: variances of some views leave the bounds
        list(network.head)[-1].bias[settings.views :: 2] = -40.0
        list(network.head)[-1].bias[settings.views + 1 :: 4] = 40.0
    for factor in (1.0, 1.7):
        export_onnx(network, settings, card_of(settings), tmp_path / "n.onnx", sigma_scale=factor)
        points, mask = clouds(np.random.default_rng(0), 1, 64)
        with torch.no_grad():
            output = half_rounded(network)(torch.from_numpy(points), torch.from_numpy(mask))
        found = Scorer.load(tmp_path / "n.onnx").assessed(points[0][mask[0]])
        np.testing.assert_allclose(found.sigma, factor * sigma_of(output)[0].numpy(), rtol=1e-4)
        np.testing.assert_allclose(found.scores, scores_of(output)[0].numpy(), atol=1e-5)
    assert found.sigma.max() == pytest.approx(1.7 * np.exp(2))  # the upper bound of the logarithm is 4
    with pytest.raises(ConfigError, match="factor"):
        export_onnx(network, settings, card_of(settings), tmp_path / "n.onnx", sigma_scale=0.0)


@pytest.mark.parametrize("kind", ["pc_nbv", "compact"])
def test_so_does_a_network_of_full_size(kind: Kind, tmp_path: Path) -> None:
    settings = NetworkSettings(kind=kind, views=33)
    network = exported(tmp_path / "n.onnx", settings, rig="pcnbv33")
    points, mask = clouds(np.random.default_rng(1), 2, 512)
    state = np.eye(33, dtype=np.float32)[:2] if settings.with_view_state else None
    with torch.no_grad():
        wanted = network(torch.from_numpy(points), torch.from_numpy(mask), None if state is None else torch.from_numpy(state))
    found = Scorer.load(tmp_path / "n.onnx").run(points, mask, state)
    np.testing.assert_allclose(found, wanted.numpy(), rtol=0, atol=1e-5)
    assert (tmp_path / "n.onnx").stat().st_size < 8e6


@pytest.mark.parametrize("kind", ["pc_nbv", "compact"])
def test_weights_are_stored_as_halves_and_once(kind: Kind, tmp_path: Path) -> None:
    onnx = pytest.importorskip("onnx")
    settings = small_settings(kind)
    network = exported(tmp_path / "n.onnx", settings)
    model = onnx.load(tmp_path / "n.onnx")
    halves = [each for each in model.graph.initializer if each.data_type == onnx.TensorProto.FLOAT16]
    stored = sum(int(np.prod(each.dims)) for each in halves)
    learned = sum(parameter.numel() for parameter in network.parameters())
    assert 0.99 * learned < stored <= learned  # equal biases, all zero here, are stored once
    floats = [each for each in model.graph.initializer if each.data_type == onnx.TensorProto.FLOAT]
    assert all(int(np.prod(each.dims)) == 1 for each in floats)


def test_the_card_lies_in_the_file_and_beside_it(tmp_path: Path) -> None:
    onnx = pytest.importorskip("onnx")
    settings = small_settings("compact")
    network = exported(tmp_path / "n.onnx", settings, limits=("Not for cats.",))
    card = Scorer.load(tmp_path / "n.onnx").card
    assert card == card_of(settings, limits=("Not for cats.",), parameters=sum(p.numel() for p in network.parameters()))
    (entry,) = onnx.load(tmp_path / "n.onnx").metadata_props
    assert entry.key == CARD_KEY
    assert ModelCard.from_json(entry.value) == card
    page = (tmp_path / "n.md").read_text()
    assert "Not for cats." in page
    assert f"{card.parameters:,}" in page
    assert sorted(path.name for path in tmp_path.iterdir()) == ["n.md", "n.onnx"]


def test_export_leaves_the_network_alone(tmp_path: Path) -> None:
    settings = small_settings("pc_nbv")
    network = build(settings, generator=torch.Generator().manual_seed(1)).train()
    before = [parameter.clone() for parameter in network.parameters()]
    export_onnx(network, settings, card_of(settings), tmp_path / "n.onnx")
    assert network.training
    for parameter, old in zip(network.parameters(), before, strict=True):
        assert torch.equal(parameter, old)
        assert parameter.requires_grad
    assert any(not torch.equal(a, b) for a, b in zip(half_rounded(network).parameters(), before, strict=True))


def test_what_contradicts_itself_is_not_written(tmp_path: Path) -> None:
    settings = small_settings("compact")
    network, card = build(settings), card_of(settings)
    spoilt, huge = build(settings), build(settings)
    with torch.no_grad():
        spoilt.wide.weight[0, 0] = torch.nan
        huge.wide.weight[0, 0] = 1e5
    few = small_settings("compact", points=8)
    for module, given, told, path in (
        (network, card_of(small_settings("compact", views=5)), settings, "n.onnx"),
        (network, card_of(small_settings("compact_view")), settings, "n.onnx"),
        (network, card_of(settings, points=65), settings, "n.onnx"),
        (network, card_of(settings, uncertainty=True), settings, "n.onnx"),
        (network, card, settings, "n.bin"),
        (build(few), card_of(few), few, "n.onnx"),
        (spoilt, card, settings, "n.onnx"),
        (huge, card, settings, "n.onnx"),
    ):
        with pytest.raises(ConfigError, match="export"):
            export_onnx(module, told, given, tmp_path / path)
    assert not list(tmp_path.iterdir())

"""Networks that are told the candidates' poses: laws, and the exported file against torch."""

from pathlib import Path

import numpy as np
import pytest
import torch

from viewgain.errors import ConfigError, ModelError, ScanError
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.inference import ModelCard, PoseScorer, Scorer
from viewgain.network import NetworkSettings, PoseScores, build, export_onnx, half_rounded, scores_of, sigma_of

SETTINGS = NetworkSettings(kind="pose_scores", views=5, points=64, neighbours=8, width=8, centres=(16, 8), uncertainty="gaussian")


@pytest.fixture(scope="module")
def network() -> PoseScores:
    made = build(SETTINGS, generator=torch.Generator().manual_seed(3))
    assert isinstance(made, PoseScores)
    return made.eval()


def candidates(seed: int, count: int) -> torch.Tensor:
    rng = np.random.default_rng(seed)
    made = [pose(rotation_from_rotvec(rng.normal(0, 1, 3)), rng.normal(0, 0.7, 3)) for _ in range(count)]
    return torch.from_numpy(np.stack(made)).float()


def cloud(seed: int, count: int = 64) -> torch.Tensor:
    return torch.from_numpy(np.random.default_rng(seed).normal([0, 0, 1.2], 0.3, (count, 3))).float()


def answers(network: PoseScores, points: torch.Tensor, poses: torch.Tensor) -> torch.Tensor:
    with torch.no_grad():
        return network(points[None], None, poses[None])[0]


def test_scores_follow_the_order_of_the_candidates_and_not_their_number(network: PoseScores) -> None:
    points, poses = cloud(0), candidates(1, 7)
    whole = answers(network, points, poses)
    order = torch.tensor([3, 0, 6, 2, 5, 1, 4])
    assert whole.shape == (7, 2)
    torch.testing.assert_close(answers(network, points, poses[order]), whole[order])
    torch.testing.assert_close(answers(network, points, poses[2:3]), whole[2:3])


def test_the_order_of_points_and_padding_change_nothing(network: PoseScores) -> None:
    points, poses = cloud(2), candidates(3, 4)
    shuffled = points[torch.randperm(len(points), generator=torch.Generator().manual_seed(0))]
    torch.testing.assert_close(answers(network, shuffled, poses), answers(network, points, poses), atol=1e-5, rtol=1e-4)
    padded = torch.cat((points, torch.full((9, 3), 5.0)))
    mask = torch.arange(len(padded)) < len(points)
    with torch.no_grad():
        again = network(padded[None], mask[None], poses[None])[0]
    torch.testing.assert_close(again, answers(network, points, poses), atol=1e-5, rtol=1e-4)


def test_a_candidate_counts(network: PoseScores) -> None:
    scores = scores_of(answers(network, cloud(4), candidates(5, 6))[None])[0]
    assert len(set(scores.tolist())) == 6


@pytest.mark.parametrize("told", [None, torch.zeros(1, 5), torch.zeros(2, 5, 4, 4), torch.zeros(1, 5, 3, 4)])
def test_what_is_no_pose_is_refused(network: PoseScores, told: torch.Tensor | None) -> None:
    with pytest.raises(ConfigError, match="wanted \\(1, candidates, 4, 4\\)"):
        network(cloud(0)[None], None, told)


def test_the_file_says_what_torch_says_for_any_number_of_candidates(network: PoseScores, tmp_path: Path) -> None:
    file = tmp_path / "poses.onnx"
    card = ModelCard(
        name="poses", task="test", kind="pose_scores", rig="irregular", views=5, points=64, frame="camera",
        normalisation="metres", uncertainty=True,
    )  # fmt: skip
    export_onnx(network, SETTINGS, card, file)
    scorer, rounded = PoseScorer.load(file), half_rounded(network)
    assert isinstance(rounded, PoseScores)
    points = cloud(6, 50)
    for count in (1, 4, 9):
        poses = candidates(count, count)
        found, wanted = scorer.assessed(points.double().numpy(), poses.double().numpy()), answers(rounded, points, poses)[None]
        sigma = sigma_of(wanted)
        assert found.sigma is not None
        assert sigma is not None
        assert found.scores == pytest.approx(scores_of(wanted)[0].double().numpy(), abs=1e-4)
        assert found.sigma == pytest.approx(sigma[0].double().numpy(), rel=1e-3)
    assert "the candidates' poses in the present camera" in file.with_suffix(".md").read_text()
    with pytest.raises(ModelError, match="objective volume"):
        Scorer.load(file)
    with pytest.raises(ScanError, match="finite"):
        scorer.assessed(np.zeros((0, 3)), candidates(0, 2).numpy())
    with pytest.raises(ConfigError, match="V of 1 or more"):
        scorer.assessed(points.double().numpy(), np.zeros((0, 4, 4)))

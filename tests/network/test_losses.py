"""Losses: the paper's in both scalings, rankings against loops over views and pairs, the likelihood, the weights' penalty."""

import math

import pytest
import torch
from torch import Tensor

from viewgain.errors import ConfigError
from viewgain.network import LossSettings, NetworkSettings, build, score_loss, weight_penalty


def drawn(*shape: int, seed: int = 0) -> Tensor:
    return torch.rand(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.double)


def test_the_paper_s_loss_and_that_of_the_public_code_differ_by_a_factor() -> None:
    scores, target = drawn(4, 6), drawn(4, 6, seed=1)
    mean = score_loss(scores, target, LossSettings(kind="mean"))
    half = score_loss(scores, target, LossSettings(kind="half_sum"))
    by_hand = sum((scores[i, j] - target[i, j]) ** 2 for i in range(4) for j in range(6))
    torch.testing.assert_close(mean, by_hand / 24)
    torch.testing.assert_close(half, by_hand / 2)


@pytest.mark.parametrize("settings", [
    LossSettings(kind="mean"), LossSettings(kind="half_sum"), LossSettings(ranking="listwise"), LossSettings(ranking="pairwise"),
])  # fmt: skip
def test_views_that_do_not_count_have_no_say(settings: LossSettings) -> None:
    scores, target = drawn(3, 5).requires_grad_(), drawn(3, 5, seed=1)
    valid = torch.ones(3, 5, dtype=torch.bool)
    valid[0, 2] = valid[2, 4] = False
    loss = score_loss(scores, target, settings, valid=valid)
    loss.backward()
    assert scores.grad[~valid].abs().max() == 0
    assert scores.grad[valid].abs().min() > 0
    changed = torch.where(valid, target, target + 7)
    torch.testing.assert_close(score_loss(scores, changed, settings, valid=valid), loss)


def test_the_listwise_loss_is_the_cross_entropy_of_two_softmaxes() -> None:
    scores, target, temperature = drawn(2, 4), drawn(2, 4, seed=1), 0.3
    settings = LossSettings(ranking="listwise", temperature=temperature, ranking_weight=2.0)
    by_hand = 0.0
    for row in range(2):
        wanted = [math.exp(t / temperature) for t in target[row].tolist()]
        given = [math.exp(s / temperature) for s in scores[row].tolist()]
        by_hand -= sum(w / sum(wanted) * math.log(g / sum(given)) for w, g in zip(wanted, given, strict=True)) / 2
    loss = score_loss(scores, target, settings) - score_loss(scores, target, LossSettings())
    assert loss.item() == pytest.approx(2 * by_hand)


def test_the_pairwise_loss_weighs_pairs_by_their_difference() -> None:
    scores, target, temperature = drawn(2, 4), drawn(2, 4, seed=1), 0.3
    pairs = [
        (float(t[i] - t[j]), math.log1p(math.exp(-float(s[i] - s[j]) / temperature)))
        for s, t in zip(scores, target, strict=True)
        for i in range(4)
        for j in range(4)
        if t[i] > t[j]
    ]
    by_hand = sum(weight * loss for weight, loss in pairs) / sum(weight for weight, _ in pairs)
    settings = LossSettings(ranking="pairwise", temperature=temperature)
    loss = score_loss(scores, target, settings) - score_loss(scores, target, LossSettings())
    assert loss.item() == pytest.approx(by_hand)


def test_rankings_do_not_see_a_shift_and_are_least_at_the_right_order() -> None:
    target = drawn(3, 6)
    for ranking in ("listwise", "pairwise"):
        settings = LossSettings(kind="mean", ranking=ranking, temperature=0.1)
        order = [score_loss(s, target, settings) - score_loss(s, target, LossSettings()) for s in (target, target + 0.4, -target)]
        torch.testing.assert_close(order[0], order[1])
        assert order[0] < order[2]


def test_equal_targets_make_no_pair_and_no_nan() -> None:
    loss = score_loss(drawn(2, 3), torch.ones(2, 3, dtype=torch.double), LossSettings(ranking="pairwise"))
    assert torch.isfinite(loss)


def test_the_likelihood_is_least_where_the_variance_is_the_error() -> None:
    target, error = torch.zeros(1, 4, dtype=torch.double), 0.2
    settings = LossSettings(kind="gaussian")

    def loss(sigma: float) -> float:
        output = torch.stack((torch.full((1, 4), error), torch.full((1, 4), 2 * math.log(sigma))), dim=-1).double()
        return score_loss(output, target, settings).item()

    assert loss(error) == pytest.approx(0.5 * (1 + 2 * math.log(error)))
    assert loss(error) < min(loss(0.9 * error), loss(1.1 * error))


def test_the_likelihood_wants_an_uncertainty() -> None:
    with pytest.raises(ConfigError, match="uncertainty"):
        score_loss(drawn(2, 3), drawn(2, 3), LossSettings(kind="gaussian"))


def test_the_penalty_is_on_weights_alone() -> None:
    network = build(NetworkSettings(kind="pc_nbv", views=3, growth=2, shared=(6,), head=(5,)))
    by_hand = sum(float(p.detach().square().sum()) for n, p in network.named_parameters() if n.endswith("weight")) / 2
    assert weight_penalty(network, 0.01).item() == pytest.approx(0.01 * by_hand, rel=1e-5)
    weight_penalty(network).backward()
    assert all(p.grad is None for n, p in network.named_parameters() if n.endswith(("bias", "gamma")))


def test_nonsense_is_refused() -> None:
    for act in (
        lambda: LossSettings(kind="huber"),
        lambda: LossSettings(ranking="all"),
        lambda: LossSettings(temperature=0.0),
        lambda: LossSettings(weight_decay=-1.0),
        lambda: score_loss(drawn(2, 3), drawn(2, 4), LossSettings()),
        lambda: score_loss(drawn(2, 3), drawn(2, 3), LossSettings(), valid=torch.ones(2, 2, dtype=torch.bool)),
    ):
        with pytest.raises(ConfigError):
            act()

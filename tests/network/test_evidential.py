"""The evidential loss: the density it comes from, least at the truth, wider where targets are noisy."""

import numpy as np
import pytest
import scipy.stats
import torch
from torch import Tensor

from viewgain.errors import ConfigError
from viewgain.network import LossSettings, evidence_of, score_loss, scores_of, sigma_of

BARE = LossSettings(kind="evidential", evidence_weight=0.0)


def outputs(*shape: int, seed: int = 0) -> Tensor:
    return torch.randn(*shape, 4, generator=torch.Generator().manual_seed(seed), dtype=torch.double)


def test_it_is_minus_the_logarithm_of_a_student_t_density_plus_error_times_evidence() -> None:
    output, target = outputs(3, 5), outputs(3, 5, seed=1)[..., 0]
    evidence = evidence_of(output)
    score, nu, alpha, beta = (e.numpy() for e in (evidence.score, evidence.weight, evidence.excess + 1, evidence.scale))
    density = scipy.stats.t.logpdf(target.numpy(), 2 * alpha, score, np.sqrt(beta * (1 + nu) / (nu * alpha)))
    assert score_loss(output, target, BARE).item() == pytest.approx(-density.mean())
    extra = np.abs(target.numpy() - score) * (2 * nu + alpha)
    whole = score_loss(output, target, LossSettings(kind="evidential", evidence_weight=0.3))
    assert whole.item() == pytest.approx((0.3 * extra - density).mean())


def test_the_variance_is_that_of_the_student_t() -> None:
    evidence = evidence_of(outputs(4, 6))
    nu, alpha, beta = evidence.weight, evidence.excess + 1, evidence.scale
    wanted = scipy.stats.t.var(2 * alpha.numpy(), 0, np.sqrt((beta * (1 + nu) / (nu * alpha)).numpy()))
    np.testing.assert_allclose(evidence.log_variance.exp(), wanted, rtol=1e-9)


@pytest.mark.parametrize("weight", [0.0, 0.01, 1.0])
def test_it_is_least_where_the_score_is_the_truth(weight: float) -> None:
    settings, output = LossSettings(kind="evidential", evidence_weight=weight), outputs(1, 8)
    truth = torch.zeros(1, 8, dtype=torch.double)

    def at(error: float) -> float:
        moved = output.clone()
        moved[..., 0] = error
        return score_loss(moved, truth, settings).item()

    errors = [0.0, 0.05, 0.2, 1.0, 5.0]
    assert [at(error) for error in errors] == sorted(at(error) for error in errors)
    assert at(0.3) == pytest.approx(at(-0.3))


@pytest.mark.parametrize("kind", ["gaussian", "evidential"])
def test_sigma_grows_where_targets_are_noisy_and_is_as_large_as_the_noise(kind: str) -> None:
    generator, noise = torch.Generator().manual_seed(0), torch.tensor([0.02, 0.05, 0.2], dtype=torch.double)
    targets = 0.5 + noise * torch.randn(400, 3, generator=generator, dtype=torch.double)
    raw = torch.zeros(1, 3, 2 if kind == "gaussian" else 4, dtype=torch.double, requires_grad=True)
    optimiser = torch.optim.Adam([raw], lr=0.1)
    for _ in range(250):
        optimiser.zero_grad()
        score_loss(raw.expand(400, -1, -1), targets, LossSettings(kind=kind, evidence_weight=0.0)).backward()
        optimiser.step()
    torch.testing.assert_close(sigma_of(raw.detach())[0], noise, rtol=0.25, atol=0)
    torch.testing.assert_close(scores_of(raw.detach())[0], torch.full((3,), 0.5, dtype=torch.double), rtol=0, atol=0.03)


def test_gradients_are_finite_in_single_precision_however_far_out() -> None:
    for size in (1.0, 30.0, 300.0):
        output = (size * outputs(4, 6).float()).requires_grad_()
        score_loss(output, torch.zeros(4, 6), LossSettings(kind="evidential")).backward()
        assert torch.isfinite(output.grad).all()
        assert torch.isfinite(sigma_of(output.detach())).all()


def test_views_that_do_not_count_have_no_say() -> None:
    output, valid = outputs(3, 5).requires_grad_(), torch.ones(3, 5, dtype=torch.bool)
    valid[1, 2] = False
    score_loss(output, torch.zeros(3, 5, dtype=torch.double), LossSettings(kind="evidential"), valid=valid).backward()
    assert output.grad[1, 2].abs().max() == 0
    assert output.grad[valid].abs().min() > 0


def test_each_likelihood_wants_its_own_uncertainty() -> None:
    target = torch.zeros(2, 3, dtype=torch.double)
    for kind, output in (("gaussian", outputs(2, 3)), ("evidential", outputs(2, 3)[..., :2]), ("evidential", target)):
        with pytest.raises(ConfigError, match=kind):
            score_loss(output, target, LossSettings(kind=kind))
    with pytest.raises(ConfigError, match="evidence_weight"):
        LossSettings(evidence_weight=-1.0)

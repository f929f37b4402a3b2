"""What a network is trained to make small. The paper's is the mean squared error (section 3.2); the others are ours."""

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import torch
from torch import Tensor, nn
from torch.nn.functional import log_softmax, softplus

from viewgain.errors import ConfigError
from viewgain.network._output import NUMBERS, evidence_of, log_variance_of, scores_of

LossKind: TypeAlias = Literal["mean", "half_sum", "gaussian", "evidential"]
"""``mean``: squared error over all views of a batch; ``half_sum``: half their sum, as the public code has it; ``gaussian``: the
negative logarithm of the likelihood under the network's own variances; ``evidential``: the same under its own distribution over
mean and variance, plus what keeps it from claiming evidence where it errs (Amini et al. 2020, equations 8 to 10)."""
RankingKind: TypeAlias = Literal["none", "listwise", "pairwise"]
"""``listwise``: cross entropy between the softmax of true scores and of those given; ``pairwise``: logistic loss of every pair
of views, weighted by how much their true scores differ."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LossSettings:
    """What is summed."""

    kind: LossKind = "mean"
    """The error of the scores."""
    ranking: RankingKind = "none"
    """A loss of the order of the scores, added to it."""
    ranking_weight: float = 1.0
    """Factor on the loss of the order."""
    temperature: float = 0.02
    """Difference of scores that counts as clear, in units of the scores; smaller looks more at the best view alone."""
    presence_weight: float = 0.0
    """Weight of the cross entropy of the present view, for networks that say from where they believe a cloud was seen (compact
    without view state). Their scores alone teach them that slowly. The camera of a training cloud is always known."""
    evidence_weight: float = 0.01
    """Factor on error times evidence in the evidential loss (Amini et al. 2020: lambda; 0.01 in their example)."""
    weight_decay: float = 1e-4
    """L2 weight on weights, not on biases (section 3.2: lambda)."""

    def __post_init__(self) -> None:
        if self.kind not in get_args(LossKind) or self.ranking not in get_args(RankingKind):
            kinds, rankings = ", ".join(get_args(LossKind)), ", ".join(get_args(RankingKind))
            raise ConfigError(
                f"loss: got kind {self.kind!r} and ranking {self.ranking!r}, wanted one of {kinds} and one of {rankings}"
            )
        weights = (self.weight_decay, self.ranking_weight, self.presence_weight, self.evidence_weight)
        if self.temperature <= 0 or min(weights) < 0:
            names = "weight_decay, ranking_weight, presence_weight and evidence_weight"
            raise ConfigError(f"loss: wanted a temperature over 0, and {names} of 0 or more")


def score_loss(output: Tensor, target: Tensor, settings: LossSettings, *, valid: Tensor | None = None) -> Tensor:
    """Return the loss of a batch, a scalar; add :func:`weight_penalty` for the whole of it.

    Args:
        output: (B, V), (B, V, 2) or (B, V, 4) what the network gave.
        target: (B, V) true scores in the same order.
        settings: What is summed.
        valid: (B, V) which views count, at least one of the batch; None for all.

    Raises:
        ConfigError: If shapes differ, or the loss wants an uncertainty that the network does not give.
    """
    scores = scores_of(output)
    valid = torch.ones_like(target, dtype=torch.bool) if valid is None else valid
    if scores.shape != target.shape or valid.shape != target.shape:
        shapes = [tuple(each.shape) for each in (scores, target, valid)]
        raise ConfigError(f"loss: got scores, targets and valid views of shapes {shapes}, wanted the same three times")
    loss = _error(output, target, valid, settings)
    if settings.ranking != "none":
        order = _listwise if settings.ranking == "listwise" else _pairwise
        loss = loss + settings.ranking_weight * order(scores, target, valid, settings.temperature)
    return loss


def weight_penalty(module: nn.Module, factor: float = 1e-4) -> Tensor:
    """Return factor * sum(w^2) / 2 over all weight matrices, biases and the weight of the attention left out (section 3.2)."""
    squares = [parameter.square().sum() for parameter in module.parameters() if parameter.ndim > 1]
    return 0.5 * factor * torch.stack(squares).sum()


def _error(output: Tensor, target: Tensor, valid: Tensor, settings: LossSettings) -> Tensor:
    squares = (scores_of(output) - target)[valid].square()
    if settings.kind == "half_sum":
        return 0.5 * squares.sum()
    if settings.kind == "mean":
        return squares.mean()
    log_variance = log_variance_of(output)
    if log_variance is None or output.shape[-1] != NUMBERS[settings.kind]:
        raise ConfigError(f"loss: {settings.kind} wants a network of uncertainty {settings.kind!r}, got another; change either")
    if settings.kind == "evidential":
        return _evidential(output[valid], target[valid], settings.evidence_weight)
    spread = log_variance[valid]
    return 0.5 * (squares * torch.exp(-spread) + spread).mean()


def _evidential(output: Tensor, target: Tensor, factor: float) -> Tensor:
    """Return the mean over (n, 4) outputs and (n,) targets of -log(Student t density) + ``factor`` |error| (2 nu + alpha)."""
    evidence = evidence_of(output)
    nu, alpha, beta = evidence.weight, evidence.excess + 1, evidence.scale
    error, omega = target - evidence.score, 2 * beta * (1 + nu)
    surprise = (
        0.5 * torch.log(math.pi / nu)
        - alpha * torch.log(omega)
        + (alpha + 0.5) * torch.log(error.square() * nu + omega)
        + torch.lgamma(alpha)
        - torch.lgamma(alpha + 0.5)
    )
    return (surprise + factor * error.abs() * (2 * nu + alpha)).mean()


def _listwise(scores: Tensor, target: Tensor, valid: Tensor, temperature: float) -> Tensor:
    """Return the mean cross entropy between the softmax of the targets and that of the scores over each cloud's valid views."""
    lowest = torch.finfo(scores.dtype).min
    wanted = torch.softmax((target / temperature).masked_fill(~valid, lowest), dim=-1)
    given = log_softmax((scores / temperature).masked_fill(~valid, lowest), dim=-1)
    return -(wanted * given.masked_fill(~valid, 0.0)).sum(-1).mean()


def _pairwise(scores: Tensor, target: Tensor, valid: Tensor, temperature: float) -> Tensor:
    """Return the weighted mean of log(1 + exp(-d)) over pairs, d by how far the scores of a pair are apart the right way."""
    better = (target[:, :, None] - target[:, None]).clamp(min=0) * (valid[:, :, None] & valid[:, None])  # (B, V, V)
    apart = (scores[:, :, None] - scores[:, None]) / temperature
    return (better * softplus(-apart)).sum() / better.sum().clamp(min=torch.finfo(scores.dtype).tiny)

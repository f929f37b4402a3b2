"""What a network is trained to make small. The paper's is the mean squared error (section 3.2); the others are ours."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import torch
from torch import Tensor, nn
from torch.nn.functional import log_softmax, softplus

from viewgain.errors import ConfigError
from viewgain.network._output import log_variance_of, scores_of

LossKind: TypeAlias = Literal["mean", "half_sum", "gaussian"]
"""``mean``: squared error over all views of a batch; ``half_sum``: half their sum, as the public code has it; ``gaussian``: the
negative logarithm of the likelihood under the network's own variances."""
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
    weight_decay: float = 1e-4
    """L2 weight on weights, not on biases (section 3.2: lambda)."""

    def __post_init__(self) -> None:
        if self.kind not in get_args(LossKind) or self.ranking not in get_args(RankingKind):
            kinds, rankings = ", ".join(get_args(LossKind)), ", ".join(get_args(RankingKind))
            raise ConfigError(
                f"loss: got kind {self.kind!r} and ranking {self.ranking!r}, wanted one of {kinds} and one of {rankings}"
            )
        if self.temperature <= 0 or self.weight_decay < 0 or self.ranking_weight < 0:
            raise ConfigError("loss: wanted a temperature over 0, and weight_decay and ranking_weight of 0 or more")


def score_loss(output: Tensor, target: Tensor, settings: LossSettings, *, valid: Tensor | None = None) -> Tensor:
    """Return the loss of a batch, a scalar; add :func:`weight_penalty` for the whole of it.

    Args:
        output: (B, V) or (B, V, 2) what the network gave.
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
    if log_variance is None:
        raise ConfigError("loss: gaussian wants a network of uncertainty 'gaussian', got one of 'none'; change either")
    spread = log_variance[valid]
    return 0.5 * (squares * torch.exp(-spread) + spread).mean()


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

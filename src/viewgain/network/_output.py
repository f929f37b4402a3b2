"""What comes out of a network: scores, and how sure it is of each."""

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import softplus

from viewgain.network._settings import NetworkSettings

LEAST_LOG_VARIANCE, MOST_LOG_VARIANCE = -14.0, 4.0
"""Standard deviations of 0.001 to 7: beyond these a single outlier, or a score hit by chance, would rule the training."""
NUMBERS = {"none": 1, "gaussian": 2, "evidential": 4}
"""Numbers per view: the score; with the logarithm of its variance; or with three that an :class:`Evidence` is made of."""
LEAST = 1e-6
"""What keeps a parameter of the evidence over its bound."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Evidence:
    """A normal-inverse-gamma distribution over mean and variance of each score, all (B, V).

    Source: Amini et al. 2020, section 3.1; greek letters are the paper's.
    """

    score: Tensor
    """gamma, the expected mean."""
    weight: Tensor
    """nu > 0, how many observations of the mean it is worth."""
    excess: Tensor
    """alpha - 1 > 0, half of how many observations of the variance it is worth."""
    scale: Tensor
    """beta > 0."""

    @property
    def log_variance(self) -> Tensor:
        """Logarithm of beta / (alpha - 1) * (1 + 1 / nu): the expected variance of the data and that of the mean, together."""
        return torch.log(self.scale) - torch.log(self.excess) + torch.log1p(1 / self.weight)


def outputs_of(settings: NetworkSettings) -> int:
    """Return how many numbers the last layer gives: V, or 2V or 4V with uncertainty."""
    return settings.views * NUMBERS[settings.uncertainty]


def shaped(outputs: Tensor, settings: NetworkSettings) -> Tensor:
    """Return (B, V) scores; with uncertainty (B, V, 2) or (B, V, 4) as :data:`NUMBERS` says."""
    if settings.uncertainty == "none":
        return outputs
    return outputs.reshape(-1, NUMBERS[settings.uncertainty], settings.views).transpose(1, 2)


def answers_as_output(answers: Tensor) -> Tensor:
    """Return (B, V, c) numbers per view as an output: (B, V) where it is the score alone."""
    return answers[..., 0] if answers.shape[-1] == NUMBERS["none"] else answers


def scores_of(output: Tensor) -> Tensor:
    """Return (B, V) the scores in a network's output, with uncertainty or without."""
    return output if output.ndim == 2 else output[..., 0]


def evidence_of(output: Tensor) -> Evidence:
    """Return the evidence in a (B, V, 4) output."""
    score, *others = output.unbind(-1)
    weight, excess, scale = (softplus(each) + LEAST for each in others)
    return Evidence(score=score, weight=weight, excess=excess, scale=scale)


def log_variance_of(output: Tensor) -> Tensor | None:
    """Return (B, V) the logarithms of the scores' variances, kept within bounds; None for a network without uncertainty."""
    if output.ndim == 2:
        return None
    log_variance = output[..., 1] if output.shape[-1] == NUMBERS["gaussian"] else evidence_of(output).log_variance
    return log_variance.clamp(LEAST_LOG_VARIANCE, MOST_LOG_VARIANCE)


def sigma_of(output: Tensor) -> Tensor | None:
    """Return (B, V) the standard deviations of the scores; None for a network without uncertainty."""
    log_variance = log_variance_of(output)
    return None if log_variance is None else torch.exp(0.5 * log_variance)

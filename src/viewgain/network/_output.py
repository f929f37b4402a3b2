"""What comes out of a network: scores, and how sure it is of each."""

import torch
from torch import Tensor

from viewgain.network._settings import NetworkSettings

LEAST_LOG_VARIANCE, MOST_LOG_VARIANCE = -14.0, 4.0
"""Standard deviations of 0.001 to 7: beyond these a single outlier, or a score hit by chance, would rule the training."""


def outputs_of(settings: NetworkSettings) -> int:
    """Return how many numbers the last layer gives: V, or 2V with uncertainty."""
    return settings.views * (1 if settings.uncertainty == "none" else 2)


def shaped(outputs: Tensor, settings: NetworkSettings) -> Tensor:
    """Return (B, V) scores; with uncertainty (B, V, 2), scores and logarithms of their variance."""
    return outputs if settings.uncertainty == "none" else outputs.reshape(-1, 2, settings.views).transpose(1, 2)


def scores_of(output: Tensor) -> Tensor:
    """Return (B, V) the scores in a network's output, with uncertainty or without."""
    return output if output.ndim == 2 else output[..., 0]


def log_variance_of(output: Tensor) -> Tensor | None:
    """Return (B, V) the logarithms of the scores' variances, kept within bounds; None for a network without uncertainty."""
    return None if output.ndim == 2 else output[..., 1].clamp(LEAST_LOG_VARIANCE, MOST_LOG_VARIANCE)


def sigma_of(output: Tensor) -> Tensor | None:
    """Return (B, V) the standard deviations of the scores; None for a network without uncertainty."""
    log_variance = log_variance_of(output)
    return None if log_variance is None else torch.exp(0.5 * log_variance)

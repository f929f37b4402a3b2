"""From settings to a network with fresh parameters."""

import torch
from torch import nn

from viewgain.network._compact import Compact
from viewgain.network._inputs import ScoreNetwork
from viewgain.network._pcnbv import PcNbv
from viewgain.network._pose_scores import PoseScores
from viewgain.network._settings import NetworkSettings


def build(settings: NetworkSettings, *, generator: torch.Generator | None = None) -> ScoreNetwork:
    """Return a network on the CPU: weights by Glorot's uniform rule, biases and the weight of the attention zero.

    The global random state of torch is touched only where no generator is given.

    Args:
        settings: Which network.
        generator: Draws the weights.
    """
    with torch.device("meta"):
        module = _network(settings)
    module = module.to_empty(device="cpu")
    with torch.no_grad():
        for parameter in module.parameters():
            if parameter.ndim < 2:
                parameter.zero_()
            else:
                nn.init.xavier_uniform_(parameter, generator=generator)
    return module


def _network(settings: NetworkSettings) -> ScoreNetwork:
    if settings.with_poses:
        return PoseScores(settings)
    return PcNbv(settings) if settings.kind.startswith("pc_nbv") else Compact(settings)


def parameters_of(module: nn.Module) -> int:
    """Return how many numbers a network has learned."""
    return sum(parameter.numel() for parameter in module.parameters())

"""Processes that train one network together: each works on its share of every batch, and the gradients are averaged.

One process alone is the same thing with one member, so the loop does not ask. ``torchrun`` says who is who in the environment.
"""

import os
import sys
from collections.abc import Sequence
from typing import Protocol

import torch
from torch import distributed, nn
from torch.nn.parallel import DistributedDataParallel

from viewgain.errors import TrainingError


class Ranks(Protocol):
    """A group of processes."""

    rank: int
    """Number of this process."""
    size: int
    """How many there are."""

    def joined(self, model: nn.Module) -> nn.Module:
        """Return a model whose gradients are averaged over all processes."""

    def leader_says(self, values: Sequence[float]) -> list[float]:
        """Return what process 0 passed; all must pass as many."""

    def mean(self, value: float) -> float:
        """Return the mean over all processes."""

    def close(self) -> None:
        """Leave the group."""


class Alone:
    """One process."""

    rank, size = 0, 1

    def joined(self, model: nn.Module) -> nn.Module:
        """Return the model itself."""
        return model

    def leader_says(self, values: Sequence[float]) -> list[float]:
        """Return the values themselves."""
        return [float(value) for value in values]

    def mean(self, value: float) -> float:
        """Return the value itself."""
        return value

    def close(self) -> None:
        """Do nothing."""


class Torchrun:
    """The processes that ``torchrun`` started; gloo between CPUs, nccl between GPUs."""

    def __init__(self, device: str) -> None:
        """Meet the others.

        Raises:
            TrainingError: If they cannot be met.
        """
        try:
            distributed.init_process_group("nccl" if device.startswith("cuda") else "gloo")
        except (RuntimeError, ValueError) as error:
            raise TrainingError(f"the processes of torchrun cannot meet ({error}); start them by one command") from error
        self.rank, self.size = distributed.get_rank(), distributed.get_world_size()
        self._device = torch.device(device)

    def joined(self, model: nn.Module) -> nn.Module:
        """Return the model, wrapped so that its gradients are averaged."""
        return DistributedDataParallel(model)

    def leader_says(self, values: Sequence[float]) -> list[float]:
        """Return what process 0 passed."""
        tensor = torch.tensor(values, dtype=torch.float64, device=self._device)
        distributed.broadcast(tensor, 0)
        return [float(value) for value in tensor]

    def mean(self, value: float) -> float:
        """Return the mean over all processes."""
        tensor = torch.tensor(value, dtype=torch.float64, device=self._device)
        distributed.all_reduce(tensor)
        return float(tensor) / self.size

    def close(self) -> None:
        """Leave the group, all together: a process that goes while another still talks to it takes that one down."""
        if sys.exc_info()[0] is None:  # after an error the others may be elsewhere, and would be waited for in vain
            distributed.barrier()
        distributed.destroy_process_group()


def ranks(device: str) -> Ranks:
    """Return the group that ``torchrun`` put this process into, or one of this process alone."""
    return Torchrun(device) if int(os.environ.get("WORLD_SIZE", "1")) > 1 else Alone()


def leads() -> bool:
    """Return whether this process is the one that writes and speaks."""
    return os.environ.get("RANK", "0") == "0"

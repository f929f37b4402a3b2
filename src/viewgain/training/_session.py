"""What changes while a network is trained: weights, their running average, Adam's moments, and how many steps were made.

All of it goes into a checkpoint and comes back from it to the bit, so a run that was stopped goes on as if it had not been.
"""

import math
from dataclasses import replace
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

from viewgain.errors import ConfigError, TrainingError
from viewgain.network import LossSettings, ScoreNetwork, build, score_loss
from viewgain.training._batches import Batch, Batches
from viewgain.training._checkpoint import Checkpoint
from viewgain.training._ranks import Ranks
from viewgain.training._schedule import learning_rate
from viewgain.training._settings import TrainingRecipe


class Session:
    """A network in training."""

    def __init__(self, recipe: TrainingRecipe, batches: Batches, *, device: str, ranks: Ranks) -> None:
        """Start with fresh weights, drawn from the recipe's seed.

        Raises:
            ConfigError: If the batch cannot be shared by the processes, or its loss is not the mean of their losses.
        """
        settings = recipe.training
        _check_shares(recipe, ranks)
        self.recipe, self.step, self.rate = recipe, 0, 0.0
        self._batches, self._device, self._ranks = batches, device, ranks
        self.model: ScoreNetwork = build(recipe.network, generator=torch.Generator().manual_seed(settings.seed)).to(device)
        average = get_ema_multi_avg_fn(settings.average)  # type: ignore[no-untyped-call, unused-ignore]
        self._average = AveragedModel(self.model, multi_avg_fn=average) if settings.average else None
        self._optimizer = torch.optim.Adam(_groups(self.model, recipe.loss.weight_decay), lr=settings.learning_rate)
        self._joined = ranks.joined(_Answers(self.model, located=recipe.loss.presence_weight > 0))
        self._joined.train()

    @property
    def judged(self) -> nn.Module:
        """The network whose choices count: the running average, where there is one."""
        return self.model if self._average is None else self._average.module

    def advance(self, *, clock: float) -> float | None:
        """Make one step and return the loss of this process's share; None if the gradient is not finite, then nothing changes.

        Args:
            clock: Share of the time limit that is over.
        """
        self.rate = learning_rate(self.recipe.training, self.step, clock=clock)
        for group in self._optimizer.param_groups:
            group["lr"] = self.rate
        batch = self._batches.at(self.step, part=slice(self._ranks.rank, None, self._ranks.size))
        self._optimizer.zero_grad(set_to_none=True)
        loss = self._loss(batch)
        loss.backward()  # type: ignore[no-untyped-call,unused-ignore]
        norm = nn.utils.clip_grad_norm_(self.model.parameters(), self.recipe.training.clip or math.inf)
        if not math.isfinite(float(norm)):
            return None
        self._optimizer.step()
        if self._average is not None:
            self._average.update_parameters(self.model)
        self.step += 1
        return float(loss.detach())

    def weights(self) -> dict[str, Tensor]:
        """Return the weights that are judged and exported."""
        return dict(self.judged.state_dict())

    def checkpoint(self, state: dict[str, Any]) -> Checkpoint:
        """Return everything, and ``state`` beside it."""
        tensors = {f"model.{name}": value for name, value in self.model.state_dict().items()}
        if self._average is not None:
            tensors |= {f"average.{name}": value for name, value in self._average.state_dict().items()}
        for number, moments in self._optimizer.state_dict()["state"].items():
            tensors |= {f"optimizer.{number}.{name}": value for name, value in moments.items()}
        tensors["random.torch"] = torch.get_rng_state()
        return Checkpoint(tensors=tensors, state={**state, "step": self.step})

    def restore(self, checkpoint: Checkpoint) -> None:
        """Take up everything from a checkpoint.

        Raises:
            TrainingError: If it is of another network.
        """
        try:
            self.model.load_state_dict(checkpoint.part("model"))
            if self._average is not None:
                self._average.load_state_dict(checkpoint.part("average"))
            moments: dict[int, dict[str, Tensor]] = {}
            for key, value in checkpoint.part("optimizer").items():
                number, name = key.split(".", 1)
                moments.setdefault(int(number), {})[name] = value
            self._optimizer.load_state_dict({**self._optimizer.state_dict(), "state": moments})
            torch.set_rng_state(checkpoint.tensors["random.torch"])
        except (RuntimeError, KeyError, ValueError) as error:
            raise TrainingError("the checkpoint is of another network than run.json says; start the run anew") from error
        self.step = int(checkpoint.state["step"])

    def _loss(self, batch: Batch) -> Tensor:
        half = self.recipe.training.precision == "bfloat16"
        with torch.autocast(torch.device(self._device).type, dtype=torch.bfloat16, enabled=half):
            output, presence = self._joined(batch.points, batch.mask, batch.told)
        loss = _labelled(output.float(), batch, self.recipe)
        # Gradients are averaged over processes, but a sum over the whole batch is the sum of theirs.
        loss = loss * self._ranks.size if self.recipe.loss.kind == "half_sum" else loss
        if presence is None:
            return loss
        return loss + self.recipe.loss.presence_weight * cross_entropy(presence.float(), batch.views)


class _Answers(nn.Module):
    """A network's scores, and where wanted from which view it believes a cloud was seen; one call, so that gradients join."""

    def __init__(self, network: ScoreNetwork, *, located: bool) -> None:
        super().__init__()
        self.network, self.located = network, located

    def forward(self, points: Tensor, mask: Tensor, states: Tensor | None) -> tuple[Tensor, Tensor | None]:
        return self.network.located(points, mask) if self.located else (self.network(points, mask, states), None)


def _labelled(output: Tensor, batch: Batch, recipe: TrainingRecipe) -> Tensor:
    """Return the loss against the labels, or its mean with the loss against the teacher's scores, by the teacher's weight."""
    loss, distil = recipe.loss, recipe.distil
    labels = score_loss(output, batch.targets, loss, valid=batch.valid)
    if distil is None or batch.taught is None:
        return labels
    by_teacher: LossSettings = loss if distil.temperature is None else replace(loss, temperature=distil.temperature)
    return distil.weight * score_loss(output, batch.taught, by_teacher, valid=batch.valid) + (1 - distil.weight) * labels


def _groups(model: nn.Module, weight_decay: float) -> list[dict[str, Any]]:
    """Return Adam's parameters: the penalty, whose gradient is ``weight_decay`` times the weight, is on matrices alone."""
    matrices = [each for each in model.parameters() if each.ndim > 1]
    others = [each for each in model.parameters() if each.ndim <= 1]
    return [{"params": matrices, "weight_decay": weight_decay}, {"params": others, "weight_decay": 0.0}]


def _check_shares(recipe: TrainingRecipe, ranks: Ranks) -> None:
    if recipe.training.batch % ranks.size:
        raise ConfigError(f"got a batch of {recipe.training.batch} for {ranks.size} processes, wanted a multiple of their number")
    if ranks.size > 1 and recipe.loss.ranking == "pairwise":
        raise ConfigError("got the pairwise ranking loss with several processes, which is no mean over them; take listwise")

"""How good the choices of a network are: the share of best views, and of views nearly as good (the paper's Table 1)."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from viewgain.network import score_loss, scores_of, sigma_of
from viewgain.training._batches import in_order
from viewgain.training._examples import Examples
from viewgain.training._settings import TrainingRecipe

THRESHOLDS = (0.05, 0.03, 0.01, 0.005)
"""Differences in coverage that still count as nearly as good (paper, Table 1)."""
_BATCH = 256


@dataclass(frozen=True, slots=True, kw_only=True)
class Validation:
    """Figures over some samples, shares in [0, 1]."""

    samples: int
    """How many."""
    loss: float
    """Mean loss."""
    exact: float
    """Share where the highest score stands at the best view."""
    within: tuple[float, ...]
    """Share where the chosen view is worth at most so much less than the best, for each of :data:`THRESHOLDS`."""
    sigma_ratio: float | None
    """Root mean square of error / standard deviation over all views: 1 where the network is rightly sure, more where it is too
    sure; None for a network without uncertainty."""

    def to_dict(self) -> dict[str, Any]:
        """Return the figures by name: ``loss``, ``exact``, ``within_0.05``, ...; what the network does not give is left out."""
        figures = {name: figure for name, figure in asdict(self).items() if figure is not None}
        figures.pop("within")
        return figures | {f"within_{limit}": share for limit, share in zip(THRESHOLDS, self.within, strict=True)}


def validate(model: nn.Module, recipe: TrainingRecipe, examples: Examples, rows: NDArray[np.intp]) -> Validation:
    """Return how good a network's choices are on some samples; the model is put into evaluation mode and back."""
    points, uses_state = recipe.network.points, recipe.network.with_view_state
    losses, exact, shortfalls, ratios = [], [], [], []
    was_training = model.training
    model.eval()
    with torch.inference_mode():
        for chosen, batch in in_order(examples, rows, batch=_BATCH, points=points, uses_state=uses_state):
            output = model(batch.points, batch.mask, batch.told).float()
            losses.append(float(score_loss(output, batch.targets, recipe.loss, valid=batch.valid)) * len(chosen))
            valid = torch.ones_like(batch.targets, dtype=torch.bool) if batch.valid is None else batch.valid
            picked = scores_of(output).masked_fill(~valid, -torch.inf).argmax(1)
            exact.append((picked == batch.targets.argmax(1)).cpu().numpy())
            shortfalls.append(shortfall(batch.targets, picked).cpu().numpy())
            sigma = sigma_of(output)
            if sigma is not None:
                squares = ((scores_of(output) - batch.targets) / sigma).square()
                ratios.append(squares[valid].cpu().numpy())
    model.train(was_training)
    lost = np.concatenate(shortfalls)
    return Validation(
        samples=len(rows),
        loss=sum(losses) / len(rows),
        exact=float(np.concatenate(exact).mean()),
        sigma_ratio=float(np.sqrt(np.concatenate(ratios).mean())) if ratios else None,
        within=tuple(float(np.mean(lost <= limit)) for limit in THRESHOLDS),
    )


def shortfall(targets: Tensor, picked: Tensor) -> Tensor:
    """Return (B,) how much less the picked view (B,) is worth than the best of (B, V)."""
    return targets.max(1).values - targets.gather(1, picked[:, None])[:, 0]

"""How good the choices of a network are: the share of best views, and of views nearly as good (the paper's Table 1)."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor, nn

from viewgain.gain import POSITION_LIMITS, choices, hits, shortfall
from viewgain.network import score_loss, scores_of, sigma_of
from viewgain.training._batches import in_order, present_first
from viewgain.training._examples import Examples
from viewgain.training._settings import TrainingRecipe

_BATCH = 256


@dataclass(frozen=True, slots=True, kw_only=True)
class Validation:
    """Figures over some samples, shares in [0, 1]; visited views cannot be chosen, equal views are equally right."""

    samples: int
    """How many."""
    loss: float
    """Mean loss."""
    exact: float
    """Share where the chosen view is worth as much as the best."""
    within: tuple[float, ...]
    """Share where it is worth at most so much less, for each of ``viewgain.gain.POSITION_LIMITS`` over 0."""
    sigma_ratio: float | None
    """Root mean square of error / standard deviation over all views: 1 where the network is rightly sure, more where it is too
    sure; None for a network without uncertainty."""

    def to_dict(self) -> dict[str, Any]:
        """Return the figures by name: ``loss``, ``exact``, ``within_0.05``, ...; what the network does not give is left out."""
        figures = {name: figure for name, figure in asdict(self).items() if figure is not None}
        figures.pop("within")
        return figures | named((self.exact, *self.within))


def named(shares: ArrayLike) -> dict[str, float]:
    """Return (5,) shares, one per limit, by name: ``exact``, ``within_0.05``, ..."""
    names = ("exact", *(f"within_{limit}" for limit in POSITION_LIMITS[1:]))
    return dict(zip(names, np.asarray(shares, dtype=float).tolist(), strict=True))


def validate(model: nn.Module, recipe: TrainingRecipe, examples: Examples, rows: NDArray[np.intp]) -> Validation:
    """Return how good a network's choices are on some samples; the model is put into evaluation mode and back."""
    points, uses_state = recipe.network.points, recipe.network.with_view_state
    losses, right, ratios = [], [], []
    was_training = model.training
    model.eval()
    with torch.inference_mode():
        for chosen, batch in in_order(examples, rows, batch=_BATCH, points=points, uses_state=uses_state):
            output = model(batch.points, batch.mask, batch.told).float()
            losses.append(float(score_loss(output, batch.targets, recipe.loss, valid=batch.valid)) * len(chosen))
            free = free_views(examples, chosen, rig_order=uses_state)
            picked = choices(scores_of(output).cpu().numpy(), free)
            right.append(hits(shortfall(batch.targets.cpu().numpy(), picked, free)))
            sigma = sigma_of(output)
            if sigma is not None:
                valid = torch.ones_like(batch.targets, dtype=torch.bool) if batch.valid is None else batch.valid
                squares = ((scores_of(output) - batch.targets) / sigma).square()
                ratios.append(squares[valid].cpu().numpy())
    model.train(was_training)
    exact, *within = np.concatenate(right).mean(axis=0).tolist()
    return Validation(
        samples=len(rows),
        loss=sum(losses) / len(rows),
        exact=exact,
        within=tuple(within),
        sigma_ratio=float(np.sqrt(np.concatenate(ratios).mean())) if ratios else None,
    )


def free_views(examples: Examples, rows: NDArray[np.intp], *, rig_order: bool) -> NDArray[np.bool_]:
    """Return (B, V) which views of some samples may be chosen; in rig order, or with the present view first.

    Those not visited yet; of candidates with poses all that can be reached, and of whole scans all, the present one too.
    """
    if examples.valid is not None:
        reachable: NDArray[np.bool_] = examples.valid[torch.from_numpy(rows).to(examples.valid.device)].cpu().numpy()
        return reachable
    index = torch.from_numpy(rows).to(examples.points.device)
    states: Tensor = examples.states[index]
    free: NDArray[np.bool_] = ~(states if rig_order else present_first(states, examples.views[index])).cpu().numpy()
    return free

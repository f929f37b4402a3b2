"""What answers without any learning get: a figure means little without them."""

from collections.abc import Mapping

import numpy as np
import torch
from numpy.typing import NDArray

from viewgain.training._batches import present_first
from viewgain.training._examples import Examples
from viewgain.training._validation import THRESHOLDS, shortfall


def floors(examples: Examples, aside: NDArray[np.bool_]) -> Mapping[str, Mapping[str, float]]:
    """Return the figures on the validation samples of two answers, by name: a view at random, and always the same offset.

    Args:
        examples: All samples.
        aside: (N,) which are validated on. The offset is the one that is best most often on the others.
    """
    scores = present_first(examples.targets, examples.views).cpu()
    learned, judged = scores[torch.from_numpy(~aside)], scores[torch.from_numpy(aside)]
    views = scores.shape[1]
    offset = int(torch.bincount(learned.argmax(1), minlength=views).argmax())
    each = [_figures(judged, view) for view in range(views)]
    # Of candidates that cannot be reached nobody guesses: they are right nowhere, and are left out of the mean.
    share = 1.0 if examples.valid is None else float(examples.valid[torch.from_numpy(aside)].double().mean())
    return {
        "view at random": {name: float(np.mean([figures[name] for figures in each])) / share for name in each[0]},
        "constant offset": each[offset],
    }


def _figures(scores: torch.Tensor, view: int) -> dict[str, float]:
    """Return the figures of always choosing one offset from the present view."""
    lost = shortfall(scores, torch.full((len(scores),), view))
    within = {f"within_{limit}": float((lost <= limit).double().mean()) for limit in THRESHOLDS}
    return {"exact": float((scores.argmax(1) == view).double().mean()), **within}

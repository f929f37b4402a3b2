"""What answers without any learning get: a figure means little without them."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from viewgain.gain import constant_offset, hits, shortfall, uniform_hits
from viewgain.training._batches import present_first
from viewgain.training._examples import Examples
from viewgain.training._validation import free_views, named


def floors(examples: Examples, aside: NDArray[np.bool_]) -> Mapping[str, Mapping[str, float]]:
    """Return the figures on the validation samples of two answers, by name: a view at random, and always the same offset.

    Args:
        examples: All samples.
        aside: (N,) which are validated on. The offset is the one that is best most often on the others.
    """
    gains = present_first(examples.targets, examples.views).cpu().numpy()
    free = free_views(examples, np.arange(len(examples)), rig_order=False)
    offset = constant_offset(gains[~aside], free[~aside])
    always = np.full(int(aside.sum()), offset)
    return {
        "view at random": named(uniform_hits(gains[aside], free[aside]).mean(axis=0)),
        "constant offset": named(hits(shortfall(gains[aside], always, free[aside])).mean(axis=0)),
    }

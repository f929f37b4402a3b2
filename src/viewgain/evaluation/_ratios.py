"""Ratios of two means over the same boxes, with intervals."""

import numpy as np
from numpy.typing import ArrayLike

from viewgain.errors import DataError
from viewgain.evaluation._bootstrap import DRAWS, drawn_weights
from viewgain.evaluation._quantity import Quantity


def ratio(first: ArrayLike, second: ArrayLike, *, rng: np.random.Generator, draws: int = DRAWS) -> Quantity:
    """Return mean(first) / mean(second) of (B,) values of the same boxes, with the 95 % interval over boxes drawn anew.

    The ratio of the means, not the mean of the ratios: a box that the oracle measures almost without error would rule the latter.
    Infinite where the second mean is 0, but 0 / 0 is 1, since neither is more than the other.

    Raises:
        DataError: If there is no box.
    """
    table = np.column_stack([np.asarray(first, dtype=float), np.asarray(second, dtype=float)])
    if len(table) == 0:
        raise DataError("evaluation: got no boxes, wanted some")
    drawn = _divided(drawn_weights(len(table), rng, draws) @ table)
    low, high = np.quantile(drawn, [0.025, 0.975], method="inverted_cdf")
    return Quantity(float(_divided(table.sum(axis=0)[None])[0]), float(low), float(high))


def _divided(sums: np.ndarray) -> np.ndarray:
    above, below = sums[:, 0], sums[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((above == 0) & (below == 0), 1.0, above / below)

"""Scores that are worked out of stored volume errors when they are asked for: any estimator, any histogram, no scan again."""

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array
from viewgain.datasets._dataset import Dataset
from viewgain.gain import ErrorHistogram, HistogramRule, Objective


def object_errors(data: Dataset, estimator: str, *, indices: NDArray[np.intp] | None = None) -> dict[int, Array]:
    """Return the (V, n) volume errors of each object, by view in rig order; NaN for a scan without an estimate.

    n is the most scans that any view of the object has; a view with fewer (the camera could not stand there, or saw nothing) is
    filled up with NaN, so that what is missing is a miss.

    Args:
        data: The data set.
        estimator: Whose errors.
        indices: Of these samples only, for instance those that train; None for all.

    Raises:
        DataError: If the errors have not been worked out.
    """
    errors = data.volume_errors(estimator)
    chosen = np.arange(len(data)) if indices is None else np.asarray(indices)
    objects, views = data.column("object")[chosen].astype(int), data.column("view")[chosen].astype(int)
    table = {}
    for number in np.unique(objects).tolist():
        own = objects == number
        count = len(data[int(chosen[np.argmax(own)])].candidates)
        rows = [errors[chosen[own & (views == view)]] for view in range(count)]
        most = max(len(row) for row in rows)
        table[int(number)] = np.stack([np.pad(row, (0, most - len(row)), constant_values=np.nan) for row in rows])
    return table


def histogram_scores(
    data: Dataset,
    estimator: str,
    objective: Objective[ErrorHistogram],
    *,
    rule: HistogramRule | None = None,
    indices: NDArray[np.intp] | None = None,
) -> dict[int, Array]:
    """Return the (V,) scores of each object's views, in rig order, for :meth:`Dataset.with_scores`.

    Args:
        data: The data set.
        estimator: Whose errors (``viewgain dataset build --errors``).
        objective: What a histogram is worth, of ``viewgain.gain.HISTOGRAM_OBJECTIVES`` or your own.
        rule: Bins and tolerance.
        indices: Count only these samples; None counts all of an object, as the paper does.

    Raises:
        DataError: If the errors have not been worked out.
    """
    errors = object_errors(data, estimator, indices=indices)
    return {number: np.asarray(objective.gains(ErrorHistogram.from_errors(each, rule))) for number, each in errors.items()}

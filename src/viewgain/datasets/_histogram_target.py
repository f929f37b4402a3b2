"""Targets from histograms of volume errors by name, with the terms of a time-of-flight camera or without."""

from collections.abc import Mapping, Sequence

import numpy as np

from viewgain.arrays import Array
from viewgain.datasets._box_views import box_views
from viewgain.datasets._dataset import Dataset
from viewgain.datasets._scores import histogram_scores, object_errors
from viewgain.errors import ConfigError, DataError
from viewgain.gain import (
    ESTIMATORS,
    HISTOGRAM_OBJECTIVES,
    TERM_WEIGHT,
    TERMS,
    BoxViews,
    ErrorHistogram,
    Objective,
    ScannedBox,
    with_terms,
)


def histogram_target(data: Dataset, name: str, estimator: str, score: str) -> Mapping[int, Array]:
    """Return (V,) scores by object, in rig order.

    Args:
        data: Boxes with the volume errors of the estimator.
        name: The whole target, for messages.
        estimator: Of ``viewgain.gain.ESTIMATORS``.
        score: Of ``viewgain.gain.HISTOGRAM_OBJECTIVES``, and terms: ``soft+incidence+border``, ``soft+incidence=0.05``.

    Raises:
        ConfigError: If there is no such estimator, score or term, or a weight is none.
        DataError: If the errors have not been worked out, a box has no known size to have errors, or terms are asked of boxes
            whose pose is not known.
    """
    objective, *words = score.split("+")
    if estimator not in ESTIMATORS or objective not in HISTOGRAM_OBJECTIVES:
        known = f"one of {', '.join(ESTIMATORS)} and one of {', '.join(HISTOGRAM_OBJECTIVES)}"
        raise ConfigError(f"target {name}: got {estimator!r} and {objective!r}, wanted {known}")
    terms = _terms(name, words)
    _require_sizes(data)
    if not terms:
        return histogram_scores(data, estimator, HISTOGRAM_OBJECTIVES[objective])
    scored, views = with_terms(HISTOGRAM_OBJECTIVES[objective], terms), box_views(data)
    return {
        number: scored.gains(ScannedBox(ErrorHistogram.from_errors(errors), views[number]))
        for number, errors in object_errors(data, estimator).items()
    }


def _terms(name: str, words: Sequence[str]) -> list[tuple[float, Objective[BoxViews]]]:
    """Return the terms that words such as ``border`` and ``incidence=0.05`` name, each with its weight."""
    weights: dict[str, float] = {}
    for word in words:
        term, equals, weight = word.partition("=")
        value = _number(weight) if equals else TERM_WEIGHT
        if term not in TERMS or term in weights or not 0 <= value < np.inf:
            raise ConfigError(
                f"target {name}: got the term {word!r}, wanted {' or '.join(TERMS)}, each once at most; where its weight is not"
                f" {TERM_WEIGHT:g}, a number of 0 or more after it: {next(iter(TERMS))}=0.05"
            )
        weights[term] = value
    return [(weight, TERMS[term]) for term, weight in weights.items()]


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return np.nan


def _require_sizes(data: Dataset) -> None:
    """Refuse boxes of unknown size: all their errors are missing, and the first position would pass for the best."""
    is_unknown = ~np.isfinite(np.asarray(data.column("dims"), dtype=float)).all(axis=1)
    names = [data.manifest.objects[number].partition("/")[0] for number in np.unique(data.column("object")[is_unknown]).tolist()]
    if names:
        raise DataError(f"{data.folder}: got no size of {', '.join(names)}; add it to boxes.toml and build the data set anew")

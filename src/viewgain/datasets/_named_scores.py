"""Targets that are worked out by name: from histograms of volume errors, or one drawn label per box by a tally."""

from collections.abc import Mapping

import numpy as np

from viewgain.arrays import Array
from viewgain.datasets._dataset import Dataset
from viewgain.datasets._scores import histogram_scores
from viewgain.errors import ConfigError, DataError
from viewgain.gain import ESTIMATORS, HISTOGRAM_OBJECTIVES, SOFT

HISTOGRAM, TALLY = "histogram", "tally"
"""What the names begin with: ``histogram:ESTIMATOR:OBJECTIVE``, ``tally:4,3,2,2:SEED``."""


def with_target(data: Dataset, name: str) -> Dataset:
    """Return the data set with a target of this name; as it is where it has one.

    ``histogram:lines_published:soft`` is an objective of ``viewgain.gain.HISTOGRAM_OBJECTIVES`` on the errors of an estimator,
    counted over all scans of an object and position. ``tally:4,3,2,2:0`` gives each object one best position, 0.8 there and 0.2
    elsewhere, so that the first position is the best of 4 objects, the next of 3, ...; which objects is drawn with the seed and
    has nothing to do with them. (The public scripts of Pop and Tamas have one hand-written label per box with this tally.)

    Raises:
        ConfigError: If there is no such estimator or objective, or the tally does not fit.
        DataError: If there is no such target, the errors have not been worked out, or a box has no known size to have errors.
    """
    if name in data.manifest.targets:
        return data
    kind, *words = name.split(":")
    if kind == HISTOGRAM and len(words) == 2:
        estimator, objective = words
        if estimator not in ESTIMATORS or objective not in HISTOGRAM_OBJECTIVES:
            known = f"one of {', '.join(ESTIMATORS)} and one of {', '.join(HISTOGRAM_OBJECTIVES)}"
            raise ConfigError(f"target {name}: got {estimator!r} and {objective!r}, wanted {known}")
        _require_sizes(data)
        return data.with_scores(name, histogram_scores(data, estimator, HISTOGRAM_OBJECTIVES[objective]))
    if kind == TALLY and len(words) == 2:
        return data.with_scores(name, tally_scores(data, name, *words))
    known = ", ".join([*data.manifest.targets, f"{HISTOGRAM}:ESTIMATOR:OBJECTIVE", f"{TALLY}:4,3,2,2:SEED"])
    raise DataError(f"{data.folder}: got the target {name!r}, wanted one of {known}")


def _require_sizes(data: Dataset) -> None:
    """Refuse boxes of unknown size: all their errors are missing, and the first position would pass for the best."""
    is_unknown = ~np.isfinite(np.asarray(data.column("dims"), dtype=float)).all(axis=1)
    names = [data.manifest.objects[number].partition("/")[0] for number in np.unique(data.column("object")[is_unknown]).tolist()]
    if names:
        raise DataError(f"{data.folder}: got no size of {', '.join(names)}; add it to boxes.toml and build the data set anew")


def tally_scores(data: Dataset, name: str, tally: str, seed: str) -> Mapping[int, Array]:
    """Return (V,) scores by object; arguments and errors as :func:`with_target`."""
    try:
        counts, rng = [int(word) for word in tally.split(",")], np.random.default_rng(int(seed))
    except ValueError as error:
        raise ConfigError(f"target {name}: got {tally!r} and {seed!r}, wanted whole numbers and a seed") from error
    objects = np.unique(data.column("object"))
    views = len(data[0].candidates)
    if min(counts) < 0 or sum(counts) != len(objects) or len(counts) != views:
        raise ConfigError(
            f"target {name}: got {len(counts)} positions for {sum(counts)} objects, wanted {views} for {len(objects)}"
        )
    best = rng.permutation(np.repeat(np.arange(views), counts))
    value, other = SOFT.best, SOFT.others
    return {int(each): np.where(np.arange(views) == place, value, other) for each, place in zip(objects, best, strict=True)}

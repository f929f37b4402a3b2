"""Targets that are worked out by name: from histograms of volume errors, or one drawn label per box by a tally."""

from collections.abc import Mapping

import numpy as np

from viewgain.arrays import Array
from viewgain.datasets._dataset import Dataset
from viewgain.datasets._histogram_target import histogram_target
from viewgain.errors import ConfigError, DataError
from viewgain.gain import SOFT

HISTOGRAM, TALLY = "histogram", "tally"
"""What the names begin with: ``histogram:ESTIMATOR:OBJECTIVE[+TERM ...]``, ``tally:4,3,2,2:SEED``."""


def with_target(data: Dataset, name: str) -> Dataset:
    """Return the data set with a target of this name; as it is where it has one.

    ``histogram:lines_published:soft`` is an objective of ``viewgain.gain.HISTOGRAM_OBJECTIVES`` on the errors of an estimator,
    counted over all scans of an object and position. ``histogram:lines_published:soft+incidence+border`` adds terms of
    ``viewgain.gain.TERMS`` to it, each with the weight ``TERM_WEIGHT`` or its own (``+incidence=0.05``).

    ``tally:4,3,2,2:0`` gives each object one best position, 0.8 there and 0.2 elsewhere, so that the first position is the best
    of 4 objects, the next of 3, ...; which objects is drawn with the seed and has nothing to do with them. (The public scripts of
    Pop and Tamas have one hand-written label per box with this tally.)

    Raises:
        ConfigError: If there is no such estimator, objective or term, or the tally does not fit.
        DataError: If there is no such target, the errors have not been worked out, a box has no known size to have errors, or
            terms are asked of boxes whose pose is not known.
    """
    if name in data.manifest.targets:
        return data
    kind, *words = name.split(":")
    if kind == HISTOGRAM and len(words) == 2:
        return data.with_scores(name, histogram_target(data, name, *words))
    if kind == TALLY and len(words) == 2:
        return data.with_scores(name, tally_scores(data, name, *words))
    known = ", ".join([*data.manifest.targets, f"{HISTOGRAM}:ESTIMATOR:OBJECTIVE[+TERM ...]", f"{TALLY}:4,3,2,2:SEED"])
    raise DataError(f"{data.folder}: got the target {name!r}, wanted one of {known}")


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

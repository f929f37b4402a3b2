"""The data set of a run: named by the user, or built into the run's folder; and which of its objects watch over the training."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from viewgain.datasets import Dataset, LocalEngine, build, plan_of
from viewgain.datasets import recipe as data_recipe
from viewgain.errors import ConfigError, DataError
from viewgain.training._examples import Examples, load_examples
from viewgain.training._folder import DATA, RunFolder
from viewgain.training._ranks import Ranks
from viewgain.training._settings import TrainingRecipe

_HELD_OUT = 0x6865
"""Stream of the draw of the validation objects."""


def open_data(recipe: TrainingRecipe, folder: RunFolder, data: Path | None, ranks: Ranks) -> Dataset:
    """Return the data set at ``data``, or the recipe's own, which process 0 builds into the run's folder first.

    Raises:
        ConfigError: If neither is named.
        DataError: If it is missing or not finished.
        StorageError: If it cannot be written.
    """
    if data is not None:
        return Dataset(data)
    if not recipe.data.recipe:
        raise ConfigError(f"training recipe {recipe.name}: names no data recipe; name a data set with --data")
    place = folder.path / DATA
    if ranks.rank == 0:
        build(plan_of(data_recipe(recipe.data.recipe)), place, engine=LocalEngine(), resume=True)
    ranks.leader_says([1.0])  # the others wait here until it is built
    return Dataset(place)


def shown_and_aside(recipe: TrainingRecipe, data: Dataset) -> tuple[Examples, NDArray[np.bool_]]:
    """Return the samples that a recipe learns from, and (N,) which of them are kept out of training to watch it.

    Raises:
        DataError: If the data is not what the recipe is for, or too little to keep some of it out.
        ConfigError: As of :func:`load_examples`.
    """
    network, settings, seed = recipe.network, recipe.data, recipe.training.seed
    examples = load_examples(data, settings, views=network.views, seed=seed, with_poses=network.with_poses)
    kinds = examples.objects if settings.validate_on == "objects" else np.arange(len(examples))
    return examples, held_out(kinds, settings.validation_share, seed=seed)


def held_out(objects: NDArray[np.int64], share: float, *, seed: int) -> NDArray[np.bool_]:
    """Return (N,) which samples are of objects that are kept out of training: whole objects, at least one and not all.

    Args:
        objects: (N,) number of each sample's object.
        share: Of the objects.
        seed: Of the draw.

    Raises:
        DataError: If there are fewer than two objects.
    """
    numbers = np.unique(objects)
    if len(numbers) < 2:
        raise DataError(f"got samples of {len(numbers)} object, wanted 2 or more, so that some can be kept out of training")
    count = min(max(1, round(share * len(numbers))), len(numbers) - 1)
    chosen = np.random.default_rng([seed, _HELD_OUT]).permutation(numbers)[:count]
    return np.isin(objects, chosen)

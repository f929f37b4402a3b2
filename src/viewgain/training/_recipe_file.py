"""Training recipes as TOML files: those that come with the package by name, and the user's own by path."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from viewgain.datasets import recipe_table, record
from viewgain.errors import ConfigError
from viewgain.network import LossSettings, NetworkSettings
from viewgain.training._settings import DataSettings, DistilSettings, TrainingRecipe, TrainingSettings

TRAINING_RECIPES = (
    "tiny",
    "pc_nbv",
    "pc_nbv_noview",
    "pc_nbv_short",
    "pc_nbv_noview_short",
    "pc_nbv33",
    "compact",
    "compact_view",
    "compact_view33",
    "compact_camera",
    "volume_paper",
    "volume_paper_short",
    "volume_paper_tally",
    "volume_recorded",
    "volume_recorded_short",
    "volume_irregular",
    "volume_irregular_fixed",
    "volume_random",
    "volume_fused",
    "volume_tiny",
)
"""Names of the recipes that come with the package."""
_KEYS = ("makes", "network", "data", "training", "loss", "distil")


def training_recipe(name: str | Path) -> TrainingRecipe:
    """Return a shipped recipe by name, or the recipe of a TOML file by its path (docs/training.md).

    Raises:
        ConfigError: If the name is none of :data:`TRAINING_RECIPES` and no readable recipe file; one line that names the key.
    """
    return training_recipe_from_table(*recipe_table(name, "training recipe", TRAINING_RECIPES, "viewgain.training"))


def training_recipe_from_table(table: Mapping[str, Any], name: str) -> TrainingRecipe:
    """Return the recipe that a table describes.

    Raises:
        ConfigError: If a key is unknown or missing, or a value is not what its field is.
    """
    where = f"training recipe {name}"
    unknown = sorted(set(table) - set(_KEYS))
    if unknown or "network" not in table or not isinstance(table.get("makes"), str):
        raise ConfigError(
            f"{where}: got the keys {sorted(table)}, wanted makes (a sentence), network, and any of data, training, loss, distil"
        )
    return TrainingRecipe(
        name=name,
        makes=table["makes"],
        network=record(NetworkSettings, table["network"], f"{where}, network"),
        data=record(DataSettings, table.get("data", {}), f"{where}, data"),
        training=record(TrainingSettings, table.get("training", {}), f"{where}, training"),
        loss=record(LossSettings, table.get("loss", {}), f"{where}, loss"),
        distil=None if table.get("distil") is None else record(DistilSettings, table["distil"], f"{where}, distil"),
    )

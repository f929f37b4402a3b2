"""A small real data set, and a recipe that is trained on it in a second."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch

from tests.datasets.engines import Inline
from viewgain.datasets import CoverageSettings, Dataset, build, plan_of
from viewgain.datasets import recipe as data_recipe
from viewgain.training import TrainingRecipe, training_recipe_from_table

TABLE: dict[str, Any] = {
    "makes": "nothing of use",
    "network": {"kind": "compact", "views": 16, "points": 32, "neighbours": 4, "width": 4},
    "data": {"rig": "pcnbv16", "validation_share": 0.5, "resident": 64},
    "training": {
        "iterations": 12,
        "batch": 6,
        "learning_rate": 1e-2,
        "log_every": 2,
        "validate_every": 4,
        "checkpoint_minutes": 0.0,
        "average": 0.9,
    },
}


def changed(**tables: dict[str, Any]) -> TrainingRecipe:
    """Return the quick recipe with some keys of some tables changed."""
    merged = {key: {**TABLE[key], **tables.get(key, {})} if isinstance(TABLE[key], dict) else TABLE[key] for key in TABLE}
    return training_recipe_from_table({**merged, **{key: value for key, value in tables.items() if key not in merged}}, "quick")


@pytest.fixture(autouse=True, scope="session")
def _one_thread() -> None:
    torch.set_num_threads(1)


def built_in(folder: Path) -> Dataset:
    """Build 32 samples: 2 objects from each of 16 views."""
    tiny = data_recipe("coverage_paper_tiny")
    assert isinstance(tiny.content, CoverageSettings)
    every_start = replace(tiny, content=replace(tiny.content, starts=0))
    build(plan_of(every_start), folder, engine=Inline())
    return Dataset(folder)


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """32 samples of 2 objects from 16 views."""
    return built_in(tmp_path_factory.mktemp("data"))


@pytest.fixture
def recipe() -> TrainingRecipe:
    """The quick recipe."""
    return changed()


@pytest.fixture
def recipe_file(tmp_path: Path) -> Path:
    """The quick recipe as a file; without the running average."""
    lines = [f'makes = "{TABLE["makes"]}"']
    for key in ("network", "data", "training"):
        lines += [f"[{key}]", *(f"{name} = {value!r}" for name, value in TABLE[key].items() if name != "average")]
    path = tmp_path / "quick.toml"
    path.write_text("\n".join(lines) + "\n")
    return path

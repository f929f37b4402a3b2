"""Held-out categories: they, and no others, are the test part by category, in procedural data and in folders."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests.meshes import files
from viewgain.datasets import recipe
from viewgain.datasets._mesh_units import mesh_units
from viewgain.datasets._settings import CoverageSettings
from viewgain.errors import ConfigError
from viewgain.shapes import CATEGORIES


def test_the_recipe_of_table_1_has_the_objects_that_the_issue_asks_for() -> None:
    plan = recipe("coverage_table1")
    content = plan.content
    assert isinstance(content, CoverageSettings)
    assert len(content.categories) == len(content.held_out) == 8
    units = list(mesh_units(plan.seed, None, content))
    parts = {
        (same, other): [unit for unit in units if unit.splits == {"same_category": same, "other_category": other}]
        for same in ("train", "test")
        for other in ("train", "test")
    }
    assert len(parts["train", "train"]) >= 4000
    assert len(parts["test", "train"]) >= 800
    unseen = parts["train", "test"] + parts["test", "test"]
    assert len(unseen) >= 400
    assert {unit.category for unit in unseen} == set(content.held_out)
    assert {unit.category for unit in parts["train", "train"]} == set(content.categories)


def test_the_nine_categories_to_choose_by_are_none_of_table_1_and_all_count_as_unseen() -> None:
    nine, table = recipe("coverage_nine"), recipe("coverage_table1").content
    assert isinstance(nine.content, CoverageSettings)
    assert isinstance(table, CoverageSettings)
    assert not set(nine.content.categories) & {*table.categories, *table.held_out}
    assert {*nine.content.categories, *table.categories, *table.held_out} == set(CATEGORIES)
    units = list(mesh_units(nine.seed, None, nine.content))
    assert len(units) == 180
    assert {unit.splits["other_category"] for unit in units} == {"test"}


def test_in_a_folder_of_meshes_only_the_named_categories_count(tmp_path: Path) -> None:
    for category in ("mug", "lamp", "vase"):
        (tmp_path / category).mkdir()
        (tmp_path / category / "one.ply").write_bytes(files.ply())
    rules = CoverageSettings(categories=("mug",), held_out=("lamp",), test_share=0.0)
    found = {unit.category: unit.splits["other_category"] for unit in mesh_units(0, tmp_path, rules)}
    assert found == {"mug": "train", "lamp": "test"}


def test_held_out_categories_that_make_no_sense_are_refused() -> None:
    for rules in ({"held_out": ("mug",)}, {"categories": ("mug",), "held_out": ("mug",)}, {"per_held_out": 0}):
        with pytest.raises(ConfigError, match="held_out"):
            CoverageSettings(**rules)
    with pytest.raises(ConfigError, match="unicorn"):
        list(mesh_units(0, None, replace(CoverageSettings(categories=("mug",)), held_out=("unicorn",))))

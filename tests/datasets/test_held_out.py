"""Held-out categories: they, and no others, are the test part by category, in procedural data and in folders."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests.meshes import files
from viewgain.datasets import plan_of, recipe
from viewgain.datasets._mesh_units import mesh_of, mesh_units
from viewgain.datasets._settings import CoverageSettings
from viewgain.errors import ConfigError
from viewgain.shapes import COMPOSITE


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
    assert {unit.category for unit in parts["train", "train"]} == {*content.categories, COMPOSITE}


@pytest.mark.parametrize("from_folder", [False, True])
def test_composites_only_train_and_leave_all_others_as_they_are(tmp_path: Path, *, from_folder: bool) -> None:
    (tmp_path / "mug").mkdir()
    (tmp_path / "mug" / "one.ply").write_bytes(files.ply())
    folder = tmp_path if from_folder else None
    rules = CoverageSettings(categories=("mug",), per_category=9, test_share=0.5)
    without = list(mesh_units(3, folder, rules))
    units = list(mesh_units(3, folder, replace(rules, composites=4)))
    assert units[: len(without)] == without
    added = units[len(without) :]
    assert [unit.name for unit in added] == [f"{COMPOSITE}/{place:05d}" for place in range(4)]
    assert [unit.object for unit in added] == list(range(len(without), len(without) + 4))
    assert all(set(unit.splits.values()) == {"train"} for unit in added)
    assert mesh_of(added[0], 3).name == f"procedural/{COMPOSITE}"
    assert len({mesh_of(unit, 3).vertices.tobytes() for unit in added}) == 4


def test_a_negative_number_of_composites_is_refused() -> None:
    with pytest.raises(ConfigError, match="-1 composites"):
        CoverageSettings(composites=-1)


def test_a_data_set_without_composites_is_the_one_it_was_before_there_were_any() -> None:
    """Its identity has no word of them, so that folders that were built before go on."""
    whole = recipe("coverage_learn_tiny")
    assert "composites" not in plan_of(whole).description["recipe"]["coverage"]
    with_some = replace(whole, content=replace(whole.content, composites=2))
    assert plan_of(with_some).description["recipe"]["coverage"]["composites"] == 2
    assert plan_of(with_some).tables.categories == (*plan_of(whole).tables.categories, COMPOSITE)


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

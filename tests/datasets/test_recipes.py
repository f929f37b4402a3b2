"""Recipes: those that come along are sound, and a wrong one says what is wrong with it."""

from pathlib import Path

import numpy as np
import pytest

from viewgain.datasets import RECIPES, plan_of, recipe
from viewgain.datasets._plan import recipe_to_dict
from viewgain.datasets._recipe_file import recipe_from_table
from viewgain.errors import ConfigError, DataError, MeshError, ViewgainError


@pytest.mark.parametrize("name", RECIPES)
def test_a_shipped_recipe_reads_and_writes_out_as_itself(name: str) -> None:
    shipped = recipe(name)
    table = recipe_to_dict(shipped) | {"takes": shipped.takes}
    del table["name"]
    assert recipe_from_table(table, name) == shipped


@pytest.mark.parametrize("name", [name for name in RECIPES if "recorded" not in name])
def test_a_shipped_recipe_has_a_plan_of_consecutive_units(name: str) -> None:
    plan = plan_of(recipe(name))
    assert [unit.number for unit in plan.units] == list(range(len(plan.units)))
    assert [unit for shard in plan.shards for unit in shard] == list(plan.units)
    assert set(plan.tables.categories) == {unit.category for unit in plan.units}


def test_a_key_that_came_later_changes_no_older_data_set_that_does_not_use_it() -> None:
    digest = plan_of(recipe("coverage_table1")).digest
    assert digest.startswith("210777d1b2f9")  # as it stands on the cards of networks that were trained before there was wander
    table = recipe_to_dict(recipe("coverage_table1"))
    del table["name"]
    assert plan_of(recipe_from_table(table, "coverage_table1")).digest == digest
    changed = {**table, "coverage": {**table["coverage"], "wander": 0.5}}
    assert plan_of(recipe_from_table(changed, "coverage_table1")).digest != digest


def test_the_papers_boxes_are_eleven_by_four_by_a_thousand() -> None:
    plan = plan_of(recipe("boxes_paper"))
    scans = [(unit.object, unit.source[0], capture) for unit in plan.units for capture in unit.source[1]]
    assert len(scans) == len(set(scans)) == 44_000
    assert {(box, view) for box, view, _ in scans} == {(box, view) for box in range(11) for view in range(4)}
    drawn = [np.random.default_rng([number, 0]).uniform(0.1, 0.6, 3) for number in range(11)]
    np.testing.assert_allclose(recipe("boxes_paper").content.sizes, drawn, atol=5.1e-5)  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("makes = 'x'", "wanted one table of"),
        ("makes = 'x'\n[boxes]\ncount = 1\n[coverage]", "wanted one table of"),
        ("[boxes]\ncount = 1", "makes"),
        ("makes = 'x'\ncolour = 3\n[boxes]\ncount = 1", "colour"),
        ("makes = 'x'\nseed = -1\n[boxes]\ncount = 1", "seed"),
        ("makes = 'x'\nseed = 'a'\n[boxes]\ncount = 1", "seed"),
        ("makes = 'x'\nseed = true\n[boxes]\ncount = 1", "seed"),
        ("makes = 'x'\n[boxes]\ncolour = 3", "colour"),
        ("makes = 'x'\n[boxes]", "sizes"),
        ("makes = 'x'\n[boxes]\ncount = 1\nsizes = [[1, 1, 1]]", "sizes"),
        ("makes = 'x'\n[boxes]\nsizes = [[1, 1]]", "sizes"),
        ("makes = 'x'\n[boxes]\nsizes = [[1, 1, -1]]", "positive"),
        ("makes = 'x'\n[boxes]\ncount = 1\ntrain_captures = 5000", "train_captures"),
        ("makes = 'x'\n[boxes]\ncount = 5\ncameras = ['kinect_v9']", "kinect_v9"),
        ("makes = 'x'\n[boxes]\ncount = 5\nrig = 'ring0'", "ring0"),
        ("makes = 'x'\n[boxes]\ncount = 5\nwithout = ['gravity']", "gravity"),
        ("makes = 'x'\n[coverage]\nprotocol = 'mine'", "mine"),
        ("makes = 'x'\n[coverage]\nstarts = 17", "starts"),
        ("makes = 'x'\n[coverage]\nsteps = 2", "steps"),
        ("makes = 'x'\n[coverage]\nsteps = -1", "steps"),
        ("makes = 'x'\n[coverage]\nwander = 1.5", "wander"),
        ("makes = 'x'\n[coverage]\ncategories = ['unicorn']", "unicorn"),
        ("makes = 'x'\n[coverage]\ntest_share = 1.0", "test_share"),
        ("makes = 'x'\n[meshes]\nviews = [5, 4]", "views"),
        ("makes = 'x'\n[recorded]", "--recordings"),
        ("makes = 'x'\n[points]\nframe = 'moon'\n[boxes]\ncount = 1", "frame"),
        ("makes = 'x'\n[points]\ncap = 0\n[boxes]\ncount = 1", "cap"),
        ("makes = 'x'\npoints = 3\n[boxes]\ncount = 1", "points"),
        ("makes = ", "TOML"),
    ],
)
def test_a_wrong_recipe_says_what_is_wrong_in_one_line(text: str, says: str, tmp_path: Path) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(text)
    with pytest.raises(ViewgainError, match=says) as raised:
        plan_of(recipe(path))
    assert len(str(raised.value).splitlines()) == 1


def test_what_is_no_recipe_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="boxes_paper_tiny"):
        recipe("boxes_papr")
    with pytest.raises(ConfigError, match=r"missing\.toml"):
        recipe(tmp_path / "missing.toml")
    with pytest.raises(MeshError):
        plan_of(recipe("coverage_paper_tiny"), meshes=tmp_path / "nothing")


def test_a_plan_without_units_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text("makes = 'x'\n[boxes]\ncount = 1\nrig = 'irregular'\nviews = [0, 0]")
    with pytest.raises((DataError, ConfigError)):
        plan_of(recipe(tmp_path / "a.toml"))

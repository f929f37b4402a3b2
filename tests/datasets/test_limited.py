"""Some of a plan's meshes: which, in what order, under what numbers, and that the draw is even."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from viewgain.datasets import CoverageSettings, Plan, limited, plan_of, recipe
from viewgain.errors import ConfigError

COUNTS = {"box": 7, "chair": 3, "mug": 1}


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Plan:
    """Meshes of three categories; they are named by their files and not read."""
    folder: Path = tmp_path_factory.mktemp("meshes")
    for category, count in COUNTS.items():
        (folder / category).mkdir()
        for number in range(count):
            (folder / category / f"{number}.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    whole = recipe("coverage_paper_tiny")
    assert isinstance(whole.content, CoverageSettings)
    return plan_of(replace(whole, content=replace(whole.content, categories=(), held_out=())), meshes=folder)


def names(plan: Plan) -> list[str]:
    return [unit.name for unit in plan.units]


@pytest.mark.parametrize("most", [1, 2, 3, 5, 7, 100])
def test_each_category_keeps_so_many_in_their_order_numbered_anew(plan: Plan, most: int) -> None:
    found = limited(plan, most, rng=np.random.default_rng(most))
    assert Counter(unit.category for unit in found.units) == {name: min(most, count) for name, count in COUNTS.items()}
    assert names(found) == [name for name in names(plan) if name in set(names(found))]
    assert len(set(names(found))) == len(found.units)
    assert [(unit.number, unit.object) for unit in found.units] == [(k, k) for k in range(len(found.units))]
    old = {unit.name: unit for unit in plan.units}
    for unit in found.units:
        before = old[unit.name]
        assert (unit.category, unit.source, unit.splits) == (before.category, before.source, before.splits)
    assert (found.recipe, found.tables) == (plan.recipe, plan.tables)


def test_a_limit_over_all_changes_nothing(plan: Plan) -> None:
    assert limited(plan, max(COUNTS.values()), rng=np.random.default_rng(0)).units == plan.units


def test_the_draw_is_the_generators_and_even(plan: Plan) -> None:
    """Each of the seven boxes is among two of them in 2 / 7 of the draws: 700 draws, 200 each, standard deviation 12."""
    rng = np.random.default_rng(3)
    seen = Counter(name for _ in range(700) for name in names(limited(plan, 2, rng=rng)) if name.startswith("box"))
    assert len(seen) == COUNTS["box"]
    assert 150 < min(seen.values()) <= max(seen.values()) < 250
    once, again, other = (names(limited(plan, 2, rng=np.random.default_rng(seed))) for seed in (1, 1, 2))
    assert once == again != other


@pytest.mark.parametrize("most", [0, -1])
def test_fewer_than_one_are_refused(plan: Plan, most: int) -> None:
    with pytest.raises(ConfigError, match=f"got {most} meshes per category"):
        limited(plan, most, rng=np.random.default_rng(0))

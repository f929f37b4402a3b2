"""The coverage table: areas, gaps, categories and pairs by hand; faults of single objects."""

import numpy as np
import pytest

from viewgain.datasets import Manifest, Skipped
from viewgain.datasets._plan import recipe_to_dict
from viewgain.errors import ConfigError, DataError
from viewgain.evaluation import (
    Played,
    PlayTask,
    check_policies,
    coverage_table,
    coverage_to_markdown,
    data_plan,
    fresh_plan,
    play,
    unit_parts,
)


def flat(number: int, category: str, **levels: float) -> Played:
    """Return curves that do not rise; the published rule counts a tenth more. Their AUC of ten views is 0.95 of the level."""
    curves = {name: level * np.stack([np.ones(10), np.full(10, 1.1)]) for name, level in levels.items()}
    return Played(number=number, category=category, coverage=curves)


PLAYED = [
    flat(2, "b", random=0.4, farthest=0.5, oracle=0.8, net=0.6),
    flat(0, "a", random=0.2, farthest=0.3, oracle=0.4, net=0.3),
    flat(1, "b", random=0.3, farthest=0.4, oracle=0.6, net=0.6),
]


def test_the_figures_by_hand() -> None:
    table = coverage_table(PLAYED, data="d", split="meshes", title="t", protocol="pcnbv")
    assert (table.rig, table.views, table.steps, table.objects, table.categories) == ("pcnbv33", 33, 10, 3, 2)
    by_union = {row.policy: row for row in table.rows if row.rule == "union"}
    assert list(by_union) == ["random", "farthest", "net", "oracle"]
    net = by_union["net"]
    assert net.auc.mean[0] == pytest.approx(0.95 * 0.5)
    assert net.auc_by_category == pytest.approx(0.95 * (0.3 + 0.6) / 2)
    assert net.closed is not None
    assert net.closed.mean[0] == pytest.approx(0.6 / 0.9)
    assert net.over_farthest.mean[0] == pytest.approx(0.95 * 0.1)
    assert net.over_farthest.low[0] == pytest.approx(0.0)  # the first object drawn three times
    assert net.coverage == pytest.approx((0.5,) * 10)
    assert by_union["oracle"].closed is not None
    assert by_union["oracle"].closed.low == by_union["oracle"].closed.high == pytest.approx((1.0,))
    published = {row.policy: row for row in table.rows if row.rule == "published"}
    assert published["net"].auc.mean[0] == pytest.approx(1.1 * net.auc.mean[0])
    said = coverage_to_markdown(table)
    assert said.count("| net |") == 2
    assert "66.7%" in said


def test_no_object_is_said_with_the_first_reason() -> None:
    with pytest.raises(DataError, match="a/b: no triangles"):
        coverage_table(
            [], data="d", split="s", title="t", protocol="paper", skipped=[Skipped(unit=0, name="a/b", reason="no triangles")]
        )


def test_the_three_yardsticks_always_play_and_unknown_names_are_refused() -> None:
    assert check_policies(["uniform", "oracle", "uniform"]) == ("random", "farthest", "oracle", "uniform")
    with pytest.raises(ConfigError, match="proximity_count"):
        check_policies(["nearest"])


def test_fresh_objects_are_of_all_16_categories_and_of_no_training_seed() -> None:
    plan = fresh_plan(2, seed=0)
    seen, unseen = unit_parts(plan, "fresh")
    assert (len(seen.units), len(unseen.units)) == (16, 16)
    assert {unit.category for unit in seen.units}.isdisjoint(unit.category for unit in unseen.units)
    assert plan.recipe.seed > 1_000_000
    assert fresh_plan(2, seed=1).recipe.seed != plan.recipe.seed


def test_an_object_is_played_the_same_wherever_and_whoever_plays_beside() -> None:
    plan = fresh_plan(1, seed=0)
    unit = min(plan.units, key=lambda each: each.category != "skateboard")
    both = [
        play(
            PlayTask(
                unit=unit, mesh_seed=plan.recipe.seed, protocol="paper", policies=policies, networks=(), steps=3, seed=4
            )
        )
        for policies in (check_policies(()), check_policies(("uniform",)))
    ]  # fmt: skip
    assert isinstance(both[0], Played)
    assert isinstance(both[1], Played)
    for name, curves in both[0].coverage.items():
        assert np.array_equal(curves, both[1].coverage[name])
        assert curves.shape == (2, 3)
        assert np.all(np.diff(curves, axis=1) >= 0)
        assert curves[0, 0] == curves[1, 0]  # the first view counts nothing twice
    assert both[0].coverage["oracle"][0, 1] >= both[0].coverage["farthest"][0, 1]


def test_another_data_sets_objects_are_refused() -> None:
    plan = fresh_plan(1, seed=0)
    facts = {"viewgain": "0", "frame": "object", "tables": plan.tables, "targets": (), "objects": (), "shards": ()}
    right = Manifest(recipe=recipe_to_dict(plan.recipe), plan=plan.digest, **facts)  # type: ignore[arg-type]
    assert data_plan(right).units == plan.units
    wrong = Manifest(recipe=recipe_to_dict(plan.recipe), plan="0" * 64, **facts)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="--meshes"):
        data_plan(wrong)

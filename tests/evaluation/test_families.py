"""Which networks are averaged over their seeds, and which are held against each other."""

from typing import Any

import pytest

from viewgain.evaluation import compared, families, without_and_with
from viewgain.inference import ModelCard


def card(kind: str, seed: str | None, **changes: Any) -> ModelCard:
    told = kind in ("pc_nbv", "compact_view")
    training = {"recipe": f"{kind}_recipe", "steps": "70 of 100, batch 2", "data": "d", "target": "gain_published"}
    values: dict[str, Any] = {
        "name": kind, "task": "t", "kind": kind, "rig": "pcnbv16", "views": 16, "with_view_state": told,
        "order": "rig" if told else "present_first", "training": training if seed is None else training | {"seed": seed},
    }  # fmt: skip
    return ModelCard(**(values | changes))


def test_networks_that_differ_by_their_seed_alone_are_one_family() -> None:
    cards = {
        "a0": card("compact", "0"),
        "b0": card("compact_view", "0"),
        "a1": card("compact", "1"),
        "b1": card("compact_view", "1"),
    }
    found = families(cards)
    assert [(each.name, each.members) for each in found] == [
        ("compact_recipe, mean of 2 seeds", ("a0", "a1")),
        ("compact_view_recipe, mean of 2 seeds", ("b0", "b1")),
    ]
    assert [(one.members, two.members) for one, two in without_and_with(found)] == [(("a0", "a1"), ("b0", "b1"))]


def test_other_data_steps_frame_or_points_or_no_seed_keep_networks_apart() -> None:
    first = card("compact", "0")
    for other in (
        card("compact", "1", frame="camera"),
        card("compact", "1", points=256),
        card("compact", "1", training=first.training | {"seed": "1", "data": "other"}),
        card("compact", "1", training=first.training | {"seed": "1", "steps": "70 of 200, batch 2"}),
        card("compact", "0"),
        card("compact", None),
    ):
        assert [each.name for each in families({"a": first, "b": other})] == ["a", "b"]


@pytest.mark.parametrize(
    ("names", "further"),
    [
        (("without", "with", "other"), [("other", "without")]),
        (("with", "without", "other"), [("other", "without")]),
        (("other", "with", "without"), [("with", "other"), ("without", "other")]),
        (("without", "with", "other", "large"), [("other", "without"), ("large", "with")]),
        (("large", "other"), [("other", "large")]),
    ],
)
def test_each_is_held_against_the_first_that_is_told_as_much(names: tuple[str, ...], further: list[tuple[str, str]]) -> None:
    cards = {
        "without": card("compact", "0"),
        "with": card("compact_view", "0"),
        "other": card("compact", "0", points=256),
        "large": card("pc_nbv", "0"),
    }
    pairs = compared(families({name: cards[name] for name in names}))
    assert pairs == [("without", "with")] * ("without" in names) + further


def test_networks_that_differ_by_more_than_the_view_state_are_not_paired() -> None:
    without = card("compact", "0")
    same = card("compact_view", "1")
    assert len(without_and_with(families({"a": without, "b": same}))) == 1
    for other in (
        card("compact_view", "0", rig="ring16"),
        card("compact_view", "0", frame="camera"),
        card("compact_view", "0", normalisation="seen_box"),
        card("compact_view", "0", training=same.training | {"steps": "70 of 200, batch 2"}),
        card("compact_view", "0", training=same.training | {"data": "other"}),
        card("compact_view", "0", training=same.training | {"target": "gain_union"}),
        card("compact_view", "0", training=same.training | {"teacher": "big, weight 0.5"}),
    ):
        assert without_and_with(families({"a": without, "b": other})) == ()


def test_the_plan_says_whether_data_is_the_same_where_it_is_stated() -> None:
    """Older cards do not note the seed of the data; the plan is made from it."""
    old, new, other = (
        f"recipe r, seed {seed}, plan {plan}" for seed, plan in [("not noted", "ab12"), ("0", "ab12"), ("0", "cd34")]
    )
    first, second, third = (
        card("compact", str(seed), training=card("compact", None).training | {"data": data, "seed": str(seed)})
        for seed, data in enumerate((old, new, other))
    )
    found = families({"a": first, "b": second, "c": third})
    assert [each.members for each in found] == [("a", "b"), ("c",)]
    told = card("compact_view", "0", training=first.training | {"data": new})
    assert [(one.members, two.members) for one, two in without_and_with(families({"a": first, "c": third, "t": told}))] == [
        (("a",), ("t",))
    ]


def test_families_of_one_name_are_told_apart_and_only_kin_are_paired() -> None:
    early = {f"e{k}": card("compact", str(k)) for k in range(2)}
    late = {f"l{k}": card("compact", str(k), points=256) for k in range(2)}
    found = families(early | late | {"p": card("pc_nbv", "0")})
    assert [each.name for each in found] == ["compact_recipe, mean of 2 seeds", "compact_recipe, mean of 2 seeds (2)", "p"]
    assert without_and_with(found) == ()

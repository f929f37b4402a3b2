"""Groups of parts, the joining of them, and the dice that the recipes throw."""

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.shapes.parts import is_closed, pieces
from viewgain.shapes._assemble import around, assemble, both_sides, shifted, spread, turned
from viewgain.shapes._bases import legs, panels, pedestal, sled, star, stretchers, trestles
from viewgain.shapes._dice import Dice
from viewgain.shapes._primitives import block, cylinder


def test_an_assembly_has_all_parts_and_stands_about_the_origin() -> None:
    mesh = assemble([block(1.0, 2.0, 3.0).at(5.0, 6.0, 7.0), cylinder(0.5, 1.0).at(6.0, 6.0, 7.5)], "two")
    assert mesh.name == "two"
    assert len(pieces(mesh.vertices, mesh.faces).volumes) == 2
    np.testing.assert_allclose(mesh.bounds, [[-1, -1, 0], [1, 1, 3]], atol=1e-12)
    assert mesh.area == pytest.approx(22 + assemble([cylinder(0.5, 1.0)], "one").area)


def test_assembling_leaves_the_parts_alone() -> None:
    part = block(1.0, 1.0, 1.0).at(3.0)
    before = part.vertices.copy()
    assemble([part, part], "twice")
    np.testing.assert_array_equal(part.vertices, before)


def test_both_sides_are_mirror_images() -> None:
    left, right = both_sides([block(1.0, 1.0, 1.0).at(y=2.0)])
    np.testing.assert_allclose(left.vertices * (1, -1, 1), right.vertices)
    assert is_closed(right.faces)
    assert pieces(right.vertices, right.faces).volumes[0] == pytest.approx(1.0)


def test_copies_around_the_axis_close_the_circle() -> None:
    parts = around(block(0.1, 0.1, 0.1).at(1.0), 5, start=0.3)
    middles = np.array([part.vertices.mean(axis=0) for part in parts])
    angles = np.unwrap(np.arctan2(middles[:, 1], middles[:, 0]))
    np.testing.assert_allclose(angles, 0.3 + 2 * pi / 5 * np.arange(5))
    np.testing.assert_allclose(middles.mean(axis=0)[:2], 0, atol=1e-12)


def test_groups_move_and_turn_together() -> None:
    parts = [block(1.0, 1.0, 1.0), block(2.0, 1.0, 1.0).at(3.0)]
    for one, other in zip(turned(shifted(parts, 1.0, 2.0, 3.0), 0.4, "x"), parts, strict=True):
        np.testing.assert_array_equal(one.vertices, other.at(1.0, 2.0, 3.0).turned(0.4, "x").vertices)


@given(st.integers(2, 20), st.floats(0.1, 10.0))
def test_places_are_spread_evenly(count: int, width: float) -> None:
    places = np.array(spread(count, width))
    np.testing.assert_allclose(np.diff(places), width / (count - 1))
    np.testing.assert_allclose(places, -places[::-1], atol=1e-12)
    assert spread(1, width) == [0.0]


@pytest.mark.parametrize("base", [pedestal, star, sled, panels, trestles, lambda *a: legs(*a, thickness=0.05)])
def test_every_base_carries_at_its_height_and_stands_near_its_rectangle(base) -> None:  # type: ignore[no-untyped-def]
    for seed in range(60):
        parts = base(Dice(np.random.default_rng(seed)), 0.5, 0.6, 0.45)
        vertices = np.concatenate([part.vertices for part in parts])
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        assert low[2] == pytest.approx(0.0, abs=5e-3)  # a leaning bar dips its rim by a few millimetres
        assert high[2] == pytest.approx(0.45, abs=2e-2)
        assert (np.abs([low, high])[:, :2].max(axis=0) < [0.25 + 0.2, 0.3 + 0.2]).all()


def test_legs_come_in_the_asked_number_and_stretchers_below_the_seat() -> None:
    for seed in range(40):
        dice = Dice(np.random.default_rng(seed))
        assert len(legs(dice, 0.5, 1.5, 0.45, thickness=0.05, pairs=3)) == 6
        bars = stretchers(dice, 0.5, 0.5, 0.45, thickness=0.05)
        assert len(bars) in (0, 2, 3, 4)
        assert all(part.vertices[:, 2].max() < 0.3 for part in bars)


def test_dice_are_uniform_in_their_range() -> None:
    """Chi-squared of 6,000 throws in 6 classes: five degrees of freedom, 20.5 at one in a thousand."""
    dice = Dice(np.random.default_rng(4))
    counts = np.bincount([dice.count(2, 7) for _ in range(6000)], minlength=8)[2:]
    assert ((counts - 1000) ** 2 / 1000).sum() < 20.5
    numbers = np.array([dice.between(-1.0, 2.0) for _ in range(6000)])
    assert numbers.min() >= -1
    assert numbers.max() < 2
    counts = np.histogram(numbers, 6, (-1, 2))[0]
    assert ((counts - 1000) ** 2 / 1000).sum() < 20.5


def test_dice_pick_by_weight_and_never_what_weighs_nothing() -> None:
    dice = Dice(np.random.default_rng(5))
    picks = [dice.pick(rare=1.0, never=0.0, often=3.0) for _ in range(4000)]
    assert set(picks) == {"rare", "often"}
    assert picks.count("often") / 4000 == pytest.approx(0.75, abs=0.03)  # four standard deviations
    assert np.mean([dice.chance(0.2) for _ in range(4000)]) == pytest.approx(0.2, abs=0.03)
    assert not any(dice.chance(0.0) for _ in range(100))
    assert all(dice.chance(1.0) for _ in range(100))

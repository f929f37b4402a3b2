"""Laws of the intervals."""

import numpy as np
import pytest

from viewgain.errors import DataError
from viewgain.evaluation import difference_by_object, quotient_of_groups, ratio_by_object, shares_by_object


def test_kin_of_one_object_do_not_narrow_the_interval() -> None:
    rng = np.random.default_rng(5)
    once = rng.random((60, 1)) < 0.6
    alone = shares_by_object(once, np.arange(60), rng=np.random.default_rng(1))
    copied = shares_by_object(np.repeat(once, 20, axis=0), np.repeat(np.arange(60), 20), rng=np.random.default_rng(1))
    assert copied.low == pytest.approx(alone.low)
    assert copied.high == pytest.approx(alone.high)
    assert alone.low[0] < alone.mean[0] < alone.high[0]


def test_the_interval_holds_the_truth_about_as_often_as_it_says() -> None:
    held = 0
    for seed in range(200):
        rng = np.random.default_rng([seed, 17])
        sizes = rng.integers(1, 6, size=80)
        chances = np.repeat(rng.random(80), sizes)  # kin share a chance, and chances average one half
        values = (rng.random(len(chances)) < chances)[:, None]
        shares = shares_by_object(values, np.repeat(np.arange(80), sizes), rng=rng, draws=400)
        held += shares.low[0] <= 0.5 <= shares.high[0]
    assert 181 <= held <= 199  # 0.95 of 200, three standard deviations to each side


def test_a_paired_difference_is_surer_than_two_intervals_and_turns_its_sign() -> None:
    rng = np.random.default_rng(3)
    first = (rng.random((300, 1)) < 0.5).astype(float)
    second = first.copy()
    second[:6] = 0.0
    objects = np.arange(300) // 3
    paired = difference_by_object(first, second, objects, rng=np.random.default_rng(1))
    turned = difference_by_object(second, first, objects, rng=np.random.default_rng(1))
    single = shares_by_object(first, objects, rng=np.random.default_rng(1))
    assert paired.mean[0] == pytest.approx(first.mean() - second.mean())
    assert paired.high[0] - paired.low[0] < 0.5 * (single.high[0] - single.low[0])
    assert (turned.low[0], turned.high[0]) == pytest.approx((-paired.high[0], -paired.low[0]))


def test_no_samples_are_said() -> None:
    with pytest.raises(DataError, match="no samples"):
        shares_by_object(np.zeros((0, 5)), np.zeros(0), rng=np.random.default_rng(0))


def test_a_ratio_is_of_the_sums_and_its_parts_are_drawn_together() -> None:
    whole = np.repeat(np.random.default_rng(1).random((30, 1)) + 0.1, 2, axis=1)
    objects = np.arange(30)
    half = ratio_by_object(0.5 * whole, whole, objects, rng=np.random.default_rng(2))
    assert half is not None
    assert half.mean == half.low == half.high == pytest.approx((0.5, 0.5))
    mixed = np.where(objects[:, None] % 2 == 0, whole, 0.0)
    ratio = ratio_by_object(mixed, whole, objects, rng=np.random.default_rng(2))
    assert ratio is not None
    assert ratio.mean[0] == pytest.approx(mixed.sum() / whole.sum())
    assert ratio.low[0] < ratio.mean[0] < ratio.high[0]


def test_a_ratio_to_nothing_is_none_and_draws_of_nothing_are_passed_over() -> None:
    assert ratio_by_object(np.ones((4, 2)), [[0, 1]] * 4, np.arange(4), rng=np.random.default_rng(0)) is None
    rare = np.zeros((6, 1))
    rare[0] = 2.0
    found = ratio_by_object(rare / 2, rare, np.arange(6), rng=np.random.default_rng(0))
    assert found is not None
    assert (found.low, found.high) == ((0.5,), (0.5,))


def test_a_quotient_of_two_groups_is_less_sure_than_one_of_pairs() -> None:
    values = np.random.default_rng(1).random((40, 1)) + 0.2
    paired = ratio_by_object(values, values, np.arange(40), rng=np.random.default_rng(2))
    apart = quotient_of_groups((values, np.arange(40)), (values[::-1], np.arange(40)), rng=np.random.default_rng(2))
    assert paired is not None
    assert apart is not None
    for each in (paired.low, paired.high, apart.mean):
        assert each == pytest.approx((1.0,))
    assert apart.low[0] < 0.95 < 1.05 < apart.high[0]
    assert quotient_of_groups((values, np.arange(40)), (0 * values, np.arange(40)), rng=np.random.default_rng(2)) is None

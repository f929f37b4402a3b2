"""What a choice is worth: the paper's own columns from its own log, floors against counting."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewgain.errors import ConfigError, DataError
from viewgain.gain import POSITION_LIMITS, choices, constant_offset, hits, shortfall, uniform_hits

SEEDS = st.integers(0, 2**32 - 1)


def drawn_gains(rng: np.random.Generator, samples: int = 40, views: int = 6) -> np.ndarray:
    """Return gains in coarse steps, so that there are ties; as single precision."""
    return (rng.integers(0, 12, (samples, views)) * 0.01).astype(np.float32)


def drawn_free(rng: np.random.Generator, samples: int = 40, views: int = 6) -> np.ndarray:
    free = rng.random((samples, views)) < 0.7
    free[np.arange(samples), rng.integers(views, size=samples)] = True
    return free


def test_the_published_columns_come_from_the_published_log(data_dir: Path) -> None:
    log = np.loadtxt(data_dir / "real_boxes" / "trai_table1" / "All_data.csv", delimiter=",")
    greedy, with_view, without = log[:, 5], log[:, 3], log[:, 4]
    gains = np.column_stack((greedy, with_view, without))
    for column, wanted in [(1, [91.66, 84.55, 73.63, 69.42]), (2, [85.25, 77.70, 66.30, 61.87])]:
        shares = 100 * hits(shortfall(gains, np.full(len(log), column))).mean(axis=0)
        assert np.round(shares[1:], 2).tolist() == wanted
        assert shares[0] < shares[-1]
    assert np.all(hits(shortfall(gains, choices(gains))))


@given(SEEDS)
def test_a_uniform_guess_is_the_mean_over_all_free_views(seed: int) -> None:
    rng = np.random.default_rng(seed)
    gains, free = drawn_gains(rng), drawn_free(rng)
    for row, chances in enumerate(uniform_hits(gains, free)):
        best = max(float(gain) for gain, may in zip(gains[row], free[row], strict=True) if may)
        lost = [best - float(gain) for gain, may in zip(gains[row], free[row], strict=True) if may]
        counted = [np.mean([each <= limit + 1e-6 for each in lost]) for limit in POSITION_LIMITS]
        np.testing.assert_allclose(chances, counted)


@given(SEEDS)
def test_more_tolerance_never_hits_less_and_the_best_view_always_does(seed: int) -> None:
    rng = np.random.default_rng(seed)
    gains, free = drawn_gains(rng), drawn_free(rng)
    within = hits(shortfall(gains, choices(rng.normal(size=gains.shape), free), free))
    order = np.argsort(POSITION_LIMITS)
    assert np.all(np.diff(within[:, order].astype(int), axis=1) >= 0)
    assert np.all(hits(shortfall(gains, choices(gains, free), free)))


def test_equal_views_are_equally_right_and_visited_ones_are_never_chosen() -> None:
    gains = np.array([[0.9, 0.3, 0.3, 0.26]])
    free = np.array([[False, True, True, True]])
    assert choices([[9.0, 1.0, 1.0, 0.0]], free).tolist() == [1]
    assert [hits(shortfall(gains, [view], free))[0].tolist() for view in (1, 2)] == [[True] * 5] * 2
    assert hits(shortfall(gains, [3], free))[0].tolist() == [False, True, False, False, False]
    assert not hits(shortfall(gains, [0], free)).any()


def test_differences_at_a_limit_count_in_single_precision_too() -> None:
    for limit in POSITION_LIMITS[1:]:
        gains = np.array([[0.7, 0.7 - limit]], dtype=np.float32)
        assert hits(shortfall(gains, [1]))[0, POSITION_LIMITS.index(limit)]
        gains[0, 1] -= 1e-4
        assert not hits(shortfall(gains, [1]))[0, POSITION_LIMITS.index(limit)]


@given(SEEDS)
def test_no_other_constant_answer_is_right_more_often_where_it_was_chosen(seed: int) -> None:
    rng = np.random.default_rng(seed)
    gains, free = drawn_gains(rng), drawn_free(rng)
    rates = [hits(shortfall(gains, np.full(len(gains), view), free))[:, 0].mean() for view in range(gains.shape[1])]
    assert rates[constant_offset(gains, free)] == max(rates)


def test_no_samples_and_no_free_view_are_said() -> None:
    with pytest.raises(DataError, match="training samples"):
        constant_offset(np.zeros((0, 4)))
    with pytest.raises(ConfigError, match="all visited"):
        choices(np.zeros((1, 3)), np.zeros((1, 3), dtype=bool))

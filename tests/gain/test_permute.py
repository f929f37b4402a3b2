"""Circular permutation of scores."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewgain.errors import ConfigError
from viewgain.gain import rolled, unrolled

SCORES = st.integers(1, 40).flatmap(lambda count: st.tuples(st.just(count), st.integers(0, count - 1), st.integers(0, count - 1)))


def scores(count: int) -> np.ndarray:
    return np.random.default_rng(count).random((3, count))


@given(SCORES)
def test_there_and_back(case: tuple[int, int, int]) -> None:
    count, view, _ = case
    table = scores(count)
    np.testing.assert_array_equal(unrolled(rolled(table, view), view), table)
    np.testing.assert_array_equal(rolled(unrolled(table, view), view), table)


@given(SCORES)
def test_entry_k_is_k_stations_on(case: tuple[int, int, int]) -> None:
    count, view, ahead = case
    turned = rolled(scores(count), view)
    np.testing.assert_array_equal(turned[:, ahead], [row[(view + ahead) % count] for row in scores(count)])
    np.testing.assert_array_equal(turned[0], rolled(scores(count)[0], view))


@given(SCORES)
def test_two_turns_are_one(case: tuple[int, int, int]) -> None:
    count, first, second = case
    twice = rolled(rolled(scores(count), first), second)
    np.testing.assert_array_equal(twice, rolled(scores(count), (first + second) % count))
    np.testing.assert_array_equal(np.sort(twice, axis=1), np.sort(scores(count), axis=1))  # nothing is lost


@pytest.mark.parametrize("view", [-1, 4])
def test_a_station_that_is_not_there_is_refused(view: int) -> None:
    for turn in (rolled, unrolled):
        with pytest.raises(ConfigError, match="view"):
            turn(np.zeros(4), view)

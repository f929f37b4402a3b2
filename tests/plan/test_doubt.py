"""The probability of being the best: laws, and a count over draws."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from viewgain.plan import chances_of_best

few = st.lists(st.tuples(st.floats(-1, 1), st.floats(0, 2)), min_size=1, max_size=6)


@settings(max_examples=30)
@given(few, st.floats(-5, 5), st.floats(0.01, 100))
def test_they_are_probabilities_that_do_not_see_origin_and_unit(
    pairs: list[tuple[float, float]], shift: float, unit: float
) -> None:
    scores, sigmas = np.round(np.array(pairs).T, 3)
    chances = chances_of_best(scores, sigmas)
    assert chances.min() >= 0
    assert chances.sum() == pytest.approx(1)
    if sigmas.min() > 0:
        np.testing.assert_allclose(chances_of_best(unit * (scores + shift), unit * sigmas), chances, atol=1e-3)


def test_they_are_the_shares_of_a_count_over_draws() -> None:
    rng = np.random.default_rng(0)
    scores, sigmas = np.array([0.3, 0.25, 0.1, 0.32, -1.0]), np.array([0.05, 0.2, 0.01, 0.02, 0.5])
    draws = scores + sigmas * rng.standard_normal((200_000, 5))
    counted = np.bincount(draws.argmax(axis=1), minlength=5) / len(draws)
    np.testing.assert_allclose(chances_of_best(scores, sigmas), counted, atol=5e-3)


def test_cases_that_can_be_said_in_words() -> None:
    np.testing.assert_allclose(chances_of_best(np.full(7, 0.4), np.full(7, 0.1)), 1 / 7)
    np.testing.assert_allclose(chances_of_best(np.zeros(3), np.zeros(3)), 1 / 3)
    np.testing.assert_allclose(chances_of_best(np.array([0.0, 1.0]), np.zeros(2)), [0, 1], atol=1e-9)
    np.testing.assert_allclose(chances_of_best(np.array([0.7]), np.array([2.0])), 1)
    apart = chances_of_best(np.array([1.0, 0.0]), np.array([3.0, 4.0]))
    assert apart[0] == pytest.approx(0.5792597, abs=1e-3)  # Phi(1 / 5)


def test_a_higher_score_is_more_likely_the_best_and_more_noise_levels_all() -> None:
    base, sigmas = np.array([0.2, 0.5, 0.4]), np.full(3, 0.2)
    raised = [chances_of_best(base + np.array([step, 0, 0]), sigmas)[0] for step in np.linspace(-1, 1, 9)]
    assert raised == sorted(raised)
    best = [chances_of_best(base, np.full(3, sigma))[1] for sigma in (0.01, 0.1, 1.0, 10.0)]
    assert best == sorted(best, reverse=True)
    assert best[-1] == pytest.approx(1 / 3, abs=0.02)

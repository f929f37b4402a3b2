"""What all objectives share, and coverage as one of them."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewgain.errors import ConfigError
from viewgain.gain import Choice, CoverageGain, Objective, TakenViews, Weighted, cover, greedy_labels


@dataclass
class Given:
    """Returns what is known, and counts how often it is asked."""

    name: str = "given"
    factor: float = 1.0
    asked: int = 0

    def gains(self, known: np.ndarray) -> np.ndarray:
        self.asked += 1
        return self.factor * known


def test_a_choice_marks_the_first_of_the_best() -> None:
    choice: Objective[np.ndarray] = Choice(Given(), 0.8, 0.2)
    assert choice.gains(np.array([1.0, 3.0, 3.0, -2.0])).tolist() == [0.2, 0.8, 0.2, 0.2]
    assert choice.name == "given: 0.8 or 0.2"
    for numbers in ((0.0, 1.0), (np.nan, 0.0)):
        with pytest.raises(ConfigError, match="best"):
            Choice(Given(), *numbers)


def test_a_weight_of_zero_switches_a_term_off() -> None:
    off = Given("off")
    total = Weighted(((2.0, Given()), (0.0, off), (-1.0, Given("other", factor=3.0))))
    assert total.gains(np.array([1.0, 2.0])).tolist() == [-1.0, -2.0]
    assert off.asked == 0
    assert total.name == "2 given + -1 other"
    with pytest.raises(ConfigError, match="terms"):
        Weighted(())


@given(seed=st.integers(0, 2**32 - 1))
def test_coverage_as_an_objective_is_the_next_row_of_labels(seed: int) -> None:
    rng = np.random.default_rng(seed)
    covered = cover([rng.random((12, 3)) for _ in range(4)], rng.random((50, 3)), 0.25)
    for rule in ("published", "union"):
        labels = greedy_labels(covered, first=1, steps=3, rule=rule)
        taken = (1, *labels.order.tolist())
        for step in range(3):
            scores = CoverageGain(rule).gains(TakenViews(covered, taken[: step + 1]))
            assert scores.tolist() == labels.gains(rule)[step].tolist()
        assert CoverageGain(rule).gains(TakenViews(covered)).tolist() == covered.coverage.tolist()  # nothing taken: all it covers
    assert CoverageGain("union").name == "coverage_union"


def test_views_that_are_not_there_cannot_have_been_taken() -> None:
    with pytest.raises(ConfigError, match="taken"):
        TakenViews(cover([np.zeros((1, 3))], np.zeros((1, 3)), 1.0), (1,))

"""Histograms of volume errors, and what they say a view is worth."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewgain.errors import ConfigError
from viewgain.gain import (
    HISTOGRAM_OBJECTIVES,
    ONE_HOT,
    SOFT,
    EntropyReduction,
    ErrorHistogram,
    ExpectedError,
    HistogramRule,
    NearZero,
    ProbabilityWithin,
)
from viewgain.gain._histogram_scores import entropy

SEEDS = st.integers(0, 2**32 - 1)
RULES = st.builds(HistogramRule, width=st.floats(0.01, 0.2), limit=st.floats(0.1, 2.0), tolerance=st.floats(0.01, 0.5))


def random_errors(seed: int, views: int = 5) -> np.ndarray:
    rng = np.random.default_rng(seed)
    errors = rng.normal(0, 0.3, (views, 12)) + rng.normal(0, 0.2, (views, 1))
    errors[rng.random(errors.shape) < rng.random((views, 1)) * 0.8] = np.nan
    return errors


@given(seed=SEEDS, rule=RULES)
def test_every_scan_is_counted_once(seed: int, rule: HistogramRule) -> None:
    errors = random_errors(seed)
    histogram = ErrorHistogram.from_errors(errors, rule)
    np.testing.assert_array_equal(histogram.counts.sum(axis=1) + histogram.missed, histogram.scans)
    for view, row in enumerate(errors.tolist()):  # one by one
        twin = [sum(low <= error < high for error in row) for low, high in zip(rule.edges[:-1], rule.edges[1:], strict=True)]
        assert histogram.counts[view].tolist() == twin


@given(rule=RULES)
def test_bins_are_symmetric_about_the_one_around_zero(rule: HistogramRule) -> None:
    np.testing.assert_array_equal(rule.edges, -rule.edges[::-1])
    assert rule.edges[rule.middle] == pytest.approx(-rule.width / 2)
    assert rule.edges[rule.middle + 1] == pytest.approx(rule.width / 2)
    inner = rule.edges[1:-1]
    assert rule.limit - rule.width < inner[-1] * (1 + 1e-6)
    assert inner[-1] <= rule.limit * (1 + 1e-6)


def test_a_bin_holds_its_low_edge() -> None:
    histogram = ErrorHistogram.from_errors(np.array([[-0.25, 0.25, 0.75]]), HistogramRule(width=0.5, limit=0.75))
    assert histogram.edges.tolist() == [-np.inf, -0.75, -0.25, 0.25, 0.75, np.inf]
    assert histogram.counts.tolist() == [[0, 0, 1, 1, 1]]


def test_a_limit_on_an_edge_is_one() -> None:
    assert HistogramRule(width=0.1, limit=0.35).edges[1:-1].tolist() == pytest.approx(np.arange(-0.35, 0.36, 0.1))


@given(seed=SEEDS, rule=RULES)
def test_order_of_scans_does_not_count_and_order_of_views_carries_over(seed: int, rule: HistogramRule) -> None:
    errors, rng = random_errors(seed), np.random.default_rng(seed)
    shuffled, views = rng.permuted(errors, axis=1), rng.permutation(len(errors))
    for objective in (NearZero(), ProbabilityWithin(), ExpectedError(), EntropyReduction()):
        scores = objective.gains(ErrorHistogram.from_errors(errors, rule))
        np.testing.assert_allclose(objective.gains(ErrorHistogram.from_errors(shuffled, rule)), scores, rtol=1e-12)
        np.testing.assert_array_equal(objective.gains(ErrorHistogram.from_errors(errors[views], rule)), scores[views])


@given(seed=SEEDS, rule=RULES)
def test_a_miss_is_never_better_than_an_estimate(seed: int, rule: HistogramRule) -> None:
    errors = random_errors(seed)
    worse = errors.copy()
    worse[:, 0] = np.nan
    for objective in (NearZero(), ProbabilityWithin(), ExpectedError()):
        lost = objective.gains(ErrorHistogram.from_errors(worse, rule))
        assert np.all(lost <= objective.gains(ErrorHistogram.from_errors(errors, rule)))


@given(seed=SEEDS, rule=RULES)
def test_scores_stay_in_their_ranges(seed: int, rule: HistogramRule) -> None:
    histogram = ErrorHistogram.from_errors(random_errors(seed), rule)
    assert np.all((NearZero().gains(histogram) >= 0) & (NearZero().gains(histogram) <= 1))
    assert np.all((ExpectedError().gains(histogram) >= -rule.limit * (1 + 1e-12)) & (ExpectedError().gains(histogram) <= 0))
    most = np.log2(histogram.counts.shape[1] + 1)
    assert np.all((EntropyReduction().gains(histogram) >= -1e-12) & (EntropyReduction().gains(histogram) <= most))
    for choice, best, other in ((ONE_HOT, 1.0, 0.0), (SOFT, 0.8, 0.2)):
        assert sorted(choice.gains(histogram).tolist()) == [other] * 4 + [best]


def test_scores_by_hand() -> None:
    errors = np.array([[0.0, 0.01, 0.2, np.nan], [-0.04, 0.04, -0.04, 0.04], [np.nan, np.nan, np.inf, 7.0]])
    histogram = ErrorHistogram.from_errors(errors, HistogramRule(width=0.05, limit=0.5, tolerance=0.04))
    assert histogram.missed.tolist() == [1, 0, 3]
    assert histogram.counts[2, -1] == 1  # 7.0, beyond the limit
    assert NearZero().gains(histogram).tolist() == [0.5, 0.0, 0.0]
    assert ProbabilityWithin().gains(histogram).tolist() == [0.5, 1.0, 0.0]
    assert ProbabilityWithin(0.3).gains(histogram).tolist() == [0.75, 1.0, 0.0]
    np.testing.assert_allclose(ExpectedError().gains(histogram), [-(0.01 + 0.2 + 0.5) / 4, -0.04, -0.5])
    assert ONE_HOT.gains(histogram).tolist() == [1.0, 0.0, 0.0]
    assert SOFT.gains(histogram).tolist() == [0.8, 0.2, 0.2]
    # Outcomes: near zero twice, one bin at 0.2, one miss; two bins twice; beyond once and three misses.
    after = [1.5, 1.0, -(0.75 * np.log2(0.75) + 0.25 * np.log2(0.25))]
    np.testing.assert_allclose(EntropyReduction().gains(histogram), np.log2(histogram.counts.shape[1] + 1) - after)


def test_entropy_is_reduced_from_what_was_known() -> None:
    errors = np.array([[0.0, 0.0, 0.0, 0.0], [0.0, 0.2, 0.4, np.nan]])
    histogram = ErrorHistogram.from_errors(errors, before=np.array([0.0, 0.2, np.nan, np.inf]))
    assert EntropyReduction().gains(histogram).tolist() == [1.5, -0.5]
    assert entropy(np.zeros(3, dtype=int)) == 0


def test_a_biased_estimator_still_has_a_best_view() -> None:
    errors = np.array([[-0.2, -0.2], [-0.1, np.nan], [-0.1, 0.1], [np.nan, np.nan]])
    histogram = ErrorHistogram.from_errors(errors)
    assert not NearZero().gains(histogram).any()
    assert NearZero(widen=True).gains(histogram).tolist() == [0, 0.5, 1, 0]
    assert ONE_HOT.gains(histogram).tolist() == [0, 0, 1, 0]
    assert ONE_HOT.gains(ErrorHistogram.from_errors(np.full((3, 2), np.nan))).tolist() == [1, 0, 0]  # nothing to tell them apart


def test_every_objective_has_a_name_of_its_own() -> None:
    histogram = ErrorHistogram.from_errors(random_errors(0))
    assert len({objective.name for objective in HISTOGRAM_OBJECTIVES.values()}) == len(HISTOGRAM_OBJECTIVES)
    for objective in HISTOGRAM_OBJECTIVES.values():
        assert objective.gains(histogram).shape == (5,)
    assert ProbabilityWithin(0.02).name == "probability_within_0.02"


def test_the_input_is_left_alone() -> None:
    errors = np.array([[np.inf, 0.1]])
    ErrorHistogram.from_errors(errors)
    assert np.isinf(errors[0, 0])


@pytest.mark.parametrize(
    "settings", [{"width": 0.0}, {"width": -1.0}, {"width": 3.0}, {"tolerance": 0.0}, {"limit": np.inf}, {"width": 1e-6}]
)
def test_rules_that_make_no_sense_are_refused(settings: dict[str, float]) -> None:
    with pytest.raises(ConfigError, match="histogram"):
        HistogramRule(**settings)


def test_errors_that_make_no_sense_are_refused() -> None:
    for errors in (np.zeros(3), np.zeros((0, 3)), np.zeros((3, 0))):
        with pytest.raises(ConfigError, match="wanted"):
            ErrorHistogram.from_errors(errors)
    with pytest.raises(ConfigError, match="before"):
        ErrorHistogram.from_errors(np.zeros((2, 2)), before=np.zeros((2, 2)))
    with pytest.raises(ConfigError, match="tolerance"):
        ProbabilityWithin(-0.1)

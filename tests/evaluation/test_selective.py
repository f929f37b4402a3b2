"""What a confidence is worth: laws of areas, groups and calibration."""

import numpy as np
import pytest

from viewgain.errors import DataError
from viewgain.evaluation import selective, selective_markdown, wilson
from viewgain.evaluation._selective import Selective, bins_of, calibration_error


def of(sure: np.ndarray, good: np.ndarray, margin: np.ndarray | None = None) -> Selective:
    other = np.zeros(len(sure)) if margin is None else margin
    return selective(sure, other, good, 1 - good, np.full(len(good), 0.1), rng=np.random.default_rng(0))


def test_a_confidence_that_knows_reaches_the_truth_and_one_that_does_not_is_random() -> None:
    good = np.array([1.0, 1, 0, 1, 0, 1, 1, 1])
    knowing = of(0.1 + 0.8 * good, good, margin=-good)
    assert knowing.area.value == pytest.approx(knowing.area_by_truth)
    assert knowing.area_by_margin.value > knowing.area_at_random == 0.25
    assert knowing.gain.value == pytest.approx(knowing.area_at_random - knowing.area.value)
    assert knowing.curve == knowing.curve_by_truth
    assert knowing.curve[-1] == knowing.curve_by_margin[-1] == 0.25
    assert [each.nearly for each in knowing.kept] == pytest.approx([1, 1, 0.75, 0.75])
    assert [each.least for each in knowing.kept] == pytest.approx([0.9, 0.9, 0.1, 0.1])
    assert of(np.full(8, 0.7), good).area.value == pytest.approx(0.25)


@pytest.mark.parametrize("seed", range(3))
def test_the_order_of_decisions_changes_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sure = rng.random(40)
    good = (rng.random(40) < sure).astype(float)
    order = rng.permutation(40)
    one, other = of(sure, good), of(sure[order], good[order])
    assert other.area.value == pytest.approx(one.area.value)
    assert other.calibration_error.value == pytest.approx(one.calibration_error.value)
    assert np.array(other.curve) == pytest.approx(np.array(one.curve))
    assert one.area_by_truth <= one.area.value


def test_groups_hold_all_decisions_and_an_honest_confidence_errs_as_luck_has_it() -> None:
    rng = np.random.default_rng(1)
    sure = rng.uniform(0.2, 1, 1000)
    good = (rng.random(1000) < sure).astype(float)
    groups = bins_of(sure, good)
    assert sum(each.count for each in groups) == 1000
    assert all(each.low <= each.found <= each.high for each in groups)
    assert [each.said for each in groups] == sorted(each.said for each in groups)
    honest, boasting = of(sure, good), of(np.minimum(sure + 0.3, 1), good)
    assert honest.calibration_error.value < 3 * honest.by_chance
    assert boasting.calibration_error.value > 5 * boasting.by_chance
    assert calibration_error([0.25] * 4, [1.0, 0, 0, 0], bins=1) == 0
    by_groups = [each.count * abs(each.said - each.found) for each in groups]
    assert calibration_error(sure, good) == pytest.approx(sum(by_groups) / 1000)


def test_few_decisions_are_groups_of_their_own_and_none_are_refused() -> None:
    assert len(bins_of([0.5, 0.6], [1.0, 0.0])) == 2
    with pytest.raises(DataError, match="risk: got"):
        of(np.zeros(0), np.zeros(0))


def test_the_words_have_a_row_per_share_and_policy() -> None:
    worth = of(np.array([0.9, 0.2, 0.7]), np.array([1.0, 0, 1]))
    lines = selective_markdown({"wise": worth})
    assert "| wise | 50% | 0.70 | 100.0 | 0.00 | 10.00 | 0.00 |" in lines
    assert "| wise | 20 : 0 (1) | 70 : 100 (1) | 90 : 100 (1) |" in lines
    assert selective_markdown({}) == []


def test_the_interval_of_a_share_holds_it() -> None:
    assert wilson(0, 0) == (0.0, 1.0)
    for hits in range(6):
        low, high = wilson(hits, 5)
        assert 0 <= low <= hits / 5 <= high <= 1

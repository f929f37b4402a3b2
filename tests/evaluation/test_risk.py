"""Risk by the share of decisions that are kept."""

import numpy as np
import pytest

from viewgain.errors import DataError
from viewgain.evaluation import risk_coverage, risks_at


def test_the_surest_are_kept_first() -> None:
    share, risk = risk_coverage([0.9, 0.1, 0.5, 0.7], [0.0, 1.0, 0.4, 0.2])
    assert share.tolist() == [0.25, 0.5, 0.75, 1.0]
    assert risk == pytest.approx([0.0, 0.1, 0.2, 0.4])


@pytest.mark.parametrize("seed", range(5))
def test_all_decisions_have_the_mean_risk_whatever_the_confidence_and_order(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sure, lost = rng.integers(0, 4, 30).astype(float), rng.random(30)
    risk = risk_coverage(sure, lost)[1]
    order = rng.permutation(30)
    assert risk_coverage(sure[order], lost[order])[1] == pytest.approx(risk)
    assert risk[-1] == pytest.approx(lost.mean())
    perfect = risk_coverage(-lost, lost)[1]
    assert np.all(np.diff(perfect) >= -1e-12)
    assert np.all(perfect <= risk + 1e-12)


def test_one_confidence_for_all_says_nothing() -> None:
    assert risk_coverage([1.0] * 4, [0.0, 1.0, 0.0, 1.0])[1].tolist() == [0.5] * 4


def test_shares_are_rounded_up_to_decisions() -> None:
    sure, lost = [5.0, 4, 3, 2, 1], [0.0, 0.1, 0.2, 0.3, 0.4]
    assert risks_at(sure, lost, (0.01, 0.4, 0.5, 1.0)) == pytest.approx((0.0, 0.05, 0.1, 0.2))


@pytest.mark.parametrize(("sure", "lost"), [([], []), ([1.0], [1.0, 2.0]), ([np.nan], [1.0])])
def test_no_decisions_are_refused(sure: list[float], lost: list[float]) -> None:
    with pytest.raises(DataError, match="risk: got"):
        risk_coverage(sure, lost)

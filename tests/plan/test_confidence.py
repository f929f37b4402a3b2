"""The confidence of a decision for the volume: laws of the chance, of what is known of a decision, and of the fit."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import expit, logit

from benchmarks._logistic import logistic
from benchmarks.confidence import Decision, Evidence, fitted, out_of_fold
from viewgain.errors import ConfigError, ModelError
from viewgain.evaluation import VolumeRun, VolumeSettings, selective
from viewgain.plan import (
    NEARLY,
    NUMBERS,
    Confidence,
    Opinions,
    RandomPolicy,
    VolumeJudge,
    _confidence,
    chance_of_nearly_best,
    decision_numbers,
    next_view,
)
from viewgain.plan._confidence import confidence_from, shipped_confidence
from viewgain.plan._nearly_best import SCATTER
from viewgain.scans import Scan

errors = st.lists(st.floats(0.002, 0.998), min_size=2, max_size=7).map(np.array)
COUNT = len(NUMBERS)
NOWHERE = Scan(points=np.tile([0.0, 0.0, 1.0], (100, 1)), source="nowhere")


def some_opinions(values: np.ndarray, seed: int = 0, trust: float = 0.5) -> Opinions:
    rng = np.random.default_rng(seed)
    blurred = expit(logit(values) + rng.normal(0, 0.5, len(values)))
    return Opinions(values, blurred, trust, np.ones(len(values), dtype=bool))


@settings(max_examples=40)
@given(errors, st.integers(0, 6), st.integers(0, 1000))
def test_the_chance_is_one_and_does_not_see_the_order_of_candidates(values: np.ndarray, chosen: int, seed: int) -> None:
    chosen %= len(values)
    allowed = np.ones(len(values), dtype=bool)
    chance = chance_of_nearly_best(values, allowed, chosen)
    assert 0 <= chance <= 1
    order = np.random.default_rng(seed).permutation(len(values))
    assert chance_of_nearly_best(values[order], allowed, int(np.argmax(order == chosen))) == pytest.approx(chance, abs=1e-9)
    better = values.copy()
    better[chosen] /= 2
    assert chance_of_nearly_best(better, allowed, chosen) >= chance - 1e-12
    more = np.append(values, 0.3)
    assert chance_of_nearly_best(more, np.append(allowed, True), chosen) <= chance + 1e-12
    assert chance_of_nearly_best(more, np.append(allowed, False), chosen) == chance


def test_the_chance_is_the_share_of_a_count_over_draws() -> None:
    values, draws = np.array([0.05, 0.04, 0.3, 0.08]), 200_000
    worth = expit(logit(values) + SCATTER * np.random.default_rng(0).standard_normal((draws, 4)))
    for chosen in range(4):
        counted = np.mean(worth[:, chosen] <= worth.min(axis=1) + NEARLY)
        assert chance_of_nearly_best(values, np.ones(4, dtype=bool), chosen) == pytest.approx(counted, abs=5e-3)  # draws and rule


def test_near_ties_are_safe_where_errors_are_small_and_doubtful_where_they_are_not() -> None:
    everywhere = np.ones(5, dtype=bool)
    assert chance_of_nearly_best(np.full(5, 0.005), everywhere, 0) > 0.9
    assert chance_of_nearly_best(np.full(5, 0.3), everywhere, 0) < 0.4
    assert chance_of_nearly_best(np.array([0.3, 0.99]), np.array([True, False]), 0) == 1


def test_a_choice_that_cannot_be_made_is_refused() -> None:
    with pytest.raises(ConfigError, match="candidate 1"):
        chance_of_nearly_best(np.array([0.1, 0.2]), np.array([True, False]), 1)
    with pytest.raises(ConfigError, match="candidate 0"):
        chance_of_nearly_best(np.array([0.1, np.nan]), np.ones(2, dtype=bool), 0)
    with pytest.raises(ConfigError, match="opinions: got"):
        Opinions(np.zeros(2), np.zeros(3), 0.5, np.ones(2, dtype=bool))


@settings(max_examples=25)
@given(errors, st.integers(0, 6), st.integers(0, 1000), st.sampled_from([0.0, 0.5, 1.0]))
def test_what_is_known_of_a_decision_does_not_see_the_order_of_candidates(
    values: np.ndarray, chosen: int, seed: int, trust: float
) -> None:
    chosen %= len(values)
    held, order = some_opinions(values, seed, trust), np.random.default_rng(seed).permutation(len(values))
    turned = Opinions(held.model[order], held.network[order], trust, held.reachable[order])
    numbers, again = decision_numbers(held, chosen), decision_numbers(turned, int(np.argmax(order == chosen)))
    assert numbers is not None
    assert again == pytest.approx(numbers, abs=1e-6)
    assert 0 <= shipped_confidence().chance(numbers) <= 1


def test_where_one_is_silent_the_other_speaks_and_where_both_are_nothing_is_known() -> None:
    held = some_opinions(np.array([0.05, 0.2, 0.6]))
    silent = np.full(3, np.nan)
    alone = decision_numbers(replace(held, model=silent, trust=0.0), 0)
    assert alone is not None
    assert alone[0] == alone[1]
    other = decision_numbers(replace(held, model=np.array([0.9, 0.1, 0.1]), trust=0.0), 0)
    assert other is not None
    assert np.array_equal(other, alone)
    assert decision_numbers(replace(held, model=silent, network=silent), 0) is None
    assert shipped_confidence().chance(None) == 0


def test_a_judge_stands_by_what_is_likely_enough_and_by_volumes_alone() -> None:
    limits = np.linspace(0, 1, 11)
    stood = [VolumeJudge(NOWHERE, limit).abstention(0.5, 3) is None for limit in limits.tolist()]
    assert stood == (limits <= 0.5).tolist()
    words = VolumeJudge(NOWHERE, 0.9).abstention(0.5, 3)
    assert words is not None
    assert words.startswith("view 3 would be chosen")
    assert words.endswith("2 points of volume error is 0.50, under the 0.90 asked for")
    with pytest.raises(ConfigError, match=r"got 1\.5 to abstain below"):
        VolumeJudge(NOWHERE, 1.5)
    with pytest.raises(ConfigError, match="objective coverage: got a judge"):
        next_view(NOWHERE, objective="coverage", policy=RandomPolicy(np.random.default_rng(0)), judge=VolumeJudge(NOWHERE))


def a_confidence(seed: int = 0) -> Confidence:
    rng = np.random.default_rng(seed)
    return Confidence(rng.normal(size=COUNT), rng.uniform(0.5, 2, COUNT), rng.normal(size=COUNT), 0.3, ("made up",))


def test_it_comes_back_from_json() -> None:
    again = confidence_from(json.loads(json.dumps(a_confidence().to_dict())))
    numbers = np.linspace(-1, 1, COUNT)
    assert again.chance(numbers) == a_confidence().chance(numbers)
    assert again.fitted_to == ("made up",)


@pytest.mark.parametrize("content", ["", "{}", '{"numbers": ["age"]}', json.dumps({**a_confidence().to_dict(), "mean": [1.0]})])
def test_a_broken_file_says_so(content: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    file = tmp_path / "confidence.json"
    file.write_text(content)
    monkeypatch.setattr(_confidence, "FILE", file)
    shipped_confidence.cache_clear()
    with pytest.raises(ModelError, match="broken"):
        shipped_confidence()
    monkeypatch.undo()
    shipped_confidence.cache_clear()


def made_up(count: int, seed: int) -> tuple[list[Decision], np.ndarray]:
    """Return decisions that come out well as a made-up confidence says, and these chances."""
    rng = np.random.default_rng(seed)
    truth = a_confidence(5)
    numbers = truth.mean + truth.scale * rng.normal(size=(count, COUNT)).clip(-3, 3)
    chances = np.array([truth.chance(each) for each in numbers])
    found = (rng.random(count) < chances).astype(float)
    rows = zip(numbers, found, strict=True)
    return [Decision((0, place), "anyone", known, float(hit)) for place, (known, hit) in enumerate(rows)], chances


def test_the_fit_recovers_made_up_coefficients() -> None:
    rng = np.random.default_rng(3)
    weights, bias, inputs = np.array([1.5, -0.7, 0.0]), 0.4, rng.normal(size=(20_000, 3))
    chances = expit(inputs @ weights + bias)
    found, known = logistic(inputs, chances, 1e-6)  # told the chances themselves, nothing is left to luck
    assert found == pytest.approx(weights, abs=1e-4)
    assert known == pytest.approx(bias, abs=1e-4)
    drawn, offset = logistic(inputs, (rng.random(20_000) < chances).astype(float), 1.0)
    assert drawn == pytest.approx(weights, abs=0.08)  # four standard errors of about 0.02
    assert offset == pytest.approx(bias, abs=0.08)


def test_the_fit_holds_back_where_everything_could_be_told_apart() -> None:
    inputs = np.array([[-1.0], [-0.5], [0.5], [1.0]])
    loose, tight = (logistic(inputs, np.array([0.0, 0.0, 1.0, 1.0]), ridge)[0][0] for ridge in (0.1, 10.0))
    assert 0 < tight < loose < 20


def test_it_is_calibrated_on_decisions_that_it_was_not_fitted_to() -> None:
    learned, chances = fitted(made_up(4000, 1)[0], ("made up",)), made_up(2000, 2)
    decisions, true = chances
    said = np.array([learned.chance(each.numbers) for each in decisions])
    assert np.abs(said - true).mean() < 0.03
    found = np.array([each.found for each in decisions])
    worth = selective(said, np.zeros(2000), found, 1 - found, np.zeros(2000), rng=np.random.default_rng(0))
    assert worth.calibration_error.value < 0.04  # five groups of 400: a share is known to 0.025 at most
    assert worth.gain.low > 0


def test_no_decision_is_told_what_came_of_its_own_box() -> None:
    decisions = made_up(40, 4)[0]
    reach = np.ones(2, dtype=bool)
    runs = [
        VolumeRun(number=n, size=(1, 1, 1), present=0, reachable=reach, errors=np.zeros((2, 4)), choices={}, milliseconds={})
        for n in range(40)
    ]
    folders = [Evidence(VolumeSettings(), runs)]
    said = out_of_fold(decisions, folders)
    turned = [replace(decisions[0], found=1 - decisions[0].found), *decisions[1:]]
    again = out_of_fold(turned, folders)
    assert again[0, 0, "anyone"] == said[0, 0, "anyone"]
    assert any(again[key] != value for key, value in said.items())

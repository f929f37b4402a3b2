"""Scores of positions and decisions about them: laws, and the slow twins."""

import numpy as np
import pytest

from tests.oracles import positions as slow
from viewgain.errors import DataError
from viewgain.evaluation import (
    PositionScores,
    agreement,
    best_positions,
    constant_choices,
    guessed,
    judged,
    position_scores,
    ratio,
    worth,
)


def random_errors(rng: np.random.Generator, views: int = 5, scans: int = 12) -> np.ndarray:
    errors = rng.normal(rng.uniform(-0.2, 0.2, (views, 1)), rng.uniform(0.01, 0.3, (views, 1)), (views, scans))
    errors[rng.random(errors.shape) < 0.1] = np.nan
    return errors


def random_allowed(rng: np.random.Generator, views: int = 5) -> np.ndarray:
    allowed = rng.random(views) < 0.7
    allowed[rng.integers(views)] = True
    return allowed


def random_scores(seed: int, boxes: int = 12) -> list[PositionScores]:
    rng = np.random.default_rng(seed)
    return [position_scores(random_errors(rng), random_allowed(rng)) for _ in range(boxes)]


@pytest.mark.parametrize("seed", range(20))
def test_scores_and_best_positions_are_those_of_plain_loops(seed: int) -> None:
    rng = np.random.default_rng(seed)
    errors, allowed = random_errors(rng), random_allowed(rng)
    scores = position_scores(errors, allowed)
    for place in np.flatnonzero(allowed).tolist():
        assert (scores.mean[place], scores.error[place]) == pytest.approx(slow.mean_and_error(errors[place].tolist()))
    assert np.flatnonzero(best_positions(scores)).tolist() == slow.best(errors, allowed.tolist())


@pytest.mark.parametrize("seed", range(10))
def test_more_scans_that_say_the_same_leave_no_more_best_positions(seed: int) -> None:
    errors = random_errors(np.random.default_rng(seed))
    few, many = (position_scores(each, np.ones(5)) for each in (errors, np.tile(errors, 50)))
    assert few.mean == pytest.approx(many.mean)
    assert not np.any(best_positions(many) & ~best_positions(few))
    assert best_positions(many)[few.least]


def test_positions_that_all_miss_are_all_best_and_a_sure_difference_is_seen() -> None:
    assert best_positions(position_scores(np.full((3, 4), np.nan), np.ones(3))).all()
    clear = position_scores(np.array([[0.1] * 4, [0.11] * 4]), np.ones(2))
    assert best_positions(clear).tolist() == [True, False]


def test_what_cannot_be_reached_counts_nowhere() -> None:
    errors = np.array([[0.0, 0.0], [0.5, 0.4], [0.6, 0.9]])
    scores = position_scores(errors, [False, True, True])
    assert scores.least == 1
    assert not best_positions(scores)[0]
    with pytest.raises(DataError, match="one allowed position of each"):
        judged([scores], [0])


@pytest.mark.parametrize(
    ("errors", "allowed"), [(np.zeros((3, 0)), np.ones(3)), (np.zeros((3, 2)), np.zeros(3)), (np.zeros(3), [1])]
)
def test_nothing_to_score_is_an_error(errors: np.ndarray, allowed: np.ndarray) -> None:
    with pytest.raises(DataError, match="one of each"):
        position_scores(errors, allowed)


def test_a_uniform_guess_is_the_mean_over_all_choices() -> None:
    scores = random_scores(1)
    rows = guessed(scores)
    rng = np.random.default_rng(2)
    drawn = [judged(scores, [int(rng.choice(np.flatnonzero(box.allowed))) for box in scores]) for _ in range(4000)]
    assert rows == pytest.approx(np.mean(drawn, axis=0), abs=0.05)
    for row, box in zip(rows, scores, strict=True):
        assert row == pytest.approx(np.mean(worth(box)[box.allowed], axis=0))


@pytest.mark.parametrize("seed", range(8))
def test_the_constant_answer_is_chosen_on_the_other_boxes(seed: int) -> None:
    scores = random_scores(seed)
    means, rng = np.stack([box.mean for box in scores]), np.random.default_rng(seed)
    for shifts in ([0] * len(scores), rng.integers(5, size=len(scores)).tolist()):
        start = None if not any(shifts) else shifts
        assert constant_choices(scores, start).tolist() == [slow.constant(means, box, shifts) for box in range(len(scores))]


def test_the_constant_answer_for_a_box_does_not_depend_on_that_box() -> None:
    rng = np.random.default_rng(5)
    everywhere = np.ones(4)
    scores = [position_scores(random_errors(rng, views=4), everywhere) for _ in range(6)]
    before = constant_choices(scores)[2]
    changed = [*scores[:2], position_scores(random_errors(rng, views=4), everywhere), *scores[3:]]
    assert constant_choices(changed)[2] == before
    with pytest.raises(DataError, match="2 or more"):
        constant_choices(scores[:1])


def test_halves_agree_with_themselves_and_the_oracle_is_held_to_the_other_half() -> None:
    scores = random_scores(3)
    for box in scores:
        assert agreement(box, box) == (1.0, 1.0)
    near, far = position_scores([[0.1] * 3, [0.9] * 3], [1, 1]), position_scores([[0.9] * 3, [0.1] * 3], [1, 1])
    assert agreement(near, far) == (0.0, 0.0)
    noisy = position_scores([[0.0, 0.8, 0.0, 0.8], [0.44] * 4], [1, 1])
    sure = position_scores([[0.5] * 4, [0.4] * 4], [1, 1])
    # The noisy half names the first position, which the sure one can tell from the best; the other way round nothing can be told.
    assert agreement(noisy, sure) == agreement(sure, noisy) == (0.5, 0.0)


def test_the_least_position_is_best_and_nearly_best() -> None:
    scores = random_scores(4)
    rows = judged(scores, [box.least for box in scores])
    assert rows[:, :2].tolist() == [[1.0, 1.0]] * len(scores)
    assert rows[:, 2] == pytest.approx([np.nanmin(box.mean) for box in scores])


def test_ratios_are_of_means_and_their_intervals_hold_them() -> None:
    rng = np.random.default_rng(0)
    above, below = rng.uniform(1, 2, 40), rng.uniform(0.5, 1, 40)
    found = ratio(above, below, rng=rng)
    assert found.value == pytest.approx(above.sum() / below.sum())
    assert found.low < found.value < found.high
    same = ratio(above, above, rng=rng)
    assert (same.value, same.low, same.high) == pytest.approx((1, 1, 1))
    assert ratio([0.0, 0.0], [0.0, 0.0], rng=rng).value == 1.0
    assert ratio([1.0, 1.0], [0.0, 0.0], rng=rng).value == np.inf
    with pytest.raises(DataError, match="no boxes"):
        ratio([], [], rng=rng)

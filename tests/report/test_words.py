"""Sentences and numbers: nothing is unexplained, nothing is -0, nothing claims to be certain."""

from dataclasses import replace

import pytest

from viewgain.episodes import Episode
from viewgain.measure import REASONS
from viewgain.report import _words as words
from viewgain.report._units import MILLIMETRES, percent, probability, signed_percent, volume_unit


def test_every_reason_is_a_clause_and_its_advice_a_sentence() -> None:
    for reason in [*REASONS, *words.NO_PLAN]:
        clause = words.reason_in_words(reason)
        assert clause
        assert clause[-1] not in ".?;"
        advice = words.advice(reason)
        assert advice is None or (advice[0].isupper() and advice[-1] in ".?")
    assert words.advice("cut_by_border") == "Move back."
    assert words.advice(None) is None


def test_every_flag_is_explained(episode: Episode) -> None:
    assert set(words.FLAGS) == {"cut", "open", "grazing", "bent", "few_points", "touching", "flaps", "ambiguous", "stacked"}
    assert all(text.endswith(".") for text in words.FLAGS.values())


def test_the_end_is_explained(episode: Episode, blob: Episode, empty: Episode) -> None:
    assert "known as well as asked for" in words.why_it_ended(episode)
    assert words.why_it_ended(blob) == "the limit of 1 view was reached before the volume was certain"
    assert words.why_it_ended(empty) == "nothing stands on the floor"


def test_the_winner_is_compared_with_its_rivals(episode: Episode) -> None:
    plan, litres = episode.steps[0].plan, volume_unit(0.03)
    scores = {0: 0.20, 1: 0.30, 2: 0.305}

    def decided(best: int, reachable: set[int]) -> str:
        candidates = tuple(
            replace(c, reachable=c.index in reachable, assessment=replace(c.assessment, score=scores[c.index]))
            for c in plan.candidates[:3]
        )
        return words.decision_sentence(replace(plan, candidates=candidates, best=best), litres, moved=True)

    assert "the most of all that can be reached." in decided(2, {0, 1, 2})
    assert "within one point of the best and the shortest way." in decided(1, {0, 1, 2})
    assert "the most of all that can be reached (1 better one is out of reach)." in decided(1, {0, 1})
    assert "30.0 % less" in decided(1, {0, 1})
    assert "Candidate 1 wins (move 45 degrees to the right" in decided(1, {0, 1})


def test_a_view_that_teaches_nothing_is_not_said_to_help(episode: Episode) -> None:
    plan = episode.steps[0].plan
    worse = tuple(replace(c, assessment=replace(c.assessment, score=-0.01)) for c in plan.candidates)
    text = words.decision_sentence(replace(plan, candidates=worse, best=0), volume_unit(0.03), moved=False)
    assert "Candidate 0 would be next" in text
    assert "leaves the standard deviation" in text
    assert "less" not in text


def test_going_on_after_the_stop_rule_is_said(episode: Episode) -> None:
    plan = episode.steps[-1].plan
    assert words.stop_sentence(plan, moved=False).endswith("no further view is needed.")
    assert words.stop_sentence(plan, moved=True).endswith("no further view was needed, but this run went on.")


VOLUMES = [(0.0186239, "litres", "18.62"), (0.00095, "litres", "0.9500"), (0.12, "litres", "120.0"), (1.5, "m³", "1.500")]


@pytest.mark.parametrize(("volume", "name", "text"), VOLUMES)
def test_volumes_have_four_digits(volume: float, name: str, text: str) -> None:
    unit = volume_unit(volume)
    assert (unit.name, unit.number(volume)) == (name, text)
    assert unit.finer().digits == unit.digits + 1


def test_numbers_have_true_signs() -> None:
    assert MILLIMETRES.signed(-0.0012) == "−1.2"
    assert MILLIMETRES.signed(0.0012) == "+1.2"
    assert MILLIMETRES.signed(-0.00001) == "0.0"
    assert signed_percent(-0.0123) == "−1.2 %"
    assert percent(0.5, 0) == "50 %"


def test_no_probability_is_certain() -> None:
    assert [probability(p) for p in (None, 0.0, 0.5, 0.99995, 1.0)] == ["–", "< 0.001", "0.500", "> 0.999", "> 0.999"]

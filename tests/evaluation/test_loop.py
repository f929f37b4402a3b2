"""The closed loop on boxes from a seed: what is known of scans, who needs how many views, and that nothing else plays a part."""

from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest

from viewgain.errors import ConfigError, DataError
from viewgain.evaluation import (
    LOOP_POLICIES,
    Loop,
    LoopPlay,
    LoopSettings,
    VolumeSettings,
    check_loop_policies,
    loop_markdown,
    loop_play,
    loop_table,
)
from viewgain.evaluation._loop_play import _settled
from viewgain.gain import measured_scan
from viewgain.measure import fuse_measurements
from viewgain.plan import CovariancePolicy, OnBelief, Seen, next_view

SETTINGS = LoopSettings(
    boxes=VolumeSettings(seed=4, rig="ring3", fused=True, side=(0.15, 0.4)), most_views=3, tolerance=0.02, confidence=0.9
)
BOXES = (0, 1)


@pytest.fixture(scope="module")
def loops() -> list[Loop]:
    return [Loop(SETTINGS, number) for number in BOXES]


@pytest.fixture(scope="module")
def plays(loops: list[Loop]) -> list[dict[str, LoopPlay]]:
    return [{name: loop_play(loop, name) for name in LOOP_POLICIES} for loop in loops]


def needed(views: int | None) -> int:
    return SETTINGS.most_views if views is None else views


def test_what_scans_say_together_is_what_fusing_and_planning_say(loops: list[Loop]) -> None:
    for loop, order in zip(loops, ((-1, 0), (0, -1)), strict=True):
        first, second = sorted(loop.reachable[k] for k in order)
        scans = [measured_scan(loop.case.scans, *each) for each in ((first, 0), (second, 0))]
        fused = fuse_measurements([scan for scan in scans if scan is not None])
        known = loop.known(tuple(loop.reachable[k] for k in order))
        volume = fused.boxes[0].volume if fused.boxes and not any(fused.boxes[0].is_open) else 0.0
        assert known.error == pytest.approx(min(abs(volume / loop.case.box.volume - 1), 1))
        plan = next_view(fused, "ring3", camera=loop.case.camera, tolerance=0.02, confidence=0.9)
        assert (known.enough, known.chance) == (plan.stop, pytest.approx(plan.within_tolerance or 0.0))


def test_the_same_scans_for_all_whoever_played_before(loops: list[Loop], plays: list[dict[str, LoopPlay]]) -> None:
    afresh = Loop(SETTINGS, 1)
    for name in ("random", "expected"):
        assert loop_play(afresh, name) == plays[1][name]
    for loop, by_name in zip(loops, plays, strict=True):
        played = [play for name, play in by_name.items() if name != "oracle"]
        assert {(play.positions[0], play.errors[0]) for play in played} == {(loop.case.present, loop.known(loop.start).error)}
        for play in played:
            assert [loop.known(play.positions[:k]).error for k in (1, 2, 3)] == list(play.errors)
            assert set(play.positions) <= set(loop.reachable)
    assert loops[0].seen((0, 1, 0)).scans[1] is loops[0].seen((2, 1)).scans[1]
    assert loops[0].seen((0, 1, 0)).scans[0] is not loops[0].seen((0, 1, 0)).scans[2]


def test_the_oracle_needs_as_few_views_as_any_order_of_positions(loops: list[Loop], plays: list[dict[str, LoopPlay]]) -> None:
    for loop, by_name in zip(loops, plays, strict=True):
        oracle = by_name["oracle"]
        paths = [(*loop.start, *rest) for count in range(3) for rest in product(loop.reachable, repeat=count)]
        stops = [path for path in paths if loop.known(path).enough]
        assert oracle.stopped == min(map(len, stops), default=None)
        assert oracle.within == min((len(path) for path in paths if loop.known(path).error <= 0.02), default=None)
        last = [path for path in (stops or paths) if len(path) == needed(oracle.stopped)]
        assert oracle.final == min(loop.known(path).error for path in last)
        for play in by_name.values():
            assert needed(oracle.stopped) <= needed(play.stopped)
            assert needed(oracle.within) <= needed(play.within)


def test_floors_and_the_greedy_one_go_where_they_say(loops: list[Loop], plays: list[dict[str, LoopPlay]]) -> None:
    for loop, by_name in zip(loops, plays, strict=True):
        around = by_name["ring"].positions
        assert all(b == min((p for p in loop.reachable if p > a), default=loop.reachable[0]) for a, b in pairwise(around))
        greedy = by_name["greedy"]
        for views in (1, 2):
            assert greedy.errors[views] == min(loop.known((*greedy.positions[:views], p)).error for p in loop.reachable)


def test_a_policy_about_a_box_answers_alike_by_what_is_measured_already(loops: list[Loop]) -> None:
    loop, policy = loops[0], OnBelief(CovariancePolicy((0.003, 0.005)), loops[0].case.camera)
    alone = loop.seen(loop.start)
    assert policy.scores(alone) == pytest.approx(policy.scores(replace(alone, measured=None)), abs=1e-9)
    both = loop.seen(tuple(sorted(loop.reachable[:2], reverse=True)))  # the present camera is not the last in rig order
    assert policy.scores(both) == pytest.approx(policy.scores(replace(both, measured=None)), abs=1e-9)


def test_without_an_opinion_the_next_position_around_is_taken(loops: list[Loop], monkeypatch: pytest.MonkeyPatch) -> None:
    def silent(policy: object, seen: Seen) -> np.ndarray:
        return np.full(len(seen.candidates), np.nan)

    monkeypatch.setattr(OnBelief, "scores", silent)
    play = loop_play(loops[0], "covariance")
    assert play == replace(loop_play(loops[0], "ring"), undecided=2)


@pytest.mark.parametrize(
    ("errors", "views"), [((0.01, 0.01), 1), ((0.5, 0.01), 2), ((0.01, 0.5, 0.02), 3), ((0.01, 0.5), None), ((0.5,), None)]
)
def test_within_the_tolerance_means_to_stay_there(errors: tuple[float, ...], views: int | None) -> None:
    assert _settled(errors, 0.02) == views


def made_up(errors: tuple[float, ...], stopped: int | None) -> LoopPlay:
    final = errors[(stopped or 3) - 1]
    return LoopPlay(
        positions=(0, 1, 2), errors=errors, chances=(0.5, 0.9, 0.99), stopped=stopped, within=_settled(errors, 0.02), final=final
    )


def test_the_rows_say_what_came_of_the_boxes() -> None:
    oracle = LoopPlay(positions=(0,), errors=(), chances=(), stopped=1, within=1, final=0.01)
    boxes = [
        {"wise": made_up((0.1, 0.01, 0.01), 2), "random": made_up((0.1, 0.05, 0.01), 3), "oracle": oracle},
        {"wise": made_up((0.2, 0.04, 0.03), 2), "random": made_up((0.2, 0.9, 1.0), None), "oracle": replace(oracle, stopped=2)},
    ]
    table = loop_table(SETTINGS, boxes, ("wise", "random", "oracle"))
    wise, random, best = table.rows
    assert wise.means.mean == pytest.approx((2.0, 0.0, 2.5, 0.5, 0.025))
    assert random.means.mean == pytest.approx((3.0, 0.5, 3.0, 0.5, 0.505))
    assert wise.within_when_stopped is not None
    assert random.within_when_stopped is not None
    assert (wise.within_when_stopped.mean, random.within_when_stopped.mean) == ((0.5,), (1.0,))
    assert wise.to_oracle is not None
    assert wise.to_oracle.value == pytest.approx(2 / 1.5)
    assert wise.to_oracle_within is not None
    assert wise.to_oracle_within.value == pytest.approx(2.5)
    assert wise.less_random is not None
    assert wise.less_random.mean == pytest.approx((-1.0, -0.5, -0.48))
    assert wise.median_error.mean == pytest.approx((0.025,))
    assert wise.errors is not None
    assert wise.errors.mean == pytest.approx((0.15, 0.025, 0.02))
    assert best.errors is None
    assert {row.name: row for row in loop_table(SETTINGS, boxes, ("oracle", "random", "wise")).rows} == {
        row.name: row for row in table.rows
    }
    text = loop_markdown(table)
    assert "| wise | 2.00 (2.00 to 2.00) | 1.33 (" in text
    assert "| wise | -1.00 (-1.00 to -1.00) | -0.50 (" in text
    assert "| oracle | 1.50 (1.00 to 2.00) | 1.00 (1.00 to 1.00) |" in text
    alone = loop_table(SETTINGS, boxes, ("wise",)).rows[0]
    assert (alone.means, alone.to_oracle, alone.less_random) == (wise.means, None, None)
    with pytest.raises(DataError, match="2 or more"):
        loop_table(SETTINGS, boxes[:1], ("wise",))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"boxes": VolumeSettings()}, "fused=True"),
        ({"most_views": 1}, "1 views at most"),
        ({"tolerance": 0.0}, "tolerance 0.0"),
        ({"confidence": 1.0}, "confidence 1.0"),
    ],
)
def test_settings_that_make_no_sense_are_refused(change: dict[str, object], words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        replace(SETTINGS, **change)  # type: ignore[arg-type]


def test_unknown_policies_are_refused() -> None:
    check_loop_policies(("ring", "network:some.onnx"))
    for names in (("constant",), ("network:",), ("ring", "ring"), ()):
        with pytest.raises(ConfigError, match="polic"):
            check_loop_policies(names)

"""What came of a box in the closed loop: by a policy, or by whoever knows the truth and every scan to come."""

from dataclasses import dataclass

import numpy as np

from viewgain.evaluation._loop_case import Loop, Positions
from viewgain.evaluation._loop_policies import FEWEST, chooser


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopPlay:
    """One box and one policy."""

    positions: Positions
    """Where the scans were taken, in order, up to the most views; of the oracle those that it stops with."""
    errors: tuple[float, ...]
    """|V / V* - 1|, at most 1, after each scan; of the oracle none."""
    chances: tuple[float, ...]
    """Probability that the planner gave the error to be within the tolerance, after each scan; of the oracle none."""
    stopped: int | None
    """Views after which the stop rule fired first; None if it never did."""
    within: int | None
    """Views from which on the true error is within the tolerance; None if it is not so in the end. Of the oracle the least number
    of views after which it is so once."""
    final: float
    """True error where the rule fired first, or after all views."""
    undecided: int = 0
    """Choices on which the policy had no opinion."""


def loop_play(loop: Loop, name: str) -> LoopPlay:
    """Return what comes of a box by a policy.

    It plays on after the stop rule has fired, up to the most views. Without an opinion it takes the next position around.

    Raises:
        ModelError: If its network cannot be used.
        ConfigError: If a network of one rig is asked about another.
    """
    if name == FEWEST:
        return _fewest(loop)
    choose_next, positions, undecided = chooser(name, loop), loop.start, 0
    while len(positions) < loop.settings.most_views:
        place = choose_next(positions)
        undecided += place is None
        positions = (*positions, loop.around(positions) if place is None else place)
    steps = [loop.known(positions[:views]) for views in range(1, len(positions) + 1)]
    stopped = next((views for views, step in enumerate(steps, start=1) if step.enough), None)
    errors = tuple(step.error for step in steps)
    return LoopPlay(
        positions=positions,
        errors=errors,
        chances=tuple(step.chance for step in steps),
        stopped=stopped,
        within=_settled(errors, loop.settings.tolerance),
        final=errors[(stopped or len(errors)) - 1],
        undecided=undecided,
    )


def _fewest(loop: Loop) -> LoopPlay:
    """Return the fewest views after which the rule can fire, and the fewest with an error within the tolerance.

    Sets of scans are tried in order of their number, all of each, so no policy can do with fewer. What it stops with is, of the
    sets of that many scans with which the rule fires, the one of least true error; of all of the most views if it never does.
    """
    asked = loop.settings
    sets, stopped, within = [loop.start], None, None
    last = (loop.start, loop.known(loop.start))
    for views in range(1, asked.most_views + 1):
        tried = [(each, loop.known(each)) for each in sets]
        if within is None and any(known.error <= asked.tolerance for _, known in tried):
            within = views
        if stopped is None:
            fired = [each for each in tried if each[1].enough]
            last = min(fired or tried, key=lambda each: each[1].error)
            stopped = views if fired else None
        if stopped is not None and within is not None:
            break
        sets = sorted({tuple(sorted((*each, place))) for each in sets for place in loop.reachable})
    return LoopPlay(positions=last[0], errors=(), chances=(), stopped=stopped, within=within, final=last[1].error)


def _settled(errors: tuple[float, ...], tolerance: float) -> int | None:
    """Return after how many views the errors are within the tolerance and stay there; None if the last one is not."""
    outside = np.flatnonzero(np.array(errors) > tolerance)
    first = int(outside[-1]) + 2 if len(outside) else 1
    return first if first <= len(errors) else None

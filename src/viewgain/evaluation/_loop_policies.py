"""Who may choose in the closed loop: policies of volume, floors, and two that know the truth."""

from collections.abc import Callable

import numpy as np

from viewgain.errors import ConfigError, ScanError
from viewgain.evaluation._loop_case import Loop, Positions
from viewgain.evaluation._volume_choices import DECIDING, FROM_FILE, is_from_file, policy_of
from viewgain.plan import RandomPolicy, ViewPolicy, choose

RANDOM, RING, GREEDY, FEWEST = "random", "ring", "greedy", "oracle"
"""A position drawn anew each time; the next one around; the one with the least true error after it; as few views as possible."""
LOOP_POLICIES = ("covariance", "expected", "farthest", RING, RANDOM, GREEDY, FEWEST)
"""What is compared where nothing is named."""
LOOP_FLOORS = (RANDOM, RING, "farthest", GREEDY)
"""What looks at no scan, and what looks at the truth: floors and ceiling."""
_DRAWS = 0x6C6F
"""Stream of the random policy."""

Chooser = Callable[[Positions], int | None]
"""Gives the next position after some; None without an opinion."""


def check_loop_policies(names: tuple[str, ...]) -> None:
    """Refuse names of policies that are not known, or given twice.

    Raises:
        ConfigError: Saying which.
    """
    known = list(dict.fromkeys([*LOOP_POLICIES, *DECIDING]))
    for name in names:
        if name not in known and not is_from_file(name):
            raise ConfigError(
                f"policy {name!r} is not known; choose from {', '.join([*known, *(f'{kind}:FILE' for kind in FROM_FILE)])}"
            )
    if not names or len(set(names)) < len(names):
        raise ConfigError(f"policies: got {', '.join(names) or 'none'}, wanted at least one, and each once")


def chooser(name: str, loop: Loop) -> Chooser:
    """Return who chooses on a box, by any name but that of the fewest views, which are found by search.

    Raises:
        ModelError: If its network cannot be used.
        ConfigError: If a network of one rig is asked about another.
    """
    if name == RING:
        return loop.around
    if name == GREEDY:
        return lambda positions: min(loop.reachable, key=lambda place: loop.known((*positions, place)).error)
    if name == RANDOM:
        policy: ViewPolicy = RandomPolicy(np.random.default_rng([_DRAWS, loop.case.scans.seed]))
    else:
        policy = policy_of(name, loop.case)
    return lambda positions: _by_scores(policy, loop, positions)


def _by_scores(policy: ViewPolicy, loop: Loop, positions: Positions) -> int | None:
    """Return the reachable position with the highest score, those of earlier scans included."""
    try:
        scores = policy.scores(loop.seen(positions))
    except (ScanError, np.linalg.LinAlgError):  # scans that cannot be measured say nothing
        return None
    place = choose(scores, loop.case.reachable)
    return place if place is not None and np.isfinite(scores[place]) else None

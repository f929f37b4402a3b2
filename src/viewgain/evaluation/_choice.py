"""One decision: a case as far as it goes, where a policy goes from there, and what it knows."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import process_time
from typing import Protocol, TypeVar

import numpy as np

from viewgain.arrays import Mask, Poses
from viewgain.camera import Sensor
from viewgain.plan import FarthestPolicy, Seen, ViewPolicy, choose, forget_predictions, visited_among
from viewgain.rigs import Rig
from viewgain.scans import Scan


@dataclass(frozen=True, slots=True)
class Choice:
    """What a policy says of one box."""

    position: int
    """Where to go; the farthest position in reach where the policy has no opinion."""
    has_opinion: bool
    """Whether it had one."""
    margin: float = 0.0
    """By how much the policy prefers it to the next best position, in the unit of its scores; 0 without an opinion."""


class Question(Protocol):
    """What is asked about every case."""

    @property
    def fused(self) -> bool:
        """Whether a position is worth what its scan and the present one say together."""
        ...

    def stations(self) -> Rig:
        """Return the rig."""
        ...


class DecisionCase(Protocol):
    """A case as far as a decision goes: one scan, and where the camera may go from there."""

    @property
    def settings(self) -> Question:
        """What was asked."""
        ...

    @property
    def camera(self) -> Sensor:
        """The camera as its data sheet has it."""
        ...

    @property
    def stations(self) -> Poses:
        """(V, 4, 4) ``camera_to_world`` of the positions."""
        ...

    @property
    def reachable(self) -> Mask:
        """(V,) where the camera may go."""
        ...

    @property
    def present(self) -> int:
        """Where it stands."""
        ...

    @property
    def seen(self) -> Scan | None:
        """The scan to decide by."""
        ...


C = TypeVar("C", bound=DecisionCase)


def choice(case: DecisionCase, policy: ViewPolicy, seen: Seen | None = None) -> Choice:
    """Return where a policy goes from the scan to decide by; any reachable position may be taken, the present one too.

    Without an opinion the camera leaves: where it stands the scan was good for nothing.

    Args:
        case: What is asked.
        policy: Who decides.
        seen: What it knows, :func:`seen_of` the case where None.
    """
    seen = seen_of(case) if seen is None else seen
    scores = policy.scores(seen)
    place = choose(scores, case.reachable)
    if place is None or not np.isfinite(scores[place]):
        away = choose(FarthestPolicy().scores(seen), case.reachable)
        return Choice(case.present if away is None else away, False)
    others = np.delete(scores, place)[np.delete(case.reachable, place)]
    known = others[np.isfinite(others)]
    return Choice(place, True, float(scores[place] - known.max()) if len(known) else 0.0)


def decisions(
    case: C, names: Sequence[str], policy: Callable[[str, C], ViewPolicy]
) -> tuple[dict[str, Choice], dict[str, float]]:
    """Return what each policy chooses, and the CPU milliseconds that it took, measuring included.

    None finds the predictions of another, so its time does not depend on who else is asked.

    Args:
        case: Who is asked about what.
        names: Of the policies.
        policy: Gives the policy of a name for the case.
    """
    seen = seen_of(case)  # simulating the scan is no part of deciding
    choices: dict[str, Choice] = {}
    spent: dict[str, float] = {}
    for name in names:
        decider = policy(name, case)
        forget_predictions()
        start = process_time()
        choices[name] = choice(case, decider, seen)
        spent[name] = 1e3 * (process_time() - start)
    return choices, spent


def seen_of(case: DecisionCase) -> Seen:
    """Return what a policy knows of a case: one scan, or none where the camera sees next to nothing."""
    scan = case.seen
    stand = case.stations[case.present] if scan is None or scan.camera_to_world is None else scan.camera_to_world
    stands = stand[None]
    return Seen(
        () if scan is None else (scan,),
        stands,
        case.stations,
        visited_among(case.stations, stands),
        case.camera.intrinsics,
    )

"""Which position each policy takes on a fresh box, from one scan of the present one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from viewgain.errors import ConfigError
from viewgain.evaluation._volume_case import VolumeCase
from viewgain.measure import POSE_SIGMA
from viewgain.plan import (
    CovariancePolicy,
    ExpectedErrorPolicy,
    FarthestPolicy,
    OnBelief,
    Seen,
    ViewPolicy,
    choose,
    visited_among,
)

UNIFORM, CONSTANT, OFFSET, ORACLE = "uniform guess", "constant position", "constant offset", "oracle"
"""Rows that need no decision made on a scan."""
FLOORS = {"random": (UNIFORM,), "constant": (CONSTANT, OFFSET), "oracle": (ORACLE,)}
"""The rows that each of these names asks for."""


@dataclass(frozen=True, slots=True)
class Choice:
    """What a policy says of one box."""

    position: int
    """Where to go; the present position where the policy has no opinion."""
    has_opinion: bool
    """Whether it had one."""


Maker = Callable[[VolumeCase], ViewPolicy]
"""Gives the policy that decides on a case."""
DECIDING: Mapping[str, Maker] = {
    "model": lambda case: OnBelief(ExpectedErrorPolicy(fused=case.settings.fused), case.camera),
    "covariance": lambda case: OnBelief(CovariancePolicy(POSE_SIGMA), case.camera),
    "farthest": lambda case: FarthestPolicy(),
}
"""Policies by name, but for networks. ``model`` expects the error that is scored, ``covariance`` the certainty after fusing."""
DEFAULT_POLICIES = ("model", "covariance", "farthest", "constant", "random", "oracle")
"""What is compared where nothing is named."""


def check_policies(names: tuple[str, ...]) -> None:
    """Refuse names of policies that are not known, or given twice.

    Raises:
        ConfigError: Saying which.
    """
    for name in names:
        if name not in DECIDING and name not in FLOORS and not name.startswith("network:"):
            known = ", ".join([*DECIDING, *FLOORS, "network:FILE"])
            raise ConfigError(f"policy {name!r} is not known; choose from {known}")
    if len(set(names)) < len(names):
        raise ConfigError(f"policies: got {', '.join(names)}, wanted each once")


def choice(case: VolumeCase, policy: ViewPolicy) -> Choice:
    """Return where a policy goes from the scan to decide by; any reachable position may be taken, the present one too."""
    seen = seen_of(case)
    scores = policy.scores(seen)
    place = choose(scores, case.reachable)
    if place is None or not np.isfinite(scores[place]):
        return Choice(case.present, False)
    return Choice(place, True)


def seen_of(case: VolumeCase) -> Seen:
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

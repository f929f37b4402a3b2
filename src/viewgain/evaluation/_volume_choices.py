"""Which position each policy takes on a fresh box, from one scan of the present one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from viewgain.arrays import Mask, Poses, Vector
from viewgain.camera import Sensor
from viewgain.errors import ConfigError, ModelError
from viewgain.gain import unrolled
from viewgain.inference import PoseScorer, Scorer
from viewgain.measure import POSE_SIGMA
from viewgain.plan import (
    CombinedPolicy,
    CovariancePolicy,
    ExpectedErrorPolicy,
    FarthestPolicy,
    OnBelief,
    Seen,
    ViewPolicy,
    VolumeNetworkPolicy,
    choose,
    visited_among,
)
from viewgain.rigs import Rig
from viewgain.scans import Scan

UNIFORM, CONSTANT, OFFSET, ORACLE = "uniform guess", "constant position", "constant offset", "oracle"
"""Rows that need no decision made on a scan."""
FLOORS = {"random": (UNIFORM,), "constant": (CONSTANT, OFFSET), "oracle": (ORACLE,)}
"""The rows that each of these names asks for."""


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


Maker = Callable[[DecisionCase], ViewPolicy]
"""Gives the policy that decides on a case."""
DECIDING: Mapping[str, Maker] = {
    "expected": lambda case: _expected(case),
    "covariance": lambda case: OnBelief(CovariancePolicy(POSE_SIGMA), case.camera),
    "farthest": lambda case: FarthestPolicy(),
}
"""Policies by name, but for networks: ``expected`` goes by the expected error, which is what is scored, ``covariance`` by the
certainty after fusing, ``farthest`` by the way from the present position."""
FROM_FILE = {"network": "its scores alone", "combined": "they and minus the expected error, weighted by what is known"}
"""Policies that are named with a file, ``network:FILE.onnx``, and what decides."""


def check_volume_policies(names: tuple[str, ...]) -> None:
    """Refuse names of policies that are not known, or given twice.

    Raises:
        ConfigError: Saying which.
    """
    for name in names:
        if name not in DECIDING and name not in FLOORS and not is_from_file(name):
            known = ", ".join([*DECIDING, *FLOORS, *(f"{kind}:FILE" for kind in FROM_FILE)])
            raise ConfigError(f"policy {name!r} is not known; choose from {known}")
    if len(set(names)) < len(names):
        raise ConfigError(f"policies: got {', '.join(names)}, wanted each once")


def is_from_file(name: str) -> bool:
    """Return whether a policy is named with the file of its network."""
    return name.partition(":")[0] in FROM_FILE and len(name.partition(":")[2]) > 0


def policy_of(name: str, case: DecisionCase) -> ViewPolicy:
    """Return the policy of a name for a case.

    Raises:
        ModelError: If its network cannot be used.
        ConfigError: If a network of one rig is asked about another.
    """
    if name in DECIDING:
        return DECIDING[name](case)
    network = network_of(name, case.settings)
    return CombinedPolicy(_expected(case), network) if name.startswith("combined:") else network


def _expected(case: DecisionCase) -> OnBelief:
    return OnBelief(ExpectedErrorPolicy(fused=case.settings.fused), case.camera)


def network_of(name: str, settings: Question) -> ViewPolicy:
    """Return the policy of the network in a name, ``network:FILE`` or ``combined:FILE``; raises as :func:`policy_of`."""
    return _network_policy(name.partition(":")[2], rig=settings.stations().name)


@lru_cache(maxsize=4)
def _network_policy(file: str, *, rig: str) -> ViewPolicy:
    """Return the policy of a network file: one that is told poses, or one of whole scans with the views of one rig.

    Raises:
        ModelError: If there is no such file, or it is no network for volumes.
        ConfigError: If it is of another rig.
    """
    try:
        return VolumeNetworkPolicy(PoseScorer.load(file))
    except ModelError:
        scorer = Scorer.load(file)
    reason = scorer.refusal(frame="camera", rig=rig)
    if reason or scorer.card.normalisation != "metres":
        raise ConfigError(reason or f"{file}: scores coverage and not volumes; name a network that was trained for volumes")
    if scorer.card.with_view_state:
        raise ConfigError(f"{file}: wants to be told the visited views, and here none was visited; name a network without them")
    return StationNetworkPolicy(scorer)


@dataclass(frozen=True, slots=True, eq=False)
class StationNetworkPolicy:
    """A network with the views of its rig fixed, the present one first, as in the paper. It must know where it stands."""

    scorer: Scorer
    name: str = "network"

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) scores in rig order; NaN where there is no scan or the camera stands near no station."""
        if not seen.scans:
            return np.full(len(seen.candidates), np.nan)
        here = seen.stands[-1, :3, 3]
        present = int(np.argmin(np.linalg.norm(seen.candidates[:, :3, 3] - here, axis=1)))
        return unrolled(self.scorer.scores(seen.scans[-1].points, frame="camera"), present)


def choice(case: DecisionCase, policy: ViewPolicy) -> Choice:
    """Return where a policy goes from the scan to decide by; any reachable position may be taken, the present one too.

    Without an opinion the camera leaves: where it stands the scan was good for nothing.
    """
    seen = seen_of(case)
    scores = policy.scores(seen)
    place = choose(scores, case.reachable)
    if place is None or not np.isfinite(scores[place]):
        away = choose(FarthestPolicy().scores(seen), case.reachable)
        return Choice(case.present if away is None else away, False)
    others = np.delete(scores, place)[np.delete(case.reachable, place)]
    known = others[np.isfinite(others)]
    return Choice(place, True, float(scores[place] - known.max()) if len(known) else 0.0)


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

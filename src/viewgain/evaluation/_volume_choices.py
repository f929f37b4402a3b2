"""Policies by the names that commands have for them."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from viewgain.arrays import Vector
from viewgain.errors import ConfigError, ModelError
from viewgain.evaluation._choice import DecisionCase, Question
from viewgain.evaluation._volume_case import VolumeCase
from viewgain.gain import unrolled, volume_estimator
from viewgain.inference import PoseScorer, Scorer
from viewgain.measure import POSE_SIGMA
from viewgain.plan import (
    AROUND,
    CombinedPolicy,
    CovariancePolicy,
    ExpectedErrorPolicy,
    FarthestPolicy,
    OnBelief,
    RehearsedPolicy,
    Seen,
    ViewPolicy,
    VolumeNetworkPolicy,
)

UNIFORM, CONSTANT, OFFSET, ORACLE = "uniform guess", "constant position", "constant offset", "oracle"
"""Rows that need no decision made on a scan."""
FLOORS: Mapping[str, tuple[str, ...]] = {"random": (UNIFORM,), "constant": (CONSTANT, OFFSET), "oracle": (ORACLE,)}
"""The rows that each of these names asks for."""
INFORMED, OTHER_CAMERAS = "informed", "informed (other cameras)"
"""A name and the row that it asks for: who knows the box and the model of the camera, but not this camera's systematic error."""
VOLUME_FLOORS = {**FLOORS, INFORMED: (OTHER_CAMERAS,)}
"""The same where volumes of boxes are judged."""


Maker = Callable[[DecisionCase], ViewPolicy]
"""Gives the policy that decides on a case."""
DECIDING: Mapping[str, Maker] = {
    "expected": lambda case: _expected(case),
    "expected_around": lambda case: _expected(case, around_of(case.settings)),
    "covariance": lambda case: OnBelief(CovariancePolicy(POSE_SIGMA), case.camera),
    "farthest": lambda case: FarthestPolicy(),
}
"""Policies by name, but for networks: ``expected`` goes by the expected error, which is what is scored, ``expected_around`` too,
and is told that the rig was put up around the box; ``covariance`` goes by the certainty after fusing, ``farthest`` by the way
from the present position."""
VolumeMaker = Callable[[VolumeCase], ViewPolicy]
"""The same on a case of a box."""
REHEARSING: Mapping[str, VolumeMaker] = {
    "rehearsed": lambda case: _rehearsed(case),
    "rehearsed_around": lambda case: _rehearsed(case, around_of(case.settings)),
}
"""Policies that take seconds: ``rehearsed`` goes by the expected error and by scans of the box believed in, simulated and
measured as those that judge it are; ``rehearsed_around`` is told as much as ``expected_around``."""
VOLUME_DECIDING: Mapping[str, VolumeMaker] = {**DECIDING, **REHEARSING}
"""Policies by name where a position is judged by its scans of a box."""
FROM_FILE = ("network", "combined", "combined_around")
"""Policies that are named with a file, ``network:FILE.onnx``: by its scores alone, or with a say for ``expected``
or ``expected_around``."""


def check_volume_policies(names: tuple[str, ...]) -> None:
    """Refuse names of policies that are not known, or given twice.

    Raises:
        ConfigError: Saying which.
    """
    check_policies(names, VOLUME_DECIDING, VOLUME_FLOORS)


def check_policies(names: tuple[str, ...], deciding: Collection[str], floors: Mapping[str, tuple[str, ...]] = FLOORS) -> None:
    """Refuse names that are neither of ``deciding`` nor floors nor networks, or given twice; raises as above."""
    for name in names:
        if name not in deciding and name not in floors and not is_from_file(name):
            known = ", ".join([*deciding, *floors, *(f"{kind}:FILE" for kind in FROM_FILE)])
            raise ConfigError(f"policy {name!r} is not known; choose from {known}")
    if len(set(names)) < len(names):
        raise ConfigError(f"policies: got {', '.join(names)}, wanted each once")


def is_from_file(name: str) -> bool:
    """Return whether a policy is named with the file of its network."""
    return name.partition(":")[0] in FROM_FILE and len(name.partition(":")[2]) > 0


def volume_policy(name: str, case: VolumeCase) -> ViewPolicy:
    """Return the policy of a name for a case of a box; raises as :func:`policy_of`."""
    return VOLUME_DECIDING[name](case) if name in VOLUME_DECIDING else policy_of(name, case)


def policy_of(name: str, case: DecisionCase) -> ViewPolicy:
    """Return the policy of a name for a case.

    Raises:
        ModelError: If its network cannot be used.
        ConfigError: If a network of one rig is asked about another, or a policy is told that a rig stands around a centre which
            does not.
    """
    if name in DECIDING:
        return DECIDING[name](case)
    network = network_of(name, case.settings)
    if name.startswith("network:"):
        return network
    return CombinedPolicy(_expected(case, around_of(case.settings) if is_told(name) else None), network)


def _expected(case: DecisionCase, around: float | None = None) -> OnBelief[ExpectedErrorPolicy]:
    return OnBelief(ExpectedErrorPolicy(fused=case.settings.fused), case.camera, around=around)


def _rehearsed(case: VolumeCase, around: float | None = None) -> OnBelief[RehearsedPolicy]:
    fused = case.settings.fused
    policy = RehearsedPolicy(
        estimator=None if fused else volume_estimator(case.settings.estimator, case.camera),
        fused=fused,
        arrivals=case.arrivals,
        reachable=case.reachable,
        seed=case.number,
    )
    return OnBelief(policy, case.camera, around=around)


def is_told(name: str) -> bool:
    """Return whether a policy is told that the rig was put up around the box."""
    return name.partition(":")[0].endswith("_around")


def around_of(settings: Question) -> float:
    """Return how far the point that the stations look at may be from the centre of what they stand around.

    Raises:
        ConfigError: If they look at something else.
    """
    rig = settings.stations()
    if any(station.corner is not None for station in rig.stations):
        raise ConfigError(
            f"policies named _around: got rig {rig.name}, whose stations look at a corner, wanted one around a"
            " centre; take expected, combined"
        )
    return AROUND


def network_of(name: str, settings: Question) -> ViewPolicy:
    """Return the policy of the network in a name, ``network:FILE``, ``combined:FILE``, ...; raises as :func:`policy_of`."""
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

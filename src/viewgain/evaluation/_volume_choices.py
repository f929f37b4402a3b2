"""Policies by the names that commands have for them."""

from collections.abc import Callable, Collection, Mapping

from viewgain.errors import ConfigError
from viewgain.evaluation._choice import DecisionCase, Question
from viewgain.evaluation._network_choices import kind_and_file, network_of
from viewgain.evaluation._volume_case import VolumeCase
from viewgain.gain import volume_estimator
from viewgain.measure import POSE_SIGMA
from viewgain.plan import (
    AROUND,
    CombinedPolicy,
    CovariancePolicy,
    ExpectedErrorPolicy,
    FarthestPolicy,
    OnBelief,
    RehearsedPolicy,
    ViewPolicy,
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
WithNetwork = Callable[[DecisionCase, ViewPolicy], ViewPolicy]
"""Gives the policy that decides on a case, of which a network is part."""
FROM_FILE: Mapping[str, WithNetwork] = {
    "network": lambda case, network: network,
    "combined": lambda case, network: CombinedPolicy(_expected(case), network),
    "combined_around": lambda case, network: CombinedPolicy(_expected(case, around_of(case.settings)), network),
}
"""Policies that are named with a file, ``network:FILE.onnx``: by its scores alone, or with a say for ``expected``
or ``expected_around``."""
VolumeMaker = Callable[[VolumeCase], ViewPolicy]
"""Gives the policy that decides on a case of a box."""
REHEARSING: Mapping[str, VolumeMaker] = {
    "rehearsed": lambda case: _rehearsed(case),
    "rehearsed_around": lambda case: _rehearsed(case, around_of(case.settings)),
}
"""Policies that take seconds: ``rehearsed`` goes by the expected error and by scans of the box believed in, simulated and
measured as those that judge it are; ``rehearsed_around`` is told as much as ``expected_around``."""
VOLUME_DECIDING: Mapping[str, VolumeMaker] = {**DECIDING, **REHEARSING}
"""Policies by name where a position is judged by its scans of a box."""
VolumeWithNetwork = Callable[[VolumeCase, ViewPolicy], ViewPolicy]
"""Gives the policy that decides on a case of a box, of which a network is part."""
VOLUME_FROM_FILE: Mapping[str, VolumeWithNetwork] = {
    **FROM_FILE,
    "rehearsed": lambda case, network: CombinedPolicy(_rehearsed(case), network, "rehearsed"),
    "rehearsed_around": lambda case, network: CombinedPolicy(_rehearsed(case, around_of(case.settings)), network, "rehearsed"),
}
"""Policies with a file there: a policy that rehearses may leave to a network what nobody can rehearse."""


def check_volume_policies(names: tuple[str, ...]) -> None:
    """Refuse names of policies that are not known, or given twice.

    Raises:
        ConfigError: Saying which.
    """
    check_policies(names, VOLUME_DECIDING, VOLUME_FLOORS, VOLUME_FROM_FILE)


def check_policies(
    names: tuple[str, ...],
    deciding: Collection[str],
    floors: Mapping[str, tuple[str, ...]] = FLOORS,
    from_file: Collection[str] = tuple(FROM_FILE),
) -> None:
    """Refuse names that are neither of ``deciding`` nor floors nor ``from_file``, or given twice; raises as above."""
    for name in names:
        if name not in deciding and name not in floors and not is_from_file(name, from_file):
            known = ", ".join([*deciding, *floors, *(f"{kind}:FILE" for kind in from_file)])
            raise ConfigError(f"policy {name!r} is not known; choose from {known}")
    if len(set(names)) < len(names):
        raise ConfigError(f"policies: got {', '.join(names)}, wanted each once")


def is_from_file(name: str, kinds: Collection[str] = tuple(FROM_FILE)) -> bool:
    """Return whether a policy is one of these kinds, named with the file of its network."""
    kind, file = kind_and_file(name)
    return kind in kinds and len(file) > 0


def is_told(name: str) -> bool:
    """Return whether a policy is told that the rig was put up around the box."""
    return kind_and_file(name)[0].endswith("_around")


def is_rehearsing(name: str) -> bool:
    """Return whether a policy rehearses, with the file of a network or without."""
    return kind_and_file(name)[0] in REHEARSING


def volume_policy(name: str, case: VolumeCase) -> ViewPolicy:
    """Return the policy of a name for a case of a box; raises as :func:`policy_of`."""
    if name in VOLUME_DECIDING:
        return VOLUME_DECIDING[name](case)
    return VOLUME_FROM_FILE[kind_and_file(name)[0]](case, network_of(name, case.settings))


def policy_of(name: str, case: DecisionCase) -> ViewPolicy:
    """Return the policy of a name for a case.

    Raises:
        ModelError: If its network cannot be used.
        ConfigError: If a network of one rig is asked about another, or a policy is told that a rig stands around a centre which
            does not.
    """
    if name in DECIDING:
        return DECIDING[name](case)
    return FROM_FILE[kind_and_file(name)[0]](case, network_of(name, case.settings))


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

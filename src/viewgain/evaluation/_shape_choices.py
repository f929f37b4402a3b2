"""Which position each policy takes for a second view of an object of any shape."""

from collections.abc import Mapping

from viewgain.errors import ConfigError
from viewgain.evaluation._choice import DecisionCase
from viewgain.evaluation._volume_choices import DECIDING, Maker, check_policies, policy_of
from viewgain.gain import VOLUMETRIC
from viewgain.inference import VOLUME_MODEL
from viewgain.plan import AutomaticPolicy, ColumnsPolicy, FarthestPolicy, OnBelief, ViewPolicy, WatchedPolicy

SHAPE_POLICIES = (
    "columns",
    "rear_side_voxel",
    "rear_side_entropy",
    "proximity_count",
    "average_entropy",
    "auto",
    "covariance",
    "expected",
    f"network:{VOLUME_MODEL}",
    f"combined:{VOLUME_MODEL}",
    "farthest",
    "constant",
    "random",
    "oracle",
)
"""What is compared where nothing is named."""
SHAPE_DECIDING: Mapping[str, Maker] = {
    "columns": lambda case: ColumnsPolicy(case.camera),
    **{name: lambda case, metric=metric: WatchedPolicy(metric, case.camera) for name, metric in VOLUMETRIC.items()},  # type: ignore[misc]
    "auto": lambda case: _automatic(case),
    **DECIDING,
}
"""Policies by name, but for networks: ours for any shape, the volumetric ones, and those that take the object for a box."""


def check_shape_policies(names: tuple[str, ...]) -> None:
    """Refuse no name at all, and names of policies that are not known, or given twice.

    Raises:
        ConfigError: Saying which.
    """
    if not names:
        raise ConfigError("policies: got none, wanted at least one, and each once")
    check_policies(names, SHAPE_DECIDING)


def shape_policy(name: str, case: DecisionCase) -> ViewPolicy:
    """Return the policy of a name for a case; raises as :func:`viewgain.evaluation._volume_choices.policy_of`."""
    return SHAPE_DECIDING[name](case) if name in SHAPE_DECIDING else policy_of(name, case)


def _automatic(case: DecisionCase) -> ViewPolicy:
    """Return what ``viewgain next`` does where nobody is named; without a scan it has no say, and nobody is asked."""
    scan = case.seen
    return FarthestPolicy() if scan is None else OnBelief(AutomaticPolicy(scan), case.camera)

"""Some of a plan's meshes."""

from dataclasses import replace

import numpy as np

from viewgain.datasets._plan import Plan
from viewgain.errors import ConfigError


def limited(plan: Plan, per_category: int, *, rng: np.random.Generator) -> Plan:
    """Return a plan of at most ``per_category`` meshes of each category, drawn at random and numbered anew; order is kept.

    Args:
        plan: Of a recipe that makes one unit per mesh, from a folder. (A procedural mesh is drawn from its number, so it would be
            another one.)
        per_category: Meshes, 1 or more.
        rng: Draws.

    Raises:
        ConfigError: If fewer than one is asked for.
    """
    if per_category < 1:
        raise ConfigError(f"limit: got {per_category} meshes per category, wanted at least 1")
    categories = np.array([unit.category for unit in plan.units])
    chosen: list[int] = []
    for category in plan.tables.categories:
        chosen += rng.permutation(np.flatnonzero(categories == category))[:per_category].tolist()
    units = (replace(plan.units[old], number=new, object=new) for new, old in enumerate(sorted(chosen)))
    return replace(plan, units=tuple(units))

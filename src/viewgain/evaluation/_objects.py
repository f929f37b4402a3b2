"""Objects to judge on that no training has seen: fresh procedural ones, or a folder of meshes."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from viewgain.datasets import CoverageSettings, Plan, Recipe, limited, plan_of, recipe
from viewgain.errors import ConfigError

RECIPE = "coverage_table1"
"""The shipped data recipe whose categories fresh objects are of: those that train, and those held out."""
FRESH_SEED = 0x6672_6573
"""Added to the seed that is asked for: data to train on is built with small ones, so no object is drawn a second time."""
_LIMIT = 0x6C69


def fresh_plan(count: int, *, seed: int, protocol: str = "paper") -> Plan:
    """Return the plan of fresh procedural objects, in the object's frame, every view as the first.

    Args:
        count: Objects in each of the 16 categories of :data:`RECIPE`.
        seed: Other seeds give other objects.
        protocol: Key of ``viewgain.gain.COVERAGE_PROTOCOLS``.

    Raises:
        ConfigError: If there are no objects or the seed is negative.
    """
    if count < 1 or seed < 0:
        raise ConfigError(f"fresh objects: got {count} per category and seed {seed}, wanted at least 1, and 0 or more")
    whole, content = _base(protocol)
    name = f"fresh procedural objects, {count} per category, seed {seed}"
    content = replace(content, per_category=count, per_held_out=count, test_share=0.0)
    return plan_of(replace(whole, name=name, seed=FRESH_SEED + seed, content=content))


def mesh_plan(folder: Path, *, limit: int | None = None, seed: int = 0, protocol: str = "paper") -> Plan:
    """Return the plan of the meshes of a folder (docs/meshes.md), in the object's frame, every view as the first.

    Args:
        folder: The meshes, by category.
        limit: At most so many of each category, drawn with the seed; None for all.
        seed: Of that draw, and of the samples of the surfaces.
        protocol: Key of ``viewgain.gain.COVERAGE_PROTOCOLS``.

    Raises:
        MeshError: If the folder is missing or holds no mesh.
        ConfigError: If the limit is under 1 or the seed negative.
    """
    if seed < 0:
        raise ConfigError(f"meshes: got seed {seed}, wanted 0 or more")
    whole, content = _base(protocol)
    content = replace(content, categories=(), held_out=(), test_share=0.0)
    plan = plan_of(replace(whole, name=f"meshes of {folder.name}", seed=seed, content=content), meshes=folder.absolute())
    return plan if limit is None else limited(plan, limit, rng=np.random.default_rng([seed, _LIMIT]))


def _base(protocol: str) -> tuple[Recipe, CoverageSettings]:
    whole = recipe(RECIPE)
    assert isinstance(whole.content, CoverageSettings)
    return replace(whole, units_per_shard=4), replace(whole.content, protocol=protocol, masks=False)

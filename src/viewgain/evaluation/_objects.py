"""Objects to judge on that no training has seen: fresh procedural ones, or a folder of meshes."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from viewgain.datasets import CoverageSettings, Manifest, Plan, Recipe, limited, plan_of, recipe, recipe_from_table
from viewgain.errors import ConfigError

RECIPE = "coverage_table1"
"""The shipped data recipe whose categories fresh objects are of: those that train, and those held out."""
FRESH_SEED = 0x6672_6573
"""Added to the seed that is asked for: data to train on is built with small ones, so no object is drawn a second time."""
_LIMIT = 0x6C69


def fresh_plan(count: int, *, seed: int) -> Plan:
    """Return the plan of fresh procedural objects, in the object's frame, every view as the first.

    Args:
        count: Objects in each of the 16 categories of :data:`RECIPE`.
        seed: Other seeds give other objects.

    Raises:
        ConfigError: If there are no objects or the seed is negative.
    """
    if count < 1 or seed < 0:
        raise ConfigError(f"fresh objects: got {count} per category and seed {seed}, wanted at least 1, and 0 or more")
    whole, content = _base()
    name = f"fresh procedural objects, {count} per category, seed {seed}"
    content = replace(content, per_category=count, per_held_out=count, test_share=0.0)
    return plan_of(replace(whole, name=name, seed=FRESH_SEED + seed, content=content))


def mesh_plan(folder: Path, *, limit: int | None = None, seed: int = 0) -> Plan:
    """Return the plan of the meshes of a folder (docs/meshes.md), in the object's frame, every view as the first.

    Args:
        folder: The meshes, by category.
        limit: At most so many of each category, drawn with the seed; None for all.
        seed: Of that draw, and of the samples of the surfaces.

    Raises:
        MeshError: If the folder is missing or holds no mesh.
        ConfigError: If the limit is under 1 or the seed negative.
    """
    if seed < 0:
        raise ConfigError(f"meshes: got seed {seed}, wanted 0 or more")
    whole, content = _base()
    content = replace(content, categories=(), held_out=(), test_share=0.0)
    plan = plan_of(replace(whole, name=f"meshes of {folder.name}", seed=seed, content=content), meshes=folder.absolute())
    return plan if limit is None else limited(plan, limit, rng=np.random.default_rng([seed, _LIMIT]))


def data_plan(manifest: Manifest, meshes: Path | None = None) -> Plan:
    """Return the plan that a coverage data set was built by, so that its objects can be looked at anew.

    Args:
        manifest: Of the data set.
        meshes: The folder of meshes that it was built from; None for procedural ones.

    Raises:
        ConfigError: If it was built from another folder of meshes, or is no coverage data.
    """
    table = {key: value for key, value in manifest.recipe.items() if key != "name"}
    name = str(manifest.recipe["name"])
    if "coverage" not in table:
        raise ConfigError(f"data set {name}: got no coverage data, wanted some (viewgain dataset build coverage_table1)")
    plan = plan_of(recipe_from_table(table, name), meshes=None if meshes is None else meshes.absolute())
    if plan.digest != manifest.plan:
        cure = "name the folder that it was built from with --meshes" if meshes is None else "name another folder"
        raise ConfigError(f"data set {name}: was not built from {meshes or 'procedural objects'}; {cure}")
    return plan


def _base() -> tuple[Recipe, CoverageSettings]:
    whole = recipe(RECIPE)
    assert isinstance(whole.content, CoverageSettings)
    return replace(whole, units_per_shard=4), replace(whole.content, masks=False)

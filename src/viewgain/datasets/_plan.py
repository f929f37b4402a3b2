"""A recipe worked out, before anything runs: its units, the shards they are stored in, and the words that the columns count."""

import hashlib
import json
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from viewgain.camera import sensor
from viewgain.datasets import _boxes, _mesh_units
from viewgain.datasets._boxes import BoxMaker
from viewgain.datasets._columns import Tables
from viewgain.datasets._recorded import UNNAMED, RecordedMaker
from viewgain.datasets._settings import BoxSettings, CoverageSettings, MeshSettings, Recipe, RecordedSettings
from viewgain.datasets._unit import Maker, Unit
from viewgain.errors import DataError

SCHEMA = 1
"""Version of the layout on disk."""
_LATER = {"coverage": ("steps", "wander")}
"""Keys that came after there were data sets. Where they are not used they are no part of a data set's identity."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What there is to do."""

    recipe: Recipe
    """The recipe."""
    meshes: Path | None
    """Folder of meshes; None for procedural ones. Not part of the data set's identity: the names in it are."""
    recordings: Path | None
    """Folder of recordings."""
    units: tuple[Unit, ...]
    """All units, in order."""
    tables: Tables
    """Words that the columns count."""

    @cached_property
    def shards(self) -> tuple[tuple[Unit, ...], ...]:
        """Units by shard: as many as the recipe says, in order, whoever makes them."""
        size = self.recipe.units_per_shard
        return tuple(self.units[start : start + size] for start in range(0, len(self.units), size))

    @cached_property
    def description(self) -> dict[str, Any]:
        """What the data set is, as it stands in recipe.json."""
        units = [[unit.object, unit.name, unit.category] for unit in self.units]
        recipe = {key: value for key, value in recipe_to_dict(self.recipe).items() if key != "makes"}
        kind = self.recipe.content.kind
        recipe[kind] = {key: value for key, value in recipe[kind].items() if value or key not in _LATER.get(kind, ())}
        return {"schema": SCHEMA, "recipe": recipe, "tables": asdict(self.tables), "units": units}

    @cached_property
    def digest(self) -> str:
        """SHA-256 of :attr:`description`: what a shard must have been made for to belong here."""
        return hashlib.sha256(json.dumps(self.description, sort_keys=True).encode()).hexdigest()


def plan_of(recipe: Recipe, *, meshes: Path | None = None, recordings: Path | None = None) -> Plan:
    """Return the plan of a recipe.

    Args:
        recipe: The recipe.
        meshes: Folder of meshes (docs/meshes.md); None for procedural ones.
        recordings: Folder of ``box/position/scan`` files, for recipes that read them.

    Raises:
        ConfigError: If the recipe cannot be made: an unknown camera, rig, category, protocol or effect, or a folder is missing.
        MeshError: If the folder holds no mesh.
        DataError: If there is nothing to make.
    """
    maker = maker_of(recipe, meshes=meshes, recordings=recordings)
    units = tuple(maker.units())
    if not units:
        raise DataError(f"recipe {recipe.name}: there is nothing to make")
    tables = Tables(categories=tuple(sorted({unit.category for unit in units})), cameras=_cameras(recipe), splits=_splits(recipe))
    return Plan(recipe=recipe, meshes=meshes, recordings=recordings, units=units, tables=tables)


def maker_of(recipe: Recipe, *, meshes: Path | None = None, recordings: Path | None = None) -> Maker:
    """Return what makes the units of a recipe; raises as :func:`plan_of`."""
    content = recipe.content
    if isinstance(content, BoxSettings):
        return BoxMaker(recipe, content)
    if isinstance(content, RecordedSettings):
        return RecordedMaker(recipe, content, recordings)
    from viewgain.datasets._coverage import CoverageMaker
    from viewgain.datasets._meshes import MeshMaker

    if isinstance(content, CoverageSettings):
        return CoverageMaker(recipe, content, meshes)
    return MeshMaker(recipe, content, meshes)


def recipe_to_dict(recipe: Recipe) -> dict[str, Any]:
    """Return a recipe as a table of its file, every default written out."""
    content: Any = recipe.content
    return {
        "name": recipe.name,
        "makes": recipe.makes,
        "seed": recipe.seed,
        "units_per_shard": recipe.units_per_shard,
        "points": asdict(recipe.points),
        content.kind: json.loads(json.dumps(asdict(content))),
    }


def _cameras(recipe: Recipe) -> tuple[str, ...]:
    """Return the names of the cameras that a recipe can use, each once."""
    content = recipe.content
    if isinstance(content, CoverageSettings):
        return ("exact",)
    if isinstance(content, RecordedSettings):
        return (sensor(content.camera).name if content.camera else UNNAMED,)
    return tuple(dict.fromkeys(sensor(name).name for name in content.cameras))


def _splits(recipe: Recipe) -> tuple[str, ...]:
    return _mesh_units.SPLITS if isinstance(recipe.content, CoverageSettings | MeshSettings) else _boxes.SPLITS

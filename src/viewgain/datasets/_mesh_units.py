"""Which meshes a recipe is about: those of a folder, or procedural ones; and how they are divided into parts."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from viewgain.datasets._seeds import SCENE, SPLIT, generator
from viewgain.datasets._settings import CoverageSettings, MeshSettings
from viewgain.datasets._unit import Unit
from viewgain.errors import ConfigError
from viewgain.meshes import MeshEntry, MeshFolder, TriangleMesh
from viewgain.shapes import CATEGORIES, procedural

SPLITS = ("same_category", "other_category")
"""``same_category``: meshes at random, so that kin of every test mesh train (variants of one shape are common in collections).
``other_category``: whole categories."""


def mesh_units(seed: int, folder: Path | None, rules: CoverageSettings | MeshSettings) -> Iterator[Unit]:
    """Yield one unit per mesh, sorted by category and name.

    Raises:
        MeshError: If the folder is missing or holds no mesh.
        ConfigError: If there is no such category.
    """
    named = list(_procedural(rules) if folder is None else _from_folder(folder, rules))
    rng = generator(seed, (0, SPLIT, 0, 0))
    kinds = sorted({category for category, _, _ in named})
    drawn = rng.permutation(np.array(kinds, dtype=object))[: round(rules.test_share * len(kinds))].tolist()
    away = set(_held_out(rules) or drawn)
    aside = rng.random(len(named)) < rules.test_share
    for number, (category, name, entry) in enumerate(named):
        splits = {
            "same_category": "test" if aside[number] else "train",
            "other_category": "test" if category in away else "train",
        }
        yield Unit(number=number, object=number, name=f"{category}/{name}", category=category, splits=splits, source=entry)


def mesh_of(unit: Unit, seed: int) -> TriangleMesh:
    """Return the mesh of a unit: read, or drawn from the unit's own stream.

    Raises:
        MeshError: If the file cannot be read as a mesh.
    """
    if isinstance(unit.source, MeshEntry):
        return unit.source.load()
    return procedural(unit.category, rng=generator(seed, (unit.object, SCENE, 0, 0)))


def _held_out(rules: CoverageSettings | MeshSettings) -> tuple[str, ...]:
    return rules.held_out if isinstance(rules, CoverageSettings) else ()


def _from_folder(folder: Path, rules: CoverageSettings | MeshSettings) -> Iterable[tuple[str, str, MeshEntry | None]]:
    meshes = MeshFolder.open(folder)
    wanted = (*rules.categories, *_held_out(rules))
    for entry in meshes.only(wanted) if wanted else meshes:
        yield entry.category, entry.name, entry


def _procedural(rules: CoverageSettings | MeshSettings) -> Iterable[tuple[str, str, MeshEntry | None]]:
    held_out = _held_out(rules)
    unknown = sorted({*rules.categories, *held_out} - set(CATEGORIES))
    if unknown:
        raise ConfigError(f"got the categories {', '.join(unknown)}, wanted some of {', '.join(sorted(CATEGORIES))}")
    counts = dict.fromkeys(rules.categories or CATEGORIES, rules.per_category)
    if isinstance(rules, CoverageSettings):
        counts |= dict.fromkeys(held_out, rules.per_held_out)
    for category in sorted(counts):
        for number in range(counts[category]):
            yield category, f"{number:05d}", None

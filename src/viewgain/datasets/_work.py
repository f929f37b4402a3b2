"""What a worker process does: units in, the bytes of a shard out. It writes nothing, so no worker needs the folder."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np

from viewgain.datasets._columns import Tables, packed
from viewgain.datasets._plan import maker_of
from viewgain.datasets._settings import Recipe
from viewgain.datasets._tensors import Columns, encoded
from viewgain.datasets._unit import Made, Maker, Skipped, Unit
from viewgain.errors import ViewgainError, one_line, printable

MASK_OBJECT, MASK_BITS = "mask_object", "mask_bits"
"""Columns with one row per object and view: which object, and the surface points that the view covers, bit by bit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """One shard to make."""

    recipe: Recipe
    meshes: Path | None
    recordings: Path | None
    tables: Tables
    digest: str
    number: int
    """Of the shard."""
    units: tuple[Unit, ...]
    deadly: Mapping[int, str] = field(default_factory=dict)
    """Units not to be touched, with the reason: they killed their process before."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shard:
    """One shard as it is written."""

    number: int
    content: bytes
    samples: int
    units: int
    skipped: int
    """How many samples or units could not be made."""


def make_shard(task: Task) -> Shard:
    """Return the shard of a task: the same bytes wherever it runs."""
    columns, skipped = shard_columns(task)
    metadata = {
        "plan": task.digest,
        "shard": str(task.number),
        "skipped": json.dumps([asdict(each) for each in skipped]),
    }
    return Shard(
        number=task.number,
        content=encoded(columns, metadata),
        samples=len(columns["view"]),
        units=len(task.units),
        skipped=len(skipped),
    )


def shard_columns(task: Task) -> tuple[Columns, list[Skipped]]:
    """Return the columns of a shard, and what could not be made."""
    maker = _maker(task.recipe, task.meshes, task.recordings)
    made = [_made(maker, unit, task.deadly.get(unit.number)) for unit in task.units]
    columns = packed([sample for each in made for sample in each.samples], task.tables, task.recipe.points.storage)
    masks = [(number, mask) for each in made for number, mask in each.masks.items()]
    if masks:
        columns[MASK_OBJECT] = np.concatenate([np.full(len(mask), number, dtype="<i4") for number, mask in masks])
        columns[MASK_BITS] = np.concatenate([mask for _, mask in masks])
    return columns, [skipped for each in made for skipped in each.skipped]


def _made(maker: Maker, unit: Unit, deadly: str | None) -> Made:
    """Return what comes of a unit; whatever goes wrong in it is a reason, and ends nothing."""
    if deadly is not None:
        return Made(samples=(), skipped=(Skipped(unit=unit.number, name=unit.name, reason=deadly),))
    try:
        return maker.make(unit)
    except ViewgainError as error:
        reason = one_line(error)
    except Exception as error:  # a decoder or the memory gave up on somebody's file: the other thousands must not suffer
        reason = f"{type(error).__name__}: {one_line(error)}"
    return Made(samples=(), skipped=(Skipped(unit=unit.number, name=unit.name, reason=printable(reason)),))


@lru_cache(maxsize=1)
def _maker(recipe: Recipe, meshes: Path | None, recordings: Path | None) -> Maker:
    """Return the maker; a process keeps it from shard to shard."""
    return maker_of(recipe, meshes=meshes, recordings=recordings)

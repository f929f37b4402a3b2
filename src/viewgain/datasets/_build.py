"""Building a data set: make what is missing, write each shard whole, and the manifest last.

What is in the folder is decided by the plan alone: a build that was killed goes on where it was, and ends with the same bytes.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path

from viewgain.datasets._columns import TARGET
from viewgain.datasets._engine import Dead, Engine
from viewgain.datasets._files import make_folder, remove_unfinished, sha256_of, write_whole
from viewgain.datasets._manifest import MANIFEST, RECIPE, SHARDS, Manifest, ShardEntry, read_manifest
from viewgain.datasets._plan import Plan, recipe_to_dict
from viewgain.datasets._tensors import intact, opened
from viewgain.datasets._unit import Skipped
from viewgain.datasets._work import Shard, Task, make_shard
from viewgain.errors import DataError

SKIPPED = "skipped.jsonl"
"""One line per sample or mesh that could not be made, with its reason."""
KILLED = "killed its worker process, twice (not enough memory?)"
"""Why a unit is skipped that took its process with it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Progress:
    """How far a build is."""

    units: int
    """Done since it started, of :attr:`total`."""
    total: int
    """To do in all."""
    samples: int
    """Made since it started."""
    skipped: int
    """Not made since it started."""


Watcher = Callable[[Progress], None]
"""Told after every shard."""


def build(plan: Plan, folder: Path, *, engine: Engine, resume: bool = False, watch: Watcher = lambda progress: None) -> Manifest:
    """Build a data set, or what is missing of it.

    Args:
        plan: What to make.
        folder: Where to; made if it is missing.
        engine: Who makes it; the bytes do not depend on it.
        resume: Go on in a folder that holds part of this data set; shards that are damaged are made anew.
        watch: Is told how far it is.

    Raises:
        DataError: If the folder holds a data set and ``resume`` is off, or holds another one, or nothing at all could be made.
        StorageError: If something cannot be written; the shards that were written stay, and no part of another one.
    """
    _claim(plan, folder, resume=resume)
    written = _written(folder)
    missing = [number for number in range(len(plan.shards)) if not _is_done(plan, folder, number, written)]
    if missing:
        (folder / MANIFEST).unlink(missing_ok=True)
    units = samples = skipped = 0
    total = sum(len(plan.shards[number]) for number in missing)
    watch(Progress(units=0, total=total, samples=0, skipped=0))
    for shard in _made(plan, missing, engine):
        write_whole(shard_path(folder, shard.number), shard.content)
        units, samples, skipped = units + shard.units, samples + shard.samples, skipped + shard.skipped
        watch(Progress(units=units, total=total, samples=samples, skipped=skipped))
    manifest = _manifest(plan, folder)
    lines = "".join(json.dumps({"unit": each.unit, "name": each.name, "reason": each.reason}) + "\n" for each in manifest.skipped)
    write_whole(folder / SKIPPED, lines.encode())
    write_whole(folder / MANIFEST, manifest.to_json().encode())
    if manifest.samples == 0:
        first = manifest.skipped[0]
        raise DataError(f"{folder}: no sample could be made; the first reason: {first.name}: {first.reason}")
    return manifest


def shard_path(folder: Path, number: int) -> Path:
    """Return the path of a shard."""
    return folder / SHARDS / f"shard-{number:05d}.safetensors"


def task_of(plan: Plan, number: int) -> Task:
    """Return what a worker needs to make one shard."""
    return Task(
        recipe=plan.recipe, meshes=plan.meshes, recordings=plan.recordings, tables=plan.tables, digest=plan.digest,
        number=number, units=plan.shards[number],
    )  # fmt: skip


def _claim(plan: Plan, folder: Path, *, resume: bool) -> None:
    """Take possession of a folder: write down what is built there, or make sure that it is the same."""
    make_folder(folder / SHARDS)
    text = json.dumps(plan.description, sort_keys=True).encode()
    path = folder / RECIPE
    if not path.exists():
        if any((folder / SHARDS).iterdir()) or (folder / MANIFEST).exists():
            raise DataError(f"{folder}: holds something else; name another folder")
        write_whole(path, text)
    elif not resume:
        raise DataError(f"{folder}: holds a data set already; add --resume to go on with it, or name another folder")
    elif path.read_bytes() != text:
        raise DataError(f"{folder}: holds another data set (other recipe, seed, meshes or recordings); name another folder")
    for each in (folder, folder / SHARDS):
        remove_unfinished(each)


def _written(folder: Path) -> dict[str, str]:
    """Return what an earlier build says that it wrote: SHA-256 by shard; nothing where it did not come to an end."""
    try:
        return {entry.name: entry.sha256 for entry in read_manifest(folder).shards}
    except DataError:
        return {}


def _is_done(plan: Plan, folder: Path, number: int, written: Mapping[str, str]) -> bool:
    """Return whether a shard is there, whole, of this plan, and as it was written."""
    path = shard_path(folder, number)
    if not path.exists() or not intact(path):
        return False
    if path.name in written and sha256_of(path) != written[path.name]:
        return False
    _, metadata = opened(path)
    return metadata.get("plan") == plan.digest and metadata.get("shard") == str(number)


def _made(plan: Plan, numbers: Iterable[int], engine: Engine) -> Iterator[Shard]:
    """Yield shards as they are done. One that kills its process is made without the units that do."""
    for task, shard in engine.run(make_shard, [task_of(plan, number) for number in numbers]):
        yield _without_killers(task, engine) if isinstance(shard, Dead) else shard


def _without_killers(task: Task, engine: Engine) -> Shard:
    """Return the shard of a task whose process died: each unit is tried apart, and those that die again are left out."""
    apart = [replace(task, units=(unit,)) for unit in task.units]
    deadly = {each.units[0].number: KILLED for each, result in engine.run(make_shard, apart) if isinstance(result, Dead)}
    ((_, shard),) = engine.run(make_shard, [replace(task, deadly=deadly)])
    if isinstance(shard, Dead):
        raise DataError(f"shard {task.number}: its worker process died again without {len(deadly)} of its units; lower --workers")
    return shard


def _manifest(plan: Plan, folder: Path) -> Manifest:
    """Return the manifest of the shards on disk."""
    entries, skipped = [], []
    targets: set[str] = set()
    for number in range(len(plan.shards)):
        path = shard_path(folder, number)
        columns, metadata = opened(path)
        skipped += [Skipped(**each) for each in json.loads(metadata["skipped"])]
        targets |= {name[len(TARGET) :] for name in columns if name.startswith(TARGET)}
        entries.append(
            ShardEntry(
                name=path.name,
                sha256=sha256_of(path),
                bytes=path.stat().st_size,
                samples=len(columns["view"]),
                points=len(columns["points"]),
            )
        )
    objects = {unit.object: unit.name for unit in plan.units}
    return Manifest(
        viewgain=version("viewgain"), recipe=recipe_to_dict(plan.recipe), plan=plan.digest, frame=plan.recipe.points.frame,
        tables=plan.tables, targets=tuple(sorted(targets)), objects=tuple(objects[number] for number in sorted(objects)),
        shards=tuple(entries), skipped=tuple(skipped),
    )  # fmt: skip

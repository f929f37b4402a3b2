"""Volume errors of every scan by some estimators: a pass of its own, which can be stopped and resumed.

The scans come from their seeds again (or from the files of a recording); a shard whose scans do not come out as they are
stored is refused. The errors lie beside the shards, so every score that is made of them is worked out when it is asked for.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from viewgain.camera import Sensor, sensor
from viewgain.datasets._build import Progress, Watcher, task_of
from viewgain.datasets._columns import packed
from viewgain.datasets._engine import Dead, Engine
from viewgain.datasets._estimators import volume_error
from viewgain.datasets._files import make_folder, remove_unfinished, write_whole
from viewgain.datasets._manifest import ERRORS, SHARDS, Manifest, read_manifest
from viewgain.datasets._plan import Plan, maker_of
from viewgain.datasets._sample import Sample
from viewgain.datasets._settings import BoxSettings, RecordedSettings
from viewgain.datasets._tensors import encoded, intact, opened
from viewgain.datasets._work import Task
from viewgain.errors import ConfigError, DataError
from viewgain.gain import ESTIMATORS

OTHERWISE = "this version of viewgain simulates otherwise, or the recordings have changed: build the data set anew"
"""What to do about scans that are not those of the data set."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorTask:
    """One shard, and the estimators that are missing for it."""

    shard: Task
    estimators: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShardErrors:
    """The errors of one shard."""

    number: int
    fingerprint: bytes
    """Of the points of its scans as they are stored, to compare with the shard's."""
    errors: dict[str, NDArray[np.float32]]
    """By estimator: (n,) relative errors; NaN for no estimate."""
    units: int


def add_volume_errors(
    plan: Plan, folder: Path, estimators: Sequence[str], *, engine: Engine, watch: Watcher = lambda progress: None
) -> None:
    """Work out what is missing of the volume errors of a finished data set.

    Args:
        plan: The plan it was built from.
        folder: Where it is.
        estimators: Some of ``viewgain.gain.ESTIMATORS``.
        engine: Who does it; the bytes do not depend on it.
        watch: Is told how far it is.

    Raises:
        ConfigError: If an estimator is not known or the recipe is not about boxes.
        DataError: If the scans do not come out as they are stored: another version of the simulator, or changed recordings.
        StorageError: If something cannot be written.
    """
    check_estimators(plan, estimators)
    manifest = read_manifest(folder)
    for name in estimators:
        make_folder(folder / ERRORS / name)
        remove_unfinished(folder / ERRORS / name)
    tasks = _missing(plan, folder, manifest, estimators)
    total, units, samples = sum(len(task.shard.units) for task in tasks), 0, 0
    watch(Progress(units=0, total=total, samples=0, skipped=0))
    for task, result in engine.run(shard_errors, tasks):
        if isinstance(result, Dead):
            raise DataError(f"shard {task.shard.number}: its worker process died; lower --workers and go on with --resume")
        _write(folder, manifest, result)
        units, samples = units + result.units, samples + sum(len(errors) for errors in result.errors.values())
        watch(Progress(units=units, total=total, samples=samples, skipped=0))


def check_estimators(plan: Plan, estimators: Sequence[str]) -> None:
    """Refuse estimators that are not known, and any where a recipe is not about boxes.

    Raises:
        ConfigError: Saying which.
    """
    unknown = sorted(set(estimators) - set(ESTIMATORS))
    if unknown:
        raise ConfigError(f"got the estimators {unknown}, wanted some of {', '.join(ESTIMATORS)}")
    if estimators and not isinstance(plan.recipe.content, BoxSettings | RecordedSettings):
        raise ConfigError(f"recipe {plan.recipe.name}: volume errors are of boxes, and this recipe has none")


def shard_errors(task: ErrorTask) -> ShardErrors:
    """Return the errors of all scans of a shard."""
    maker = maker_of(task.shard.recipe, meshes=task.shard.meshes, recordings=task.shard.recordings)
    samples: list[Sample] = []
    rows: list[list[float]] = []
    for unit in task.shard.units:
        for sample, scan in maker.scans(unit):
            if isinstance(sample, Sample) and scan is not None:
                camera = _camera(task.shard, sample)
                samples.append(sample)
                rows.append([volume_error(name, scan, sample, camera) for name in task.estimators])
    table = np.array(rows, dtype=np.float32).reshape(len(samples), len(task.estimators))
    points = packed(samples, task.shard.tables, task.shard.recipe.points.storage)["points"]
    return ShardErrors(
        number=task.shard.number,
        fingerprint=_fingerprint(points),
        errors={name: table[:, k].copy() for k, name in enumerate(task.estimators)},
        units=len(task.shard.units),
    )


def _camera(task: Task, sample: Sample) -> Sensor | None:
    """Return what is known of the camera that took a sample: its preset, without the factor on its noise."""
    content = task.recipe.content
    if isinstance(content, RecordedSettings):
        return sensor(content.camera) if content.camera else None
    assert isinstance(content, BoxSettings)
    return next(each for each in map(sensor, content.cameras) if each.name == sample.camera)


def _missing(plan: Plan, folder: Path, manifest: Manifest, estimators: Sequence[str]) -> list[ErrorTask]:
    tasks = []
    for number, entry in enumerate(manifest.shards):
        missing = tuple(name for name in estimators if not _is_done(folder / ERRORS / name / entry.name, entry.sha256))
        if missing:
            tasks.append(ErrorTask(shard=task_of(plan, number), estimators=missing))
    return tasks


def _is_done(path: Path, shard_sha256: str) -> bool:
    return path.exists() and intact(path) and opened(path)[1].get("shard_sha256") == shard_sha256


def _write(folder: Path, manifest: Manifest, result: ShardErrors) -> None:
    entry = manifest.shards[result.number]
    columns, _ = opened(folder / SHARDS / entry.name)
    if _fingerprint(columns["points"]) != result.fingerprint:
        raise DataError(f"{entry.name}: its scans do not come out as they are stored; {OTHERWISE}")
    for name, errors in result.errors.items():
        content = encoded({"error": errors}, {"shard_sha256": entry.sha256, "estimator": name})
        write_whole(folder / ERRORS / name / entry.name, content)


def _fingerprint(points: NDArray[np.generic]) -> bytes:
    return hashlib.sha256(points.tobytes()).digest()

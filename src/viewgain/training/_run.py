"""A run from start to end: data, network, loop; a fresh one, or one that goes on where it was."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from viewgain.datasets import Dataset, rig_of
from viewgain.errors import ConfigError, DataError, TrainingError
from viewgain.network import parameters_of
from viewgain.training._batches import Batches
from viewgain.training._checkpoint import Checkpoint, newest_good, require_safetensors
from viewgain.training._data import open_data, shown_and_aside
from viewgain.training._examples import Examples
from viewgain.training._facts import versions
from viewgain.training._floors import floors
from viewgain.training._folder import RunFolder, RunRecord
from viewgain.training._ranks import Ranks, ranks
from viewgain.training._session import Session
from viewgain.training._settings import TrainingRecipe
from viewgain.training._symmetry import symmetries
from viewgain.training._teacher import Teacher, check_same, open_teacher, placed
from viewgain.training._train import Outcome, Progress, Watcher, train


@dataclass(frozen=True, slots=True, kw_only=True)
class Means:
    """What a run may use."""

    device: str = "cpu"
    """Of torch: cpu, cuda, ..."""
    minutes: float | None = None
    """Time limit of the whole run, earlier parts included."""

    def __post_init__(self) -> None:
        if self.minutes is not None and not self.minutes > 0:
            raise ConfigError(f"got a time limit of {self.minutes} minutes, wanted more than 0")


def start(
    recipe: TrainingRecipe, path: Path, *, data: Path | None = None, means: Means | None = None, watch: Watcher | None = None
) -> Outcome:
    """Train a fresh network.

    Args:
        recipe: What, on what, and how.
        path: Folder of the run; made if it is missing.
        data: Folder of the data set; None to build the recipe's own into the run's folder.
        means: Device and time limit.
        watch: Is told how far it is, in process 0.

    Raises:
        TrainingError: If the folder holds a run already, or the processes of torchrun cannot meet.
        DataError: If the data is missing or not what the recipe is for.
        ConfigError: If the recipe does not fit the number of processes, or names no data.
        StorageError: If something cannot be written.
    """
    means = means or Means()
    require_safetensors()
    group = ranks(means.device)
    try:
        folder = RunFolder(path)
        if group.rank == 0:
            folder.claim()
        opened = open_data(recipe, folder, data, group)
        return _run(placed(recipe), folder, opened, means, group, watch)
    finally:
        group.close()


def resume(
    path: Path,
    *,
    data: Path | None = None,
    teacher: Path | None = None,
    means: Means | None = None,
    watch: Watcher | None = None,
) -> Outcome:
    """Go on with a run from its newest checkpoint that is whole; from its start if there is none yet.

    Args:
        path: Folder of the run.
        data: Where its data set is now; None for where it was.
        teacher: Where its teacher is now, likewise.
        means: Device and time limit.
        watch: Is told how far it is, in process 0.

    Raises:
        TrainingError: If there is no run, every checkpoint is damaged, or the teacher is another one.
        ConfigError: If a teacher is named and the run has none.
        DataError: If the data is missing, or not the data that the run was started on.
        StorageError: If something cannot be written.
    """
    means = means or Means()
    require_safetensors()
    group = ranks(means.device)
    try:
        folder = RunFolder(path)
        record = folder.read()
        checkpoint = newest_good(folder.checkpoints)
        if checkpoint is None and any(folder.checkpoints.glob("step-*.safetensors")):
            raise TrainingError(f"{folder.checkpoints}: got damaged checkpoints only; start the run anew in another folder")
        opened = Dataset(data or Path(record.data))
        if opened.manifest.plan != record.plan:
            raise DataError(f"{opened.folder}: got other data than the run was started on; name the same with --data")
        recipe = placed(record.recipe, teacher)
        return _run(recipe, folder, opened, means, group, watch, checkpoint=checkpoint, before=record)
    finally:
        group.close()


def _run(
    recipe: TrainingRecipe,
    folder: RunFolder,
    data: Dataset,
    means: Means,
    group: Ranks,
    watch: Watcher | None,
    *,
    checkpoint: Checkpoint | None = None,
    before: RunRecord | None = None,
) -> Outcome:
    """Load, build, take up, train. torch's own random state is put back afterwards."""
    seed = recipe.training.seed
    teacher = open_teacher(recipe, rig_of(data.manifest), means.device)
    check_same(teacher, before)
    examples, aside = shown_and_aside(recipe, data)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        session = Session(recipe, _batches(recipe, examples, aside, means.device, teacher), device=means.device, ranks=group)
        progress = Progress()
        if checkpoint is not None:
            session.restore(checkpoint)
            progress = Progress(**{name: checkpoint.state[name] for name in ("best", "stale", "seconds")})
        if group.rank == 0:
            facts = _facts(session, data, examples, aside, means, group) | {
                "teacher": None if teacher is None else teacher.facts()
            }
            _open_folder(folder, recipe, data, facts, session.step, is_fresh=before is None)
        watching = watch if watch is not None and group.rank == 0 else lambda step, progress: None
        return train(
            session,
            folder,
            examples.to(means.device),
            np.flatnonzero(aside),
            ranks=group,
            progress=progress,
            minutes=means.minutes,
            watch=watching,
        )


def _open_folder(
    folder: RunFolder, recipe: TrainingRecipe, data: Dataset, facts: Mapping[str, Any], step: int, *, is_fresh: bool
) -> None:
    if is_fresh:
        folder.write(RunRecord(recipe=recipe, data=str(data.folder.absolute()), plan=data.manifest.plan, facts=facts))
    else:
        folder.cut_metrics(step)


def _batches(
    recipe: TrainingRecipe, examples: Examples, aside: NDArray[np.bool_], device: str, teacher: Teacher | None
) -> Batches:
    settings = recipe.data
    return Batches(
        examples.to(device),
        settings,
        rows=np.flatnonzero(~aside),
        batch=recipe.training.batch,
        points=recipe.network.points,
        uses_state=recipe.network.with_view_state,
        seed=recipe.training.seed,
        symmetries=symmetries(examples.poses, settings.frame, vacant=settings.vacant) if settings.symmetry else None,
        teacher=teacher,
    )


def _facts(
    session: Session, data: Dataset, examples: Examples, aside: NDArray[np.bool_], means: Means, group: Ranks
) -> dict[str, Any]:
    return {
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "versions": versions(),
        "device": means.device,
        "device_name": torch.cuda.get_device_name() if means.device.startswith("cuda") else None,
        "threads": torch.get_num_threads(),
        "processes": group.size,
        "parameters": parameters_of(session.model),
        "rig": rig_of(data.manifest),
        "data_recipe": data.manifest.recipe["name"],
        "data_seed": data.manifest.recipe["seed"],
        "floors": floors(examples, aside),
        "training": _counts(examples.objects[~aside]),
        "validation": _counts(examples.objects[aside]),
    }


def _counts(objects: NDArray[np.int64]) -> dict[str, int]:
    return {"samples": len(objects), "objects": len(np.unique(objects))}

"""Objects of any shape worked through by processes: errors are kept, decisions are made anew every time."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from viewgain.arrays import Array, Mask
from viewgain.datasets import write_whole
from viewgain.evaluation._box_results import Watcher, all_done, rig_digest
from viewgain.evaluation._choice import Choice, decisions
from viewgain.evaluation._claim import claim, damaged, kept_text
from viewgain.evaluation._network_choices import network_of
from viewgain.evaluation._plain import finite
from viewgain.evaluation._shape_case import VOLUMES, first_errors, shape_case, shape_errors
from viewgain.evaluation._shape_choices import SHAPE_DECIDING, shape_policy
from viewgain.evaluation._shape_settings import ShapeSettings
from viewgain.evaluation._volume_choices import is_from_file

OBJECTS = "objects"
"""Where a folder of results holds one file per object."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShapeRun:
    """One object: the truth about its positions, and what each policy chose."""

    number: int
    """Which object."""
    category: str
    """Its kind."""
    reachable: Mask
    """(V,) where the camera could go."""
    present: int
    """Where it stood."""
    first: Array
    """(2,) relative errors of the volumes by the first scan alone, NaN for a miss."""
    errors: Array
    """(2, V, 2n) relative errors of the volumes after a second scan, NaN for a miss: the first n score, the others are the
    oracle's."""
    choices: dict[str, Choice]
    """By policy."""
    milliseconds: dict[str, float]
    """CPU time of each decision."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Task:
    settings: ShapeSettings
    number: int
    policies: tuple[str, ...]
    known: tuple[Array, Array] | None
    """First errors and errors that a file says of the object; None to work them out."""


def run_shapes(
    settings: ShapeSettings,
    objects: int,
    policies: Sequence[str],
    *,
    workers: int = 1,
    folder: Path | None = None,
    watch: Watcher = lambda done, total: None,
) -> list[ShapeRun]:
    """Return the runs of objects 0 to ``objects`` - 1.

    Args:
        settings: The question.
        objects: How many, 1 or more.
        policies: Names (:func:`viewgain.evaluation.check_shape_policies`).
        workers: Processes, one thread each; the results are the same whatever the number.
        folder: Where errors are kept, object by object, and taken from if they are there; made if it is missing.
        watch: Is told how far it is.

    Raises:
        DataError: If the folder answers another question, a file in it is damaged, or a process died twice on one object.
        ConfigError: If the settings leave no object, or a network is of another rig or for no volumes.
        MeshError: If a mesh cannot be read.
        ModelError: If a network's file is missing or damaged.
        StorageError: If the folder cannot be written.
    """
    deciding = tuple(name for name in policies if name in SHAPE_DECIDING or is_from_file(name))
    for name in filter(is_from_file, deciding):
        network_of(name, settings)  # a wrong file is said before the first object, which takes its time
    if folder is not None:
        claim(folder, {"rig_stations": rig_digest(settings), **settings.to_dict()}, results=folder / OBJECTS)
    tasks = [
        _Task(
            settings=settings,
            number=number,
            policies=deciding,
            known=None if folder is None else _kept(_file(folder, number), settings),
        )
        for number in range(objects)
    ]

    def keep(task: _Task, run: ShapeRun) -> None:
        if folder is not None and task.known is None:
            write_whole(_file(folder, run.number), _truth(run).encode())

    return all_done(_worked_out, tasks, workers=workers, keep=keep, watch=watch, what="object")


def _worked_out(task: _Task) -> ShapeRun:
    case = shape_case(task.settings, task.number)
    first, errors = (first_errors(case), shape_errors(case)) if task.known is None else task.known
    choices, spent = decisions(case, task.policies, shape_policy)
    return ShapeRun(
        number=task.number,
        category=case.category,
        reachable=case.reachable,
        present=case.present,
        first=first,
        errors=errors,
        choices=choices,
        milliseconds=spent,
    )


def _file(folder: Path, number: int) -> Path:
    return folder / OBJECTS / f"object{number:05d}.json"


def _truth(run: ShapeRun) -> str:
    """Return what is kept of an object: its errors, null for a miss."""
    kept = {"object": run.number, "category": run.category, "first": run.first.tolist(), "errors": run.errors.tolist()}
    return json.dumps(finite(kept), allow_nan=False) + "\n"


def _kept(file: Path, settings: ShapeSettings) -> tuple[Array, Array] | None:
    """Return the errors that are kept of an object; None if there are none yet."""
    text = kept_text(file)
    if text is None:
        return None
    try:
        kept = json.loads(text)
        first, errors = np.array(kept["first"], dtype=float), np.array(kept["errors"], dtype=float)
    except (ValueError, TypeError, KeyError) as error:
        raise damaged(file) from error
    shape = (len(VOLUMES), len(settings.stations().stations), 2 * settings.captures)
    if first.shape != shape[:1] or errors.shape != shape:
        raise damaged(file)
    return first, errors

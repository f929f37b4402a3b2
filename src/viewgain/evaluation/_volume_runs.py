"""Boxes worked through by processes: errors that are costly and kept, decisions that are cheap and made anew every time."""

import dataclasses
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from viewgain.arrays import Array, Mask, Vector
from viewgain.datasets import write_whole
from viewgain.evaluation._box_results import BOXES, Watcher, all_done, box_file, rig_digest
from viewgain.evaluation._choice import Choice, decisions
from viewgain.evaluation._claim import claim, damaged, kept_text
from viewgain.evaluation._volume_case import VolumeSettings, case_errors, volume_case
from viewgain.evaluation._volume_choices import DECIDING, is_from_file, network_of, policy_of
from viewgain.evaluation._volume_confidence import opinions_of
from viewgain.plan import decision_numbers


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class VolumeRun:
    """One box: the truth about its positions, and what each policy chose."""

    number: int
    """Which box."""
    size: tuple[float, float, float]
    """Its sides, metres."""
    present: int
    """Where the camera stood."""
    reachable: Mask
    """(V,) where it could go."""
    errors: Array
    """(V, 2n) relative volume errors, NaN for a miss: the first n score, the others are the oracle's."""
    choices: dict[str, Choice]
    """By policy."""
    milliseconds: dict[str, float]
    """CPU time of each decision, measuring included."""
    numbers: dict[str, Vector | None] = field(default_factory=dict)
    """By policy: (F,) what model and network say of its choice (:func:`viewgain.plan.decision_numbers`), None where they are
    silent; empty where another estimator than the default one measures, of which they know nothing."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Task:
    settings: VolumeSettings
    number: int
    policies: tuple[str, ...]
    known: Array | None
    """(V, 2n) errors that a file says of the box; None to work them out."""


def run_boxes(
    settings: VolumeSettings,
    boxes: int,
    policies: Sequence[str],
    *,
    workers: int = 1,
    folder: Path | None = None,
    watch: Watcher = lambda done, total: None,
) -> list[VolumeRun]:
    """Return the runs of boxes 0 to ``boxes`` - 1.

    Args:
        settings: The question.
        boxes: How many, 1 or more.
        policies: Names of policies that decide on a scan.
        workers: Processes, one thread each; the results are the same whatever the number.
        folder: Where errors are kept, box by box, and taken from if they are there; made if it is missing.
        watch: Is told how far it is.

    Raises:
        DataError: If the folder answers another question, a file in it is damaged, or a process died twice on one box.
        ConfigError: If the settings leave no box, or a network is of another rig or for no volumes.
        ModelError: If a network's file is missing or damaged.
        StorageError: If the folder cannot be written.
    """
    deciding = tuple(name for name in policies if name in DECIDING or is_from_file(name))
    for name in filter(is_from_file, deciding):
        network_of(name, settings)  # a wrong file is said before the first box, which takes its time
    if folder is not None:
        claim(folder, {"rig_stations": rig_digest(settings), **dataclasses.asdict(settings)}, results=folder / BOXES)
    tasks = [
        _Task(
            settings=settings,
            number=number,
            policies=deciding,
            known=None if folder is None else _kept(box_file(folder, number), settings),
        )
        for number in range(boxes)
    ]

    def keep(task: _Task, run: VolumeRun) -> None:
        if folder is not None and task.known is None:
            write_whole(box_file(folder, run.number), _truth(run).encode())

    return all_done(_worked_out, tasks, workers=workers, keep=keep, watch=watch)


def _worked_out(task: _Task) -> VolumeRun:
    case = volume_case(task.settings, task.number)
    errors = case_errors(case) if task.known is None else task.known
    choices, spent = decisions(case, task.policies, policy_of)
    opinions = opinions_of(case) if choices and task.settings.estimator == "default" else None
    sides = tuple(float(side) for side in case.box.extents)
    return VolumeRun(
        number=task.number,
        size=(sides[0], sides[1], sides[2]),
        present=case.present,
        reachable=case.reachable,
        errors=errors,
        choices=choices,
        milliseconds=spent,
        numbers={} if opinions is None else {name: decision_numbers(opinions, made.position) for name, made in choices.items()},
    )


def _truth(run: VolumeRun) -> str:
    """Return what is kept of a box: its errors, null for a miss."""
    rows = [[float(error) if np.isfinite(error) else None for error in row] for row in run.errors]
    return json.dumps({"box": run.number, "size_m": run.size, "present": run.present, "errors": rows}, allow_nan=False) + "\n"


def _kept(file: Path, settings: VolumeSettings) -> Array | None:
    """Return the (V, 2n) errors that are kept of a box; None if there are none yet."""
    text = kept_text(file)
    if text is None:
        return None
    try:
        rows = json.loads(text)["errors"]
        errors = np.array([[np.nan if error is None else float(error) for error in row] for row in rows], dtype=float)
    except (ValueError, TypeError, KeyError) as error:
        raise damaged(file) from error
    if errors.shape != (len(settings.stations().stations), 2 * settings.captures):
        raise damaged(file)
    return errors

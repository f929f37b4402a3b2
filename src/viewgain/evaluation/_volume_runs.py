"""Boxes worked through by processes: errors, which are costly and kept, and decisions, kept where they take long."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from viewgain.arrays import Array, Mask, Vector
from viewgain.datasets import write_whole
from viewgain.evaluation._box_results import BOXES, Watcher, all_done, box_file, rig_digest
from viewgain.evaluation._choice import Choice, decisions
from viewgain.evaluation._claim import claim
from viewgain.evaluation._network_choices import network_of
from viewgain.evaluation._volume_case import VolumeCase, VolumeSettings, volume_case
from viewgain.evaluation._volume_choices import (
    INFORMED,
    VOLUME_DECIDING,
    VOLUME_FROM_FILE,
    around_of,
    is_from_file,
    is_rehearsing,
    is_told,
    volume_policy,
)
from viewgain.evaluation._volume_confidence import opinions_of
from viewgain.evaluation._volume_decided import Decided, Decisions
from viewgain.evaluation._volume_kept import Truth, kept_truth, truth_of, truth_text
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
    by_others: Array | None = None
    """(V, n) errors of scans by other cameras of the model; None where nobody asked for them."""
    numbers: dict[str, Vector | None] = field(default_factory=dict)
    """By policy: (F,) what model and network say of its choice (:func:`viewgain.plan.decision_numbers`), None where they are
    silent; empty where another estimator than the default one measures, of which they know nothing."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Task:
    settings: VolumeSettings
    number: int
    policies: tuple[str, ...]
    others: bool
    """Whether scans by other cameras are wanted."""
    known: Truth | None
    """What a file says of the box; what is not there is worked out."""
    decided: Mapping[str, Decided]
    """Decisions on the box that are kept, by name of policy."""


@dataclass(frozen=True, slots=True, eq=False)
class _Done:
    run: VolumeRun
    text: str | None
    """What is to be kept of the box; None where a file says it already."""
    decided: Mapping[str, Decided]
    """Decisions to be kept, by name of policy; those that are kept already are missing."""


def run_boxes(
    settings: VolumeSettings,
    boxes: int,
    policies: Sequence[str],
    *,
    first: int = 0,
    workers: int = 1,
    folder: Path | None = None,
    watch: Watcher = lambda done, total: None,
) -> list[VolumeRun]:
    """Return the runs of boxes ``first`` to ``first`` + ``boxes`` - 1.

    Args:
        settings: The question.
        boxes: How many, 1 or more.
        policies: Names of policies that decide on a scan.
        first: Number of the first box, 0 or more; what becomes of a box depends on its number alone.
        workers: Processes, one thread each; the results are the same whatever the number.
        folder: Where errors and long decisions are kept, box by box, and taken from if they are there; made if it is missing.
        watch: Is told how far it is.

    Raises:
        DataError: If the folder answers another question, a file in it is damaged, or a process died twice on one box.
        ConfigError: If the settings leave no box, or a network is of another rig or for no volumes.
        ModelError: If a network's file is missing or damaged.
        StorageError: If the folder cannot be written.
    """
    deciding = tuple(name for name in policies if name in VOLUME_DECIDING or is_from_file(name, VOLUME_FROM_FILE))
    for name in deciding:
        if name not in VOLUME_DECIDING:
            network_of(name, settings)  # a wrong file is said before the first box, which takes its time
    if any(map(is_told, deciding)):
        around_of(settings)  # and so is a wrong rig
    if folder is not None:
        claim(folder, {"rig_stations": rig_digest(settings), **settings.to_dict()}, results=folder / BOXES)
    slow = [name for name in deciding if is_rehearsing(name)]
    decisions_kept = None if folder is None or not slow else Decisions.begun(folder, settings, slow)
    tasks = [
        _Task(
            settings=settings,
            number=number,
            policies=deciding,
            others=INFORMED in policies,
            known=None if folder is None else kept_truth(box_file(folder, number), settings),
            decided={} if decisions_kept is None else decisions_kept.known(number),
        )
        for number in range(first, first + boxes)
    ]

    def keep(task: _Task, done: _Done) -> None:
        if folder is not None and done.text is not None:
            write_whole(box_file(folder, task.number), done.text.encode())
        if decisions_kept is not None and done.decided:
            decisions_kept.keep(task.number, done.decided)

    return [done.run for done in all_done(_worked_out, tasks, workers=workers, keep=keep, watch=watch)]


def _worked_out(task: _Task) -> _Done:
    case = volume_case(task.settings, task.number)
    truth = truth_of(case, task.known, others=task.others)
    decided = _decided(case, task)
    opinions = opinions_of(case) if decided and task.settings.estimator == "default" else None
    sides = tuple(float(side) for side in case.box.extents)
    run = VolumeRun(
        number=task.number,
        size=(sides[0], sides[1], sides[2]),
        present=case.present,
        reachable=case.reachable,
        errors=truth.errors,
        by_others=truth.by_others,
        choices={name: each.choice for name, each in decided.items()},
        milliseconds={name: each.milliseconds for name, each in decided.items()},
        numbers={}
        if opinions is None
        else {name: decision_numbers(opinions, each.choice.position) for name, each in decided.items()},
    )
    news = {name: each for name, each in decided.items() if is_rehearsing(name) and name not in task.decided}
    return _Done(run, None if truth is task.known else truth_text(truth, case), news)


def _decided(case: VolumeCase, task: _Task) -> dict[str, Decided]:
    """Return the decision of every policy that is asked: the one that is kept, or a new one."""
    choices, spent = decisions(case, [name for name in task.policies if name not in task.decided], volume_policy)
    made = {name: Decided(each, spent[name]) for name, each in choices.items()}
    return {name: made[name] if name in made else task.decided[name] for name in task.policies}

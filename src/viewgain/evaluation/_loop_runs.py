"""Boxes of the closed loop worked through by processes; what came of a box and a policy is kept, and not played again."""

import dataclasses
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from viewgain.datasets import write_whole
from viewgain.evaluation._box_results import BOXES, Watcher, box_file, each_done, rig_digest
from viewgain.evaluation._claim import claim, damaged, kept_text
from viewgain.evaluation._loop_case import Loop, LoopSettings
from viewgain.evaluation._loop_play import LoopPlay, loop_play
from viewgain.evaluation._loop_policies import FEWEST
from viewgain.evaluation._network_choices import network_of, policy_key
from viewgain.evaluation._volume_choices import is_from_file

Plays = Mapping[str, LoopPlay]
"""What came of a box, by policy."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Task:
    settings: LoopSettings
    number: int
    policies: tuple[str, ...]
    """Those that are not played yet."""


def loop_boxes(
    settings: LoopSettings,
    boxes: int,
    policies: Sequence[str],
    *,
    workers: int = 1,
    folder: Path | None = None,
    watch: Watcher = lambda done, total: None,
) -> list[Plays]:
    """Return what came of boxes 0 to ``boxes`` - 1, by policy.

    Args:
        settings: The question.
        boxes: How many, 1 or more.
        policies: Names (:func:`viewgain.evaluation.check_loop_policies`).
        workers: Processes, one thread each; the results are the same whatever the number.
        folder: Where what came of each box is kept, and taken from if it is there; made if it is missing. A network is known by
            what its file holds, not by its name.
        watch: Is told how far it is.

    Raises:
        DataError: If the folder answers another question, a file in it is damaged, or a process died twice on one box.
        ConfigError: If the settings leave no box, or a network is of another rig or for no volumes.
        ModelError: If a network's file is missing or damaged.
        StorageError: If the folder cannot be written.
    """
    keys = {name: _key(name, settings) for name in policies}
    if folder is not None:
        claim(folder, {"rig_stations": rig_digest(settings.boxes), **settings.to_dict()}, results=folder / BOXES)
    kept = [{} if folder is None else _kept(box_file(folder, number), settings) for number in range(boxes)]
    missing = [tuple(name for name in policies if keys[name] not in plays) for plays in kept]
    tasks = [_Task(settings=settings, number=number, policies=names) for number, names in enumerate(missing) if names]
    done = boxes - len(tasks)
    watch(done, boxes)
    for task, played in each_done(_worked_out, tasks, workers=workers):
        kept[task.number] |= {keys[name]: play for name, play in played.items()}
        if folder is not None:
            write_whole(box_file(folder, task.number), _text(kept[task.number]).encode())
        done += 1
        watch(done, boxes)
    return [{name: plays[key] for name, key in keys.items()} for plays in kept]


def _worked_out(task: _Task) -> dict[str, LoopPlay]:
    loop = Loop(task.settings, task.number)
    return {name: loop_play(loop, name) for name in task.policies}


def _key(name: str, settings: LoopSettings) -> str:
    """Return the name under which plays are kept; a wrong network is said here, before the first box, which takes its time."""
    if is_from_file(name):
        network_of(name, settings.boxes)
    return policy_key(name)


def _text(plays: Plays) -> str:
    return json.dumps({key: dataclasses.asdict(play) for key, play in sorted(plays.items())}, allow_nan=False) + "\n"


def _kept(file: Path, settings: LoopSettings) -> dict[str, LoopPlay]:
    text = kept_text(file)
    if text is None:
        return {}
    try:
        plays = {key: _play(**values) for key, values in json.loads(text).items()}
    except (ValueError, TypeError, AttributeError) as error:
        raise damaged(file) from error
    if any(len(play.errors) != (0 if key == FEWEST else settings.most_views) for key, play in plays.items()):
        raise damaged(file)
    return plays


def _play(
    *,
    positions: list[int],
    errors: list[float],
    chances: list[float],
    stopped: int | None,
    within: int | None,
    final: float,
    undecided: int,
) -> LoopPlay:
    """Return a play from its plain values; TypeError if one is missing or of another kind."""
    return LoopPlay(
        positions=tuple(map(int, positions)),
        errors=tuple(map(float, errors)),
        chances=tuple(map(float, chances)),
        stopped=None if stopped is None else int(stopped),
        within=None if within is None else int(within),
        final=float(final),
        undecided=int(undecided),
    )

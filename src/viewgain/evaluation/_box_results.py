"""Boxes worked through by processes, and where a folder of results keeps what came of each."""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Protocol, TypeVar

from viewgain.datasets import Dead, LocalEngine
from viewgain.errors import DataError
from viewgain.evaluation._choice import Question

BOXES = "boxes"
"""Where a folder of results holds one file per box."""

Watcher = Callable[[int, int], None]
"""Told after every box: how many are done, of how many."""


class BoxTask(Protocol):
    """Work on one box."""

    @property
    def number(self) -> int:
        """Which box."""


T = TypeVar("T", bound=BoxTask)
R = TypeVar("R")


def each_done(work: Callable[[T], R], tasks: Sequence[T], *, workers: int, what: str = "box") -> Iterator[tuple[T, R]]:
    """Yield each task with what came of it, as they are done.

    Args:
        work: What to do, a function of a module.
        tasks: On which boxes.
        workers: Processes, one thread each.
        what: What a task is about, for the message.

    Raises:
        DataError: If a worker process died twice on one box.
    """
    for task, result in LocalEngine(workers).run(work, tasks):
        if isinstance(result, Dead):
            raise DataError(f"{what} {task.number}: its worker process died twice; lower --workers, run the same command again")
        yield task, result


def all_done(
    work: Callable[[T], R],
    tasks: Sequence[T],
    *,
    workers: int,
    keep: Callable[[T, R], None],
    watch: Watcher,
    what: str = "box",
) -> list[R]:
    """Return what came of each task, in their order; raises as :func:`each_done`.

    Args:
        work: What to do, a function of a module.
        tasks: On which boxes, each once.
        workers: Processes.
        keep: Is given each result as it is done.
        watch: Is told how far it is.
        what: What a task is about, for the message.
    """
    done: dict[int, R] = {}
    watch(0, len(tasks))
    for task, result in each_done(work, tasks, workers=workers, what=what):
        keep(task, result)
        done[task.number] = result
        watch(len(done), len(tasks))
    return [done[task.number] for task in tasks]


def box_file(folder: Path, number: int) -> Path:
    """Return where a folder of results keeps a box."""
    return folder / BOXES / f"box{number:05d}.json"


def rig_digest(settings: Question) -> str:
    """Return a fingerprint of the rig: a file of that name may have changed."""
    return hashlib.sha256(repr(settings.stations()).encode()).hexdigest()[:16]

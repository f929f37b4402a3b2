"""Engines for tests: one without processes, one whose processes die of a certain unit; and work that kills its process."""

import os
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from viewgain.datasets._engine import Dead


class Inline:
    """Runs everything here and now, last task first: nothing may depend on the order."""

    def run(self, work: Callable[[Any], Any], tasks: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
        for task in reversed(tasks):
            yield task, work(task)


class Deadly:
    """A process that touches the unit dies."""

    def __init__(self, unit: int) -> None:
        self.unit = unit

    def run(self, work: Callable[[Any], Any], tasks: Sequence[Any]) -> Iterator[tuple[Any, Any]]:
        for task in tasks:
            touched = any(unit.number == self.unit for unit in task.units) and self.unit not in task.deadly
            yield task, Dead() if touched else work(task)


def squared_unless_thirteen(number: int) -> int:
    """Return a square; 13 kills the process."""
    if number == 13:
        os._exit(1)
    return number * number

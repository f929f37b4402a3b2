"""What one scan gave, or several fused: ready to be printed in any of three ways."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Answer:
    """One result, whatever measured it."""

    measured: bool
    """Whether there is anything in it; else exit code 3."""
    json: dict[str, object]
    """Its JSON form."""
    rows: list[list[object]]
    """Its CSV rows; one with the reason if nothing was measured."""
    say: Callable[[], None]
    """Prints it for people: tables on stdout, notes and the reason on stderr."""

"""``viewgain measure``: one result per scan, or one for all with ``--fuse``; as text, JSON lines or CSV."""

import csv
import json
import sys
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from viewgain.cli._answer import Answer
from viewgain.cli._billing import BILLED_COLUMNS, rules_of
from viewgain.cli._boxes import CSV_COLUMNS, box_answer
from viewgain.cli._commands import Measure
from viewgain.cli._exit import BAD_INPUT, NOTHING_MEASURED, print_error
from viewgain.cli._files import check, read_floor, read_one
from viewgain.errors import ConfigError, ViewgainError
from viewgain.measure import fuse, measure
from viewgain.scans import Scan

if TYPE_CHECKING:  # loaded only where a rule is asked for
    from viewgain.parcels import Rules


def run_measure(command: Measure) -> int:
    """Measure every scan and print the results as they come; a bad file is reported and does not stop the others."""
    check(command.scans, command.reading)
    _check(command)
    rules = rules_of(command)
    writer = csv.writer(sys.stdout)
    if command.csv:
        writer.writerow(_columns(command, rules))
    worst = 0
    for outcome in _results(command, rules):
        if isinstance(outcome, ViewgainError):
            print_error(outcome)
            worst = max(worst, BAD_INPUT)
            continue
        worst = max(worst, 0 if outcome.measured else NOTHING_MEASURED)
        if command.json:
            print(json.dumps(outcome.json, allow_nan=False), flush=True)
        elif command.csv:
            writer.writerows(outcome.rows)
        else:
            outcome.say()
    return worst


def _check(command: Measure) -> None:
    """Refuse options that do not go together."""
    by_lines, of_any = command.method != "likelihood", command.shape != "box"
    refused = [
        (command.json and command.csv, "both --json and --csv", "at most one of them"),
        (command.as_published and not by_lines, "--as-published", "it with --method lines or corners only"),
        (by_lines and command.fuse, f"--fuse with --method {command.method}", "--method likelihood to join scans"),
        (by_lines and of_any, f"--shape {command.shape} with --method {command.method}", "--shape box for that method"),
        (by_lines and command.reading.floor is not None, f"--floor with --method {command.method}", "no empty scene there"),
        (of_any and command.fuse, f"--fuse with --shape {command.shape}", "--shape box: only boxes are joined"),
    ]
    for wrong, got, wanted in refused:
        if wrong:
            raise ConfigError(f"got {got}, wanted {wanted}")


def _columns(command: Measure, rules: "Rules | None") -> tuple[str, ...]:
    columns: tuple[str, ...] = CSV_COLUMNS
    if command.shape != "box":
        from viewgain.cli._objects import SHAPE_COLUMNS

        columns = SHAPE_COLUMNS
    return columns if rules is None else (*columns, *BILLED_COLUMNS)


def _results(command: Measure, rules: "Rules | None") -> Iterator[Answer | ViewgainError]:
    floor = read_floor(command.reading)
    if command.fuse:
        scans = [read_one(path, index, command.reading) for index, path in enumerate(command.scans)]
        yield box_answer(fuse(scans, camera=command.reading.camera, floor=floor), rules)
        return
    answer = _way(command, floor, rules)
    for index, path in enumerate(command.scans):
        try:
            yield answer(read_one(path, index, command.reading))
        except ViewgainError as error:
            yield error


def _way(command: Measure, floor: Scan | None, rules: "Rules | None") -> Callable[[Scan], Answer]:
    """Return how one scan is measured: as boxes unless another method or shape is asked for, which is loaded only then."""
    method = command.method
    if method != "likelihood":
        from viewgain.cli._lines import lines_answer

        return lambda scan: lines_answer(scan, method, command, rules)
    if command.shape != "box":
        from viewgain.cli._objects import objects_answer

        return lambda scan: objects_answer(scan, command, floor, rules)
    return lambda scan: box_answer(measure(scan, camera=command.reading.camera, floor=floor), rules)

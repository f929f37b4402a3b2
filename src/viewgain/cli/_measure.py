"""``viewgain measure``: one result per scan, or one for all with ``--fuse``; as text, JSON lines or CSV."""

import csv
import json
import sys
from collections.abc import Iterator

from viewgain.cli._commands import Measure
from viewgain.cli._exit import BAD_INPUT, NOTHING_MEASURED, print_error
from viewgain.cli._files import check, read_floor, read_one
from viewgain.cli._text import measurement_table, to_stdout
from viewgain.errors import ConfigError, ViewgainError
from viewgain.measure import REASONS, Measurement, fuse, measure

CSV_COLUMNS = (
    "scan", "box", "length_m", "width_m", "height_m", "length_sigma_m", "width_sigma_m", "height_sigma_m", "vertical",
    "volume_m3", "volume_sigma_m3", "volume_low90_m3", "volume_high90_m3", "flags", "reason",
)  # fmt: skip


def run_measure(command: Measure) -> int:
    """Measure every scan and print the results as they come; a bad file is reported and does not stop the others."""
    check(command.scans, command.reading)
    if command.json and command.csv:
        raise ConfigError("got both --json and --csv, wanted at most one of them")
    writer = csv.writer(sys.stdout)
    if command.csv:
        writer.writerow(CSV_COLUMNS)
    worst = 0
    for outcome in _results(command):
        if isinstance(outcome, ViewgainError):
            print_error(outcome)
            worst = max(worst, BAD_INPUT)
            continue
        worst = max(worst, 0 if outcome.boxes else NOTHING_MEASURED)
        if command.json:
            print(json.dumps(outcome.to_dict(), allow_nan=False), flush=True)
        elif command.csv:
            writer.writerows(_rows(outcome))
        else:
            _say_notes(outcome)
            to_stdout(measurement_table(outcome))
    return worst


def _results(command: Measure) -> Iterator[Measurement | ViewgainError]:
    floor = read_floor(command.reading)
    if command.fuse:
        scans = [read_one(path, index, command.reading) for index, path in enumerate(command.scans)]
        yield fuse(scans, camera=command.reading.camera, floor=floor)
        return
    for index, path in enumerate(command.scans):
        try:
            yield measure(read_one(path, index, command.reading), camera=command.reading.camera, floor=floor)
        except ViewgainError as error:
            yield error


def _rows(result: Measurement) -> list[list[object]]:
    name = " + ".join(result.scans)
    if not result.boxes:
        return [[name, *[""] * (len(CSV_COLUMNS) - 2), result.reason]]
    rows: list[list[object]] = []
    for index, box in enumerate(result.boxes):
        numbers = [*box.dimensions, *box.sigma, box.vertical, box.volume, box.volume_sigma, *box.volume_interval90]
        cells = ["" if n is None else n if isinstance(n, int) else f"{n:.6g}" for n in numbers]
        rows.append([name, index, *cells, " ".join(box.flags), ""])
    return rows


def _say_notes(result: Measurement) -> None:
    for note in result.notes:
        print(f"viewgain: note: {note}", file=sys.stderr)
    if result.reason is not None:
        print(f"viewgain: {' + '.join(result.scans)}: {result.reason}: {REASONS[result.reason]}", file=sys.stderr)

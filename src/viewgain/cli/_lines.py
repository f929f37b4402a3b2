"""The paper's planes and lines (docs/lines.md), ready to be printed. Their columns are those of a box, less the error bars."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from viewgain.camera import sensor
from viewgain.cli._answer import Answer
from viewgain.cli._billing import Bills, bills_of
from viewgain.cli._boxes import CSV_COLUMNS, say_notes
from viewgain.cli._commands import Measure
from viewgain.cli._text import NAMES, to_stdout
from viewgain.planes import AS_PUBLISHED, MENDED, REASONS, LineMeasurement, Method, measure_lines
from viewgain.scans import Scan

if TYPE_CHECKING:  # loaded only where a rule is asked for
    from viewgain.parcels import Rules


def lines_answer(scan: Scan, method: Method, command: Measure, rules: "Rules | None") -> Answer:
    """Return what planes and lines make of one scan; a named camera's known scale and offset are taken off first."""
    settings = (AS_PUBLISHED if command.as_published else MENDED).using(method)
    result = measure_lines(_corrected(scan, command.reading.camera), settings)
    bills = bills_of([] if result.dimensions is None else [result.dimensions], rules)
    content = result.to_dict() | bills.json(0)
    return Answer(result.reason is None, content, [_row(result, bills)], lambda: _say(scan, result, bills))


def lines_table(result: LineMeasurement) -> Table:
    """Return the one box as a table, or the reason; the method states no error bars, and the table says so."""
    table = Table(title=result.source, title_justify="left", title_style="bold")
    for column in ("box", "quantity", "value", "± sigma", "90 % interval", "how"):
        table.add_column(column, justify="right" if column in ("value", "± sigma") else "left")
    if result.dimensions is None or result.volume is None:
        table.add_row("none", result.reason or "", "", "", "", REASONS.get(result.reason or "", ""))
        return table
    how = f"{result.method}, {result.settings}"
    for k, name in enumerate(NAMES):
        table.add_row("0" if k == 0 else "", name, f"{1000 * result.dimensions[k]:.1f} mm", "none", "none", how)
    table.add_row("", "volume", f"{1000 * result.volume:.2f} l", "none", "none", how, end_section=True)
    return table


def _corrected(scan: Scan, camera: str | None) -> Scan:
    if camera is None:
        return scan
    ranges = np.linalg.norm(scan.points, axis=1)
    return replace(scan, points=scan.points * (sensor(camera).true_ranges(ranges) / ranges)[:, None])


def _row(result: LineMeasurement, bills: Bills) -> list[object]:
    if result.dimensions is None or result.volume is None:
        return [result.source, *[""] * (len(CSV_COLUMNS) - 2), result.reason, *bills.blank()]
    known: dict[str, object] = {"scan": result.source, "box": 0, "volume_m3": f"{result.volume:.6g}"}
    known |= {f"{name}_m": f"{side:.6g}" for name, side in zip(NAMES, result.dimensions, strict=True)}
    return [*(known.get(column, "") for column in CSV_COLUMNS), *bills.cells(0)]


def _say(scan: Scan, result: LineMeasurement, bills: Bills) -> None:
    say_notes((result.source,), scan.notes, result.reason, REASONS)
    to_stdout(lines_table(result))
    bills.say("box")

"""Measured boxes, ready to be printed."""

import sys
from typing import TYPE_CHECKING

from viewgain.cli._answer import Answer
from viewgain.cli._billing import Bills, bills_of
from viewgain.cli._text import measurement_table, to_stdout
from viewgain.measure import REASONS, Measurement

if TYPE_CHECKING:  # loaded only where a rule is asked for
    from viewgain.parcels import Rules

CSV_COLUMNS = (
    "scan", "box", "length_m", "width_m", "height_m", "length_sigma_m", "width_sigma_m", "height_sigma_m", "vertical",
    "volume_m3", "volume_sigma_m3", "volume_low90_m3", "volume_high90_m3", "flags", "reason",
)  # fmt: skip


def box_answer(result: Measurement, rules: "Rules | None") -> Answer:
    """Return a measurement of boxes, ready to be printed."""
    bills = bills_of([box.dimensions for box in result.boxes], rules)
    content = result.to_dict()
    if bills.each:
        content |= {"boxes": [box.to_dict(result.world) | bills.json(index) for index, box in enumerate(result.boxes)]}
    return Answer(bool(result.boxes), content, _rows(result, bills), lambda: _say(result, bills))


def say_notes(scans: tuple[str, ...], notes: tuple[str, ...], reason: str | None, sentences: dict[str, str]) -> None:
    """Print on stderr what was decided about the scans, and why there is no result."""
    for note in notes:
        print(f"viewgain: note: {note}", file=sys.stderr)
    if reason is not None:
        print(f"viewgain: {' + '.join(scans)}: {reason}: {sentences[reason]}", file=sys.stderr)


def _rows(result: Measurement, bills: Bills) -> list[list[object]]:
    name = " + ".join(result.scans)
    if not result.boxes:
        return [[name, *[""] * (len(CSV_COLUMNS) - 2), result.reason, *bills.blank()]]
    rows: list[list[object]] = []
    for index, box in enumerate(result.boxes):
        numbers = [*box.dimensions, *box.sigma, box.vertical, box.volume, box.volume_sigma, *box.volume_interval90]
        cells = ["" if n is None else n if isinstance(n, int) else f"{n:.6g}" for n in numbers]
        rows.append([name, index, *cells, " ".join(box.flags), "", *bills.cells(index)])
    return rows


def _say(result: Measurement, bills: Bills) -> None:
    say_notes(result.scans, result.notes, result.reason, REASONS)
    to_stdout(measurement_table(result))
    bills.say("box")

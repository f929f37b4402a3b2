"""Objects of any shape (docs/shapes.md), ready to be printed: what each is, its enclosing boxes and volumes."""

from rich.table import Table

from viewgain.cli._answer import Answer
from viewgain.cli._billing import Bills
from viewgain.cli._boxes import say_notes
from viewgain.cli._commands import Measure
from viewgain.cli._text import NAMES, to_stdout
from viewgain.measure import REASONS as BOX_REASONS
from viewgain.measure import BoxEstimate
from viewgain.parcels import REASONS as OBJECT_REASONS
from viewgain.parcels import Enclosure, Estimate, Item, Items, Rules, measure_any
from viewgain.scans import Scan

REASONS = BOX_REASONS | OBJECT_REASONS


def _three(name: str, unit: str) -> tuple[str, str, str]:
    return f"{name}_{unit}", f"{name}_low90_{unit}", f"{name}_high90_{unit}"


SHAPE_COLUMNS = (
    "scan", "object", "shape", "why_no_box", "vertical",
    *_three("length", "m"), *_three("width", "m"), *_three("height", "m"), *_three("volume", "m3"),
    *_three("free_length", "m"), *_three("free_width", "m"), *_three("free_height", "m"), *_three("free_volume", "m3"),
    *_three("hull_volume", "m3"), *_three("heap_volume", "m3"), "box_likeness", "flags", "reason",
)  # fmt: skip


def objects_answer(scan: Scan, command: Measure, floor: Scan | None, rules: Rules | None) -> Answer:
    """Return all objects on the floor of one scan."""
    result = measure_any(scan, command.shape, camera=command.reading.camera, floor=floor, rules=rules)
    bills = Bills(rules, () if rules is None else tuple(item.billed for item in result.items))
    return Answer(bool(result.items), result.to_dict(), _rows(result, bills), lambda: _say(scan, result, bills))


def objects_table(result: Items) -> Table:
    """Return every object's quantities with their intervals, and the same of what was seen alone."""
    table = Table(title=" + ".join(result.scans), title_justify="left", title_style="bold")
    for column in ("object", "quantity", "value", "90 % interval", "seen part"):
        table.add_column(column, justify="right" if column in ("value", "seen part") else "left")
    if not result.items:
        table.add_row("none", result.reason or "", "", "", "")
    for index, item in enumerate(result.items):
        for k, (name, estimate) in enumerate(_quantities(item)):
            unit, digits = ("l", 2) if name.endswith("volume") else ("mm", 1)
            high = "?" if estimate.high is None else f"{1000 * estimate.high:.{digits}f}"
            value = f"{1000 * estimate.value:.{digits}f} {unit}"
            interval = f"{1000 * estimate.low:.{digits}f} to {high} {unit}"
            seen = "" if item.enclosure is None else f"{1000 * estimate.seen:.{digits}f} {unit}"
            table.add_row(str(index) if k == 0 else "", name, value, interval, seen)
        table.add_section()
    return table


def shape_in_words(item: Item) -> str:
    """Return what an object is, why it is no box, how like one it is, and its flags."""
    if item.box is not None:
        return f"a box; flags: {', '.join(item.box.flags) or 'none'}"
    why = "any shape, boxes were not tried" if item.why_no_box is None else _why(item.why_no_box)
    if item.enclosure is None:
        return why
    return f"{why}; box likeness {item.enclosure.box_likeness:.2f}; flags: {', '.join(item.enclosure.flags) or 'none'}"


def _why(reason: str) -> str:
    return f"no box ({reason}: {BOX_REASONS.get(reason, reason)})"


def _quantities(item: Item) -> list[tuple[str, Estimate]]:
    """Return name and estimate of everything that is known of an object."""
    if item.box is not None:
        return _of_box(item.box)
    return [] if item.enclosure is None else _of_enclosure(item.enclosure)


def _of_box(box: BoxEstimate) -> list[tuple[str, Estimate]]:
    sides = zip(box.dimensions, box.interval90, strict=True)
    ends = [*((float(side), *interval) for side, interval in sides), (box.volume, *box.volume_interval90)]
    names = [f"{name}{' (vertical)' if k == box.vertical else ''}" for k, name in enumerate(NAMES)]
    return [(name, Estimate(value, low, high, value)) for name, (value, low, high) in zip((*names, "volume"), ends, strict=True)]


def _of_enclosure(found: Enclosure) -> list[tuple[str, Estimate]]:
    told = []
    for kind, box in (("upright", found.upright), ("free", found.free)):
        told += [(f"{kind} {name}", estimate) for name, estimate in zip(NAMES, box.dimensions, strict=True)]
        told.append((f"{kind} volume", box.volume))
    return [*told, ("hull volume", found.hull_volume), ("heap volume", found.heap_volume)]


def _rows(result: Items, bills: Bills) -> list[list[object]]:
    name = " + ".join(result.scans)
    if not result.items:
        return [[name, *[""] * (len(SHAPE_COLUMNS) - 2), result.reason, *bills.blank()]]
    return [[name, index, *_cells(item), "", *bills.cells(index)] for index, item in enumerate(result.items)]


def _cells(item: Item) -> list[object]:
    """Return what stands between the columns ``object`` and ``reason``; what a box has not is empty."""
    numbers = [end for _, e in _quantities(item) for end in (e.value, e.low, e.high)]
    cells = ["" if number is None else f"{number:.6g}" for number in numbers]
    cells += [""] * (SHAPE_COLUMNS.index("box_likeness") - SHAPE_COLUMNS.index("length_m") - len(cells))
    flags = item.box.flags if item.box is not None else item.enclosure.flags if item.enclosure is not None else ()
    vertical = 2 if item.box is None else item.box.vertical
    likeness = "" if item.enclosure is None else f"{item.enclosure.box_likeness:.3f}"
    return [item.shape, item.why_no_box or "", vertical, *cells, likeness, " ".join(flags)]


def _say(scan: Scan, result: Items, bills: Bills) -> None:
    say_notes(result.scans, scan.notes, result.reason, REASONS)
    to_stdout(objects_table(result))
    for index, item in enumerate(result.items):
        print(f"object {index}: {shape_in_words(item)}")
    bills.say("object")

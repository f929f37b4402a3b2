"""What a confidence is worth, for people."""

from collections.abc import Mapping

from viewgain.evaluation._markdown import markdown_table
from viewgain.evaluation._quantity import Quantity
from viewgain.evaluation._selective import Kept, Selective

_KEPT = ("kept", "chance of the least sure", "within 2 points, %", "mean error, %", "the oracle's, %", "to the oracle's")
_WORTH = ("calibration error", "if all were right", "area", "by margins", "in random order", "by the truth", "gain over random")


def selective_markdown(rows: Mapping[str, Selective]) -> list[str]:
    """Return the lines of the tables of some policies by name; none without any."""
    if not rows:
        return []
    kept = [(name, *_kept(each)) for name, row in rows.items() for each in row.kept]
    most = max(len(row.bins) for row in rows.values())
    bins = [(name, *_bins(row), *[""] * (most - len(row.bins))) for name, row in rows.items()]
    worth = [(name, *_worth(row)) for name, row in rows.items()]
    return [
        "",
        "Confidence: the chance, known when choosing, that no other position is better by 2 points. Least sure left out first:",
        "",
        *markdown_table(("", *_KEPT), kept),
        "",
        "Said : found, % within 2 points (decisions), from unsure to sure:",
        "",
        *markdown_table(("", *(f"group {place + 1}" for place in range(most))), bins),
        "",
        "Calibration error: mean |said - found| of those groups. Area: share of kept decisions not within 2 points, mean over all"
        " shares kept:",
        "",
        *markdown_table(("", *_WORTH), worth),
    ]


def _bins(row: Selective) -> list[str]:
    return [f"{100 * each.said:.0f} : {100 * each.found:.0f} ({each.count})" for each in row.bins]


def _worth(row: Selective) -> tuple[str, ...]:
    areas = (_interval(row.area), _interval(row.area_by_margin), f"{row.area_at_random:.3f}", f"{row.area_by_truth:.3f}")
    return (_interval(row.calibration_error), f"{row.by_chance:.3f}", *areas, _interval(row.gain))


def _kept(each: Kept) -> tuple[str, ...]:
    ratio = f"{each.error / each.oracle:.2f}" if each.oracle > 0 else "-"
    numbers = (f"{100 * value:{form}}" for value, form in ((each.nearly, ".1f"), (each.error, ".2f"), (each.oracle, ".2f")))
    return (f"{each.share:.0%}", f"{each.least:.2f}", *numbers, ratio)


def _interval(each: Quantity) -> str:
    return f"{each.value:.3f} ({each.low:.3f} to {each.high:.3f})"

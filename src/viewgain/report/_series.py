"""Colours, hatches and lines of several networks or policies in one picture."""

from typing import Any

from viewgain.report._colours import FAINT, INK

_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#999999")
"""Okabe and Ito's set without its yellow, which is too faint on white, and a grey."""
_HATCHES = ("", "////", "....")
_LINES = ((0, (1.2, 1.2)), (0, (4, 2)), (0, ()), (0, (4, 1.5, 1, 1.5)), (0, (6, 1)), (0, (2, 1)))
"""Dashes of what is no network."""
_MARKERS = ("o", "s", "^", "D", "v", "P")


def colour_of(place: int) -> str:
    """Return the colour of the network at a place; after the last one they come again."""
    return _COLOURS[place % len(_COLOURS)]


def hatch_of(place: int) -> str:
    """Return the hatch that tells apart those of one colour."""
    return _HATCHES[place // len(_COLOURS) % len(_HATCHES)]


def plain_line(place: int) -> dict[str, Any]:
    """Return how the curve of a floor or ceiling is drawn: dashes, in black and grey."""
    return {"color": INK if place % 2 else FAINT, "linestyle": _LINES[place % len(_LINES)]}


def marked_line(place: int) -> dict[str, Any]:
    """Return how the curve of what is judged is drawn: a colour and a marker."""
    return {"color": colour_of(place), "marker": _MARKERS[place % len(_MARKERS)], "markersize": 3.5}

"""Colours and hatches of several networks in one picture."""

_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#999999")
"""Okabe and Ito's set without its yellow, which is too faint on white, and a grey."""
_HATCHES = ("", "////", "....")


def colour_of(place: int) -> str:
    """Return the colour of the network at a place; after the last one they come again."""
    return _COLOURS[place % len(_COLOURS)]


def hatch_of(place: int) -> str:
    """Return the hatch that tells apart those of one colour."""
    return _HATCHES[place // len(_COLOURS) % len(_HATCHES)]

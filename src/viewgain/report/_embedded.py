"""Pictures as the page holds them: the file itself as a data URL, with a text for those who cannot see it."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass

from viewgain.plan import NextView
from viewgain.report._truth import Compared
from viewgain.report._words import size

OVERVIEW = "dimensions.png"
"""File of the picture of all dimensions."""


@dataclass(frozen=True, slots=True)
class Picture:
    """One picture of the page."""

    file: str
    """Name of the file beside the page."""
    data: str
    """The same picture as a data URL."""
    alt: str
    """What it shows, for those who cannot see it."""
    caption: str
    """What to know to read it."""


def range_file(number: int) -> str:
    """Return the file name of the range image of view ``number``, from 1."""
    return f"view{number}_range.png"


def scene_file(number: int) -> str:
    """Return the file name of the picture in space of view ``number``, from 1."""
    return f"view{number}_scene.png"


def overview_picture(pngs: Mapping[str, bytes]) -> Picture:
    """Return the picture of all dimensions."""
    alt = "Estimates of length, width, height and volume after each view, with 90 % intervals, beside the truth."
    return _picture(pngs, OVERVIEW, alt, "What is known after each view.")


def view_pictures(pngs: Mapping[str, bytes], number: int, rows: tuple[Compared, ...], plan: NextView) -> tuple[Picture, Picture]:
    """Return the two pictures of view ``number``."""
    box = f"the fitted box of {size(rows)}" if rows else "no fitted box"
    winner = "none is chosen" if plan.best is None else f"candidate {plan.best} is ringed as the best next view"
    flat = f"Range image of view {number} with {box} and, dashed, the true box."
    space = f"View {number} in space: returns, {box} and {len(plan.candidates)} candidate cameras; {winner}."
    return (
        _picture(
            pngs, range_file(number), flat, "What the camera measured. The true box is drawn as from where it believes to be."
        ),
        _picture(
            pngs,
            scene_file(number),
            space,
            "The same scan in space with the cameras that were compared, numbered as in the table.",
        ),
    )


def _picture(pngs: Mapping[str, bytes], file: str, alt: str, caption: str) -> Picture:
    return Picture(file, "data:image/png;base64," + base64.b64encode(pngs[file]).decode(), alt, caption)

"""How every picture of this room looks: colours that colour-blind readers tell apart, sizes, and the way to PNG.

Figures are made without pyplot and without global settings, so drawing changes nothing for the program around it.
"""

import io
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap
from matplotlib.figure import Figure
from matplotlib.patheffects import AbstractPathEffect, Stroke, withStroke
from matplotlib.patheffects import Normal as Plain

FIT = "#d55e00"
"""The fitted box (vermilion of Okabe and Ito's set, as the next ones)."""
TRUTH = "#000000"
"""The true box."""
ON_BOX = "#0072b2"
"""Returns on the box."""
ON_FLOOR = "#b4b8bd"
"""Returns on the floor and elsewhere."""
INK = "#22262b"
"""Text."""
FAINT = "#6b7280"
"""Text and lines of lesser weight; still 4.8 to 1 on white."""
GRID = "#dfe3e8"
"""Lines of the floor and of diagrams."""
MISSING = "#e3e5e8"
"""Pixels without a return."""
SMALL, NORMAL, LARGE = 7.0, 8.0, 9.5
"""Font sizes, points, in figures that are shown about 5.4 inches wide."""
DOTS_PER_INCH = 200
TRUE_DASHES = (0, (3.2, 2.2))
HIDDEN_DASHES = (0, (1.6, 1.6))


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure, inches, with an Agg canvas of its own."""
    figure = Figure(figsize=(width, height), dpi=DOTS_PER_INCH, layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def to_png(figure: Figure) -> bytes:
    """Return the figure as a PNG file."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    return buffer.getvalue()


def range_colours() -> Colormap:
    """Return the colours of ranges; a missing return is light grey."""
    return mpl.colormaps["cividis"].with_extremes(bad=MISSING)


def score_colours() -> Colormap:
    """Return the colours of candidate scores, the best one dark."""
    return mpl.colormaps["viridis_r"]


def halo(width: float = 2.0, colour: str = "white") -> list[AbstractPathEffect]:
    """Return the effect that sets a text off from what lies under it."""
    return [withStroke(linewidth=width, foreground=colour)]


def line_halo(width: float, colour: str = "white") -> list[AbstractPathEffect]:
    """Return the effect that sets a line off from what lies under it; ``width`` is that of line and rim together."""
    return [Stroke(linewidth=width, foreground=colour), Plain()]


def plain_axes(axes: Axes, x_label: str, y_label: str) -> None:
    """Give axes labels, small ticks and a light frame."""
    axes.set_xlabel(x_label, fontsize=NORMAL, color=FAINT)
    axes.set_ylabel(y_label, fontsize=NORMAL, color=FAINT)
    axes.tick_params(labelsize=SMALL, colors=FAINT, length=2.5, width=0.6)
    for spine in axes.spines.values():
        spine.set(color=FAINT, linewidth=0.6)


def title(axes: Axes, text: str) -> None:
    """Write the one line that says what the picture shows."""
    axes.set_title(text, loc="left", fontsize=LARGE, fontweight="bold", color=INK, pad=7)


def colour_bar(figure: Figure, mappable: Any, axes: Axes, label: str, **settings: Any) -> Any:
    """Add a colour bar beside ``axes`` and return it."""
    bar = figure.colorbar(mappable, ax=axes, fraction=0.045, pad=0.02, aspect=26, **settings)
    bar.set_label(label, fontsize=NORMAL, color=FAINT)
    bar.ax.tick_params(labelsize=SMALL, colors=FAINT, length=2.5, width=0.6)
    bar.outline.set(linewidth=0)
    return bar


def legend_below(figure: Figure, handles: list[Any], columns: int) -> None:
    """Put the legend under the picture, where it hides nothing."""
    figure.legend(
        handles=handles, loc="outside lower center", ncols=columns, fontsize=SMALL, frameon=False, labelcolor=INK,
        handlelength=2.4, columnspacing=1.6, handletextpad=0.6,
    )  # fmt: skip

"""How every picture of this room is drawn: figures, lines, texts, legends, and the way to PNG.

Figures are made without pyplot and without global settings, so drawing changes nothing for the program around it.
"""

import io
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import AbstractPathEffect, Stroke, withStroke
from matplotlib.patheffects import Normal as Plain
from PIL import Image as Pillow

from viewgain.arrays import Array
from viewgain.report._colours import FAINT, INK, LARGE, MISSING, NORMAL, SMALL, TRUTH

WIDTH = 5.4
"""Of a figure, inches."""
AXES_WIDTH = 4.35
"""Of the part of a figure between colour bar and left border, inches."""
DOTS_PER_INCH = 200


def new_figure(width: float = WIDTH, height: float = 4.0) -> Figure:
    """Return an empty figure, inches, with an Agg canvas of its own."""
    figure = Figure(figsize=(width, height), dpi=DOTS_PER_INCH, layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def fit_height(figure: Figure, axes: Axes, *, legend_rows: int, details: int = 0) -> None:
    """Give a figure with one picture of equal scales the height it needs with its title, ``details`` lines and legend."""
    width, height = (abs(high - low) for low, high in (axes.get_xlim(), axes.get_ylim()))
    names, wide = (0.4, AXES_WIDTH - 0.25) if axes.axison else (0.0, AXES_WIDTH)
    figure.set_figheight(0.56 + names + 0.17 * legend_rows + 0.153 * details + wide * min(height / width, 1.25))


def to_png(figure: Figure) -> bytes:
    """Return the figure as a PNG file."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    return buffer.getvalue()


def side_by_side(pngs: Sequence[bytes]) -> bytes:
    """Return PNG pictures beside each other in one, on white, tops in line."""
    if len(pngs) == 1:
        return pngs[0]
    pictures = [Pillow.open(io.BytesIO(png)).convert("RGB") for png in pngs]
    sheet = Pillow.new("RGB", (sum(p.width for p in pictures), max(p.height for p in pictures)), "white")
    left = 0
    for picture in pictures:
        sheet.paste(picture, (left, 0))
        left += picture.width
    buffer = io.BytesIO()
    sheet.save(buffer, format="PNG")
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


def true_line() -> dict[str, Any]:
    """Return how the edges of the true box are drawn."""
    dashes = (0, (2.6, 2.4))
    return {
        "color": TRUTH,
        "linewidth": 0.8,
        "linestyle": dashes,
        "path_effects": line_halo(1.7, "black"),
        "dash_capstyle": "butt",
    }


def write(axes: Axes, place: Array, text: str, **style: Any) -> None:
    """Write a text at (2,) ``place``."""
    axes.text(float(place[0]), float(place[1]), text, **style)


def dots(axes: Axes, places: Array, size: float, colour: str, **style: Any) -> None:
    """Draw a dot of ``size`` square points at each of (..., 2) ``places``."""
    axes.scatter(places[..., 0], places[..., 1], s=size, color=colour, **style)


def plain_axes(axes: Axes, x_label: str, y_label: str) -> None:
    """Give axes labels, small ticks and a light frame."""
    axes.set_xlabel(x_label, fontsize=NORMAL, color=FAINT)
    axes.set_ylabel(y_label, fontsize=NORMAL, color=FAINT)
    axes.tick_params(labelsize=SMALL, colors=FAINT, length=2.5, width=0.6)
    for spine in axes.spines.values():
        spine.set(color=FAINT, linewidth=0.6)


def percent(share: float) -> str:
    """Return a share as a percentage with as many digits as it needs: 3.5 %."""
    return f"{round(100 * share, 2):g} %".replace("-", "−")


def title(axes: Axes, text: str, details: Sequence[str] = ()) -> None:
    """Write the line that says what the picture shows, and any lines of detail under it."""
    axes.set_title(text, loc="left", fontsize=LARGE, fontweight="bold", color=INK, pad=7 + 11 * len(details))
    for index, line in enumerate(reversed(details)):
        axes.annotate(
            line, (0, 1), (0, 5 + 11 * index), xycoords="axes fraction", textcoords="offset points", fontsize=NORMAL, color=INK
        )


def colour_bar(figure: Figure, mappable: Any, axes: Axes, label: str, **settings: Any) -> Any:
    """Add a colour bar as high as ``axes`` beside it and return it."""
    bar = figure.colorbar(mappable, cax=axes.inset_axes((1.025, 0.0, 0.032, 1.0)), **settings)
    bar.set_label(label, fontsize=NORMAL, color=FAINT)
    bar.ax.tick_params(labelsize=SMALL, colors=FAINT, length=2.5, width=0.6)
    bar.outline.set(linewidth=0)
    return bar


def key(label: str, **style: Any) -> Line2D:
    """Return one line of a legend."""
    return Line2D([], [], label=label, **style)


def legend_below(figure: Figure, handles: Sequence[Any], columns: int) -> int:
    """Put the legend under the picture, where it hides nothing; return its number of rows."""
    figure.legend(
        handles=list(handles),
        loc="outside lower center",
        ncols=columns,
        fontsize=SMALL,
        frameon=False,
        labelcolor=INK,
        handlelength=2.4,
        columnspacing=1.6,
        handletextpad=0.6,
    )
    return -(-len(handles) // columns)

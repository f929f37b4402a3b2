"""How the dimensions and the volume became known: estimate and 90 % interval after each view, against the truth."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from viewgain.report._style import FAINT, FIT, GRID, INK, NORMAL, SMALL, halo, legend_below, new_figure, plain_axes
from viewgain.report._truth import SIDES, Compared
from viewgain.report._units import Unit

TRUE = "#0072b2"
"""The line of the truth."""
FAR = 6.0
"""An interval over this many times longer than what the bounded ones and the truth span leaves the panel as an arrow."""


def dimensions_figure(steps: Sequence[tuple[Compared, ...]], truths: Sequence[float], units: Sequence[Unit]) -> Figure:
    """Return four panels: length, width, height and volume.

    Args:
        steps: What was measured after each view, each four entries or none.
        truths: The four true values, metres and cubic metres.
        units: The four units to print them in.
    """
    figure = new_figure(8.0, 2.65)
    panels = figure.subplots(1, 4)
    signs: set[str] = set()
    for index, (axes, name) in enumerate(zip(panels, (*SIDES, "Volume"), strict=True)):
        rows = [step[index] if step else None for step in steps]
        signs |= _draw_panel(axes, rows, truths[index], units[index])
        axes.set_title(name, loc="left", fontsize=NORMAL + 1, fontweight="bold", color=INK, pad=5)
        axes.set_title(f"truth {units[index].number(truths[index])}", loc="right", fontsize=SMALL, color=TRUE, pad=5)
    handles = [
        Line2D([], [], marker="o", linestyle="", color=FIT, markersize=4, label="estimate with 90 % interval"),
        Line2D([], [], color=TRUE, linewidth=1.2, label="truth"),
    ]
    if "bound" in signs:
        handles.append(
            Line2D([], [], marker="^", linestyle="", color=FIT, markerfacecolor="white", markersize=5, label="lower bound")
        )
    if "beyond" in signs:
        handles.append(
            Line2D(
                [], [], marker="^", linestyle="", color=FIT, markersize=5, label="goes on outside the panel, or nothing bounds it"
            )
        )
    if not all(steps):
        handles.append(Line2D([], [], marker="x", linestyle="", color=FAINT, markersize=5, label="not measured"))
    legend_below(figure, handles, len(handles))
    return figure


def _draw_panel(axes: Axes, rows: Sequence[Compared | None], truth: float, unit: Unit) -> set[str]:
    """Draw one panel; return which special signs it holds: bound, beyond."""
    low, high = _span(rows, truth)
    signs: set[str] = set()
    axes.set_ylim(low * unit.per_metre, high * unit.per_metre)
    axes.set_xlim(0.5, len(rows) + 0.5)
    plain_axes(axes, "after view", unit.name)
    axes.grid(axis="y", color=GRID, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_xticks(range(1, len(rows) + 1))
    axes.yaxis.set_major_locator(MaxNLocator(5))
    axes.axhline(truth * unit.per_metre, color=TRUE, linewidth=1.2, zorder=2)
    for number, row in enumerate(rows, start=1):
        if row is None:
            axes.plot(number, 0.04, "x", color=FAINT, markersize=5, transform=axes.get_xaxis_transform())
        else:
            signs |= _draw_interval(axes, number, row, unit, (low, high))
    return signs


def _draw_interval(axes: Axes, number: int, row: Compared, unit: Unit, span: tuple[float, float]) -> set[str]:
    """Draw one estimate; ends beyond the panel become arrow heads, an estimate beyond it is written as a number."""
    signs: set[str] = set()
    low, high = span
    bottom, top = max(row.low, low), high if row.high is None else min(row.high, high)
    if bottom < top:
        axes.plot(
            [number, number],
            [bottom * unit.per_metre, top * unit.per_metre],
            color=FIT,
            linewidth=1.4,
            solid_capstyle="butt",
            zorder=3,
        )
    for end, cut, head in ((row.low, row.low < low, "v"), (row.high, row.high is None or row.high > high, "^")):
        if cut:
            signs.add("beyond")
            axes.plot(
                number,
                0.0 if head == "v" else 1.0,
                head,
                color=FIT,
                markersize=5,
                clip_on=False,
                transform=axes.get_xaxis_transform(),
                zorder=4,
            )
        elif end is not None:
            axes.plot(number, end * unit.per_metre, "_", color=FIT, markersize=7, markeredgewidth=1.4, zorder=3)
    if low <= row.value <= high:
        signs |= {"bound"} if row.is_open else set()
        face = "white" if row.is_open else FIT
        axes.plot(
            number,
            row.value * unit.per_metre,
            "^" if row.is_open else "o",
            color=FIT,
            markerfacecolor=face,
            markersize=5,
            zorder=5,
        )
    else:
        text = f"{'≥ ' if row.is_open else ''}{unit.number(row.value)}"
        aside, place = (6, "left") if number == 1 else (-6, "right")
        axes.annotate(text, (number, 0.08 if row.value < low else 0.92), (aside, 0), xycoords=axes.get_xaxis_transform(), textcoords="offset points",
                      fontsize=SMALL, color=INK, ha=place, va="center", path_effects=halo(), zorder=6)  # fmt: skip
    return signs


def _span(rows: Sequence[Compared | None], truth: float) -> tuple[float, float]:
    """Return the values that a panel shows: truth and intervals, but not the long ones where short ones are there to see."""
    ends = [
        (min(row.low, truth), max(row.value if row.high is None else row.high, row.value, truth))
        for row in rows
        if row is not None
    ]
    shortest = min((high - low for low, high in ends), default=0.0)
    shown = [(low, high) for low, high in ends if high - low <= FAR * shortest]
    low, high = min((end[0] for end in shown), default=truth), max((end[1] for end in shown), default=truth)
    margin = max(0.12 * (high - low), 0.002 * truth) if shown else 0.05 * truth
    return low - margin, high + margin

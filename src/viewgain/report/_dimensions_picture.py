"""How the dimensions and the volume became known: estimate and 90 % interval after each view, against the truth."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from viewgain.report._colours import FAINT, FIT, GRID, INK, NORMAL, SMALL
from viewgain.report._style import halo, key, legend_below, new_figure, plain_axes
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
        key("estimate with 90 % interval", marker="o", linestyle="", color=FIT, markersize=4),
        key("truth", color=TRUE, linewidth=1.2),
    ]
    if "bound" in signs:
        handles.append(key("lower bound", marker="^", linestyle="", color=FIT, markerfacecolor="white", markersize=5))
    if "beyond" in signs:
        handles.append(key("goes on outside the panel, or nothing bounds it", marker="^", linestyle="", color=FIT, markersize=5))
    if not all(steps):
        handles.append(key("not measured", marker="x", linestyle="", color=FAINT, markersize=5))
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
    low, high = span
    signs: set[str] = set()
    bottom, top = max(row.low, low), high if row.high is None else min(row.high, high)
    if bottom < top:
        ends = (bottom * unit.per_metre, top * unit.per_metre)
        axes.plot([number, number], ends, color=FIT, linewidth=1.4, solid_capstyle="butt", zorder=3)
    for end, beyond, edge, head in (
        (row.low, row.low < low, 0.0, "v"),
        (row.high, row.high is None or row.high > high, 1.0, "^"),
    ):
        if beyond:
            signs.add("beyond")
            place = axes.get_xaxis_transform()
            axes.plot(number, edge, head, color=FIT, markersize=5, clip_on=False, zorder=4, transform=place)
        elif end is not None:
            axes.plot(number, end * unit.per_metre, "_", color=FIT, markersize=7, markeredgewidth=1.4, zorder=3)
    if low <= row.value <= high:
        signs |= {"bound"} if row.is_open else set()
        sign, face = ("^", "white") if row.is_open else ("o", FIT)
        axes.plot(number, row.value * unit.per_metre, sign, color=FIT, markerfacecolor=face, markersize=5, zorder=5)
    else:
        _write_value(axes, number, row, unit, 0.08 if row.value < low else 0.92)
    return signs


def _write_value(axes: Axes, number: int, row: Compared, unit: Unit, height: float) -> None:
    """Write an estimate beside its bar, at a share of the panel's height."""
    aside, place = (6, "left") if number == 1 else (-6, "right")
    text = axes.annotate(
        f"{'≥ ' if row.is_open else ''}{unit.number(row.value)}",
        (number, height),
        (aside, 0),
        xycoords=axes.get_xaxis_transform(),
        textcoords="offset points",
        horizontalalignment=place,
        verticalalignment="center",
    )
    text.set(fontsize=SMALL, color=INK, path_effects=halo(), zorder=6)


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

"""Table 1 as a picture: one panel per table, the networks' shares as bars with intervals, floors as dashed lines."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from viewgain.evaluation import COLUMNS, CONSTANT, RESERVED, UNIFORM, Row, Table1
from viewgain.report._colours import FAINT, GRID, INK, NORMAL, SMALL
from viewgain.report._series import colour_of, hatch_of
from viewgain.report._style import key, legend_below, new_figure, plain_axes, title

_FLOORS = {CONSTANT: (INK, (0, (4, 2))), UNIFORM: (FAINT, (0, (1.2, 1.2)))}
"""Colour and dashes of each floor."""
_PANEL = 2.6
"""Height, inches."""


def table1_figure(tables: Sequence[Table1]) -> Figure:
    """Return the picture of some tables, at least one; without networks only the floors are there."""
    names = list(dict.fromkeys(row.name for table in tables for row in _networks(table)))
    figure = new_figure(width=7.2, height=_PANEL * len(tables) + 0.6)
    for axes, table in zip(figure.subplots(len(tables), 1, squeeze=False)[:, 0], tables, strict=True):
        _panel(axes, table, names)
    handles = [Patch(facecolor=colour_of(k), hatch=hatch_of(k), edgecolor="white", label=name) for k, name in enumerate(names)]
    floors = [key(name, color=colour, linestyle=dashes, linewidth=1.2) for name, (colour, dashes) in _FLOORS.items()]
    legend_below(figure, [*handles, *floors], 3)
    return figure


def _panel(axes: Axes, table: Table1, names: Sequence[str]) -> None:
    places = np.arange(len(COLUMNS))
    rows = _networks(table)
    width = 0.8 / max(len(rows), 1)
    for number, row in enumerate(rows):
        mean, low, high = (100 * np.array(each) for each in (row.shares.mean, row.shares.low, row.shares.high))
        left = places - 0.4 + (number + 0.5) * width
        which = names.index(row.name)
        axes.bar(
            left, mean, 0.9 * width, color=colour_of(which), hatch=hatch_of(which), edgecolor="white", linewidth=0.0, zorder=2
        )
        reach = np.maximum(np.stack([mean - low, high - mean]), 0.0)
        axes.errorbar(left, mean, yerr=reach, fmt="none", ecolor=INK, elinewidth=0.8, capsize=1.5, zorder=4)
    by_name = {row.name: row for row in table.rows}
    for name, (colour, dashes) in _FLOORS.items():
        if name in by_name:
            levels = 100 * np.array(by_name[name].shares.mean)
            for place, level in zip(places, levels, strict=True):
                axes.plot([place - 0.45, place + 0.45], [level, level], color=colour, linestyle=dashes, linewidth=1.2, zorder=3)
    axes.set_ylim(0, 100)
    axes.set_xlim(-0.55, len(COLUMNS) - 0.45)
    axes.grid(axis="y", color=GRID, linewidth=0.6, zorder=0)
    plain_axes(axes, "", "per cent of samples")
    axes.set_xticks(places, COLUMNS, fontsize=NORMAL, color=INK)
    axes.tick_params(axis="y", labelsize=SMALL)
    details = f"{table.objects:,} objects, {table.samples:,} samples; 95 % intervals by object"
    title(axes, f"{table.title}, {table.frame} frame", [details])


def _networks(table: Table1) -> list[Row]:
    """Return what networks got: of several seeds their mean alone."""
    return [row for row in table.rows if row.name not in RESERVED and row.within is None]

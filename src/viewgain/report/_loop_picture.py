"""Volume error view after view: a curve per policy, with intervals, and the tolerance."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from viewgain.evaluation import LOOP_FLOORS, LoopTable
from viewgain.report._colours import FAINT, GRID, INK, SMALL
from viewgain.report._series import marked_line, plain_line
from viewgain.report._style import key, legend_below, new_figure, percent, plain_axes, title

_APART = 0.03
"""Between the intervals of two curves, views, so that none hides another."""


def loop_figure(table: LoopTable) -> Figure:
    """Return the picture of a closed loop: mean |V / V* - 1| against the number of views, on a logarithmic scale."""
    curves = {row.name: row.errors for row in table.rows if row.errors is not None}
    plain = [name for name in curves if name in LOOP_FLOORS]
    judged = [name for name in curves if name not in LOOP_FLOORS]
    styles = {name: plain_line(k) for k, name in enumerate(plain)} | {name: marked_line(k) for k, name in enumerate(judged)}
    figure = new_figure(width=6.4, height=4.0)
    axes = figure.subplots()
    views = np.arange(1, table.settings.most_views + 1)
    axes.axhline(100 * table.settings.tolerance, color=FAINT, linewidth=0.8)
    axes.annotate(
        f"tolerance {percent(table.settings.tolerance)}",
        (1, 100 * table.settings.tolerance), xycoords=("axes fraction", "data"), xytext=(-3, 2), textcoords="offset points",
        ha="right", fontsize=SMALL, color=INK,
    )  # fmt: skip
    for place, (name, errors) in enumerate(curves.items()):
        mean, low, high = (100 * np.array(each) for each in (errors.mean, errors.low, errors.high))
        spots = views + _APART * (place - (len(curves) - 1) / 2)
        axes.plot(spots, mean, linewidth=1.2, **styles[name])
        axes.vlines(spots, low, high, color=styles[name]["color"], linewidth=0.7)
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.grid(axis="y", color=GRID, linewidth=0.6)
    plain_axes(axes, "views taken", "mean volume error |V / V* − 1|, per cent")
    asked = table.settings.boxes
    title(axes, "Closed loop", [f"{table.boxes:,} fresh boxes, rig {asked.rig}, camera {asked.camera}; 95 % intervals by box"])
    legend_below(figure, [key(name, linewidth=1.2, **styles[name]) for name in curves], 3)
    return figure

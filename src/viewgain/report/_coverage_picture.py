"""Coverage view after view: one panel per table, a curve per policy."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from viewgain.evaluation import POLICIES, CoverageTable
from viewgain.report._colours import GRID
from viewgain.report._series import marked_line, plain_line
from viewgain.report._style import key, legend_below, new_figure, plain_axes, title


def coverage_figure(tables: Sequence[CoverageTable]) -> Figure:
    """Return the picture of some tables, at least one: coverage by union against the number of views."""
    names = list(dict.fromkeys(row.policy for table in tables for row in table.rows))
    networks = [name for name in names if name not in POLICIES]
    plain = [name for name in names if name in POLICIES]
    styles = {name: plain_line(k) for k, name in enumerate(plain)} | {name: marked_line(k) for k, name in enumerate(networks)}
    figure = new_figure(width=6.4, height=3.0 * len(tables) + 0.6)
    for axes, table in zip(figure.subplots(len(tables), 1, squeeze=False)[:, 0], tables, strict=True):
        views = np.arange(1, table.steps + 1)
        for row in table.rows:
            if row.rule == "union":
                axes.plot(views, 100 * np.array(row.coverage), linewidth=1.2, **styles[row.policy])
        axes.grid(axis="y", color=GRID, linewidth=0.6)
        plain_axes(axes, "views taken", "surface covered, per cent")
        title(axes, f"{table.title}, {table.views} candidate views", [f"mean of {table.objects:,} objects, by union"])
    legend_below(figure, [key(name, linewidth=1.2, **styles[name]) for name in names], 3)
    return figure

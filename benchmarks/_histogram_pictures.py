"""Histograms of volume error, a row per box and a column per position: the paper's Fig. 8."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from viewgain.arrays import Array
from viewgain.report._colours import FAINT, INK, SMALL
from viewgain.report._style import plain_axes, to_png

_LIMIT, _BINS = 0.5, 41
_COLOUR = "#0072b2"


def error_histograms(errors: Mapping[int, Array], estimator: str, path: Path) -> None:
    """Draw the (V, n) errors of each box; those beyond the limit fall into the outermost bins, and misses are said in words."""
    positions = len(next(iter(errors.values())))
    figure = Figure(figsize=(2.1 * positions, 0.95 * len(errors) + 0.8), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(len(errors), positions, sharex=True, sharey="row", squeeze=False)
    edges = np.linspace(-_LIMIT, _LIMIT, _BINS + 1)
    for place, (row, (number, own)) in enumerate(zip(grid, errors.items(), strict=True)):
        for position, (axes, view) in enumerate(zip(row, own, strict=True)):
            found = view[np.isfinite(view)]
            plain_axes(axes, "volume error, %" if place == len(grid) - 1 else "", f"box {number}\nshare" if position == 0 else "")
            axes.hist(
                100 * np.clip(found, -_LIMIT, _LIMIT), 100 * edges, weights=np.full(len(found), 1 / len(view)), color=_COLOUR
            )
            axes.axvline(0, color=INK, linewidth=0.6)
            axes.text(0.98, 0.9, f"no estimate {1 - len(found) / len(view):.0%}", transform=axes.transAxes, ha="right", va="top",
                      fontsize=SMALL, color=FAINT)  # fmt: skip
            if place == 0:
                axes.set_title(f"position {position}", fontsize=SMALL, color=INK)
    figure.suptitle(f"Volume error by {estimator.replace('_', ', ')}; outermost bins: beyond 50 %", fontsize=SMALL + 1, color=INK)
    path.write_bytes(to_png(figure))

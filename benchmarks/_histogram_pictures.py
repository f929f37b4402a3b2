"""Histograms of volume error as labels count them, a row per box and a column per position: the paper's Fig. 8."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from viewgain.arrays import Array
from viewgain.gain import SOFT, ErrorHistogram
from viewgain.report._colours import FAINT, FIT, INK, NORMAL, ON_BOX, SMALL
from viewgain.report._style import plain_axes, to_png

_DOTS_PER_INCH = 150


def error_histograms(errors: Mapping[int, Array], estimator: str, path: Path) -> None:
    """Draw the (V, n) errors of each box in the bins of a histogram, and frame the position that the label ``soft`` chooses."""
    positions = len(next(iter(errors.values())))
    figure = Figure(figsize=(2.1 * positions, 0.95 * len(errors) + 1.0), dpi=_DOTS_PER_INCH, layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(len(errors), positions, sharex=True, sharey="row", squeeze=False)
    for place, (row, (number, own)) in enumerate(zip(grid, errors.items(), strict=True)):
        histogram = ErrorHistogram.from_errors(own)
        chosen = int(np.argmax(SOFT.gains(histogram)))
        for position, axes in enumerate(row):
            below, beside = place == len(grid) - 1, position == 0
            plain_axes(axes, "volume error, %" if below else "", f"box {number}\nscans, %" if beside else "")
            _draw(axes, histogram, position)
            if position == chosen:
                axes.spines[:].set(color=INK, linewidth=2.0, zorder=3)
            if place == 0:
                axes.set_title(f"position {position}", fontsize=NORMAL, color=INK)
        row[0].set_ylim(0, max(1.35 * row[0].get_ylim()[1], 1))  # room for the words
    figure.suptitle(
        f"Volume error by {estimator.replace('_', ', ')}: {histogram.scans:,} scans of each box from each position\n"
        f"orange: the bin about zero (±{50 * histogram.rule.width:g} %); dark frame: most scans there, or in as few bins more as"
        " it takes; outermost bins: all errors beyond",
        fontsize=NORMAL, color=INK,
    )  # fmt: skip
    path.write_bytes(to_png(figure))


def _draw(axes: Axes, histogram: ErrorHistogram, position: int) -> None:
    """Draw one position: its bins, the middle one in another colour, and in words what the eye may miss."""
    width, middle, scans = histogram.rule.width, histogram.rule.middle, histogram.scans
    share = 100 * histogram.counts[position] / scans
    centres = 100 * width * (np.arange(len(share)) - middle)
    colours = [FIT if place == middle else ON_BOX for place in range(len(share))]
    axes.bar(centres, share, width=100 * width, color=colours, edgecolor="white", linewidth=0.3, zorder=4)  # over the frame
    axes.axvline(0, color=FAINT, linewidth=0.6, zorder=0)
    words = (f"near zero {share[middle]:.0f} %", f"no estimate {100 * histogram.missed[position] / scans:.0f} %")
    for height, line in zip((0.95, 0.76), words, strict=True):
        axes.text(0.98, height, line, transform=axes.transAxes, ha="right", va="top", fontsize=SMALL, color=INK,
                  bbox={"color": "white", "pad": 0.6, "linewidth": 0})  # fmt: skip

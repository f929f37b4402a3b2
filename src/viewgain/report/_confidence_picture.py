"""What a confidence is worth: risk by the share of decisions kept, and how often what was said is found."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from viewgain.evaluation import Selective
from viewgain.report._colours import FAINT, GRID, INK, NORMAL, SMALL
from viewgain.report._series import marked_line, plain_line
from viewgain.report._style import key, new_figure, plain_axes, title

_SURE, _MARGIN = marked_line(0), marked_line(1)
_RANDOM, _TRUTH = plain_line(0), plain_line(1)


def confidence_figure(worth: Selective, what: str) -> Figure:
    """Return the picture of one policy's confidence; ``what`` says whose decisions on which boxes."""
    figure = new_figure(width=7.2, height=3.6)
    left, right = figure.subplots(1, 2)
    _risks(left, worth)
    _reliability(right, worth)
    figure.suptitle(f"How sure a decision is: {what}", x=0.01, horizontalalignment="left", fontsize=NORMAL, color=INK)
    title(left, "Leaving out the least sure")
    title(right, "Said and found")
    handles = [
        key("by the chance", **_SURE),
        key("by the margin to the next best", **_MARGIN),
        key("in random order", **_RANDOM),
        key("by the truth", **_TRUTH),
        key("said = found", color=FAINT, linewidth=0.8),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=5, fontsize=SMALL, frameon=False, labelcolor=INK)
    return figure


def _risks(axes: Axes, worth: Selective) -> None:
    kept = 100 * np.array(worth.steps)
    axes.axhline(100 * worth.area_at_random, linewidth=1.0, **_RANDOM)
    for curve, style in ((worth.curve_by_truth, _TRUTH), (worth.curve_by_margin, _MARGIN), (worth.curve, _SURE)):
        axes.plot(kept, 100 * np.array(curve), linewidth=1.2, **style)
    axes.set_xlim(0, 102)
    axes.set_ylim(bottom=0)
    axes.grid(color=GRID, linewidth=0.6)
    plain_axes(axes, "decisions kept, per cent", "of those not within 2 points of the best, %")


def _reliability(axes: Axes, worth: Selective) -> None:
    said, found, low, high = (100 * np.array([(each.said, each.found, each.low, each.high) for each in worth.bins])).T
    axes.plot([0, 100], [0, 100], color=FAINT, linewidth=0.8)
    axes.vlines(said, low, high, color=_SURE["color"], linewidth=0.9)
    axes.plot(said, found, linewidth=0.0, **_SURE)
    axes.set_xlim(0, 102)
    axes.set_ylim(0, 102)
    axes.set_aspect("equal")
    axes.grid(color=GRID, linewidth=0.6)
    plain_axes(axes, "chance to be within 2 points, as said, per cent", "found, per cent (95 % intervals)")

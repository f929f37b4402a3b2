"""The curves of a training run: the loss by step, and how often the choice was the best on the validation objects."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from viewgain.report._colours import FAINT, FIT, INK, ON_BOX, SMALL
from viewgain.report._style import new_figure, plain_axes, title

_SHARES = {"exact": ("best view", FIT, "-"), "within_0.05": ("within 0.05", FIT, "--")}
"""Figures of the lower picture: name, colour, line."""


def training_figure(lines: Sequence[Mapping[str, Any]]) -> Figure:
    """Return the picture of a run's metrics; axes without a curve where there are no lines yet.

    Args:
        lines: As in metrics.jsonl: ``step`` and ``loss``, or ``step`` and ``validation``.
    """
    figure = new_figure(height=5.0)
    upper, lower = figure.subplots(2, 1, sharex=True)
    looks = [line for line in lines if "validation" in line]
    steps = [line["step"] for line in looks]
    logged = [line for line in lines if "loss" in line]
    _curve(upper, [line["step"] for line in logged], [line["loss"] for line in logged], "training", INK, "-")
    _curve(upper, steps, [line["validation"]["loss"] for line in looks], "validation", ON_BOX, "-")
    for name, (label, colour, line_style) in _SHARES.items():
        _curve(lower, steps, [line["validation"].get(name, float("nan")) for line in looks], label, colour, line_style)
    if any(line["loss"] > 0 for line in logged):
        upper.set_yscale("log")
    lower.set_ylim(0, 1)
    plain_axes(upper, "", "loss")
    upper.tick_params(which="minor", labelsize=SMALL, colors=FAINT, length=1.5, width=0.6)
    plain_axes(lower, "step", "share of validation samples")
    title(upper, "Training")
    for axes in (upper, lower):
        axes.legend(fontsize=SMALL, frameon=False)
    return figure


def _curve(axes: Axes, steps: Sequence[int], values: Sequence[float], label: str, colour: str, line_style: str) -> None:
    marker = "o" if len(steps) == 1 else None
    axes.plot(steps, values, label=label, color=colour, linestyle=line_style, linewidth=1.0, marker=marker, markersize=3)

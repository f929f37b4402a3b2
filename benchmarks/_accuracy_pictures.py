"""How good the volume is against where the camera stood and the size of the box: errors of methods, coverage of intervals."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from benchmarks._tables import bootstrap, wilson
from benchmarks.calibration import Outcome
from benchmarks.lines import Row
from benchmarks.protocol import Sample
from viewgain.arrays import Array, Mask
from viewgain.report._colours import FAINT, GRID, INK, LARGE, NORMAL, SMALL
from viewgain.report._style import key, plain_axes, to_png

AGAINST = (
    "folded azimuth, degrees\n(0 face-on, 45 edge-on)",
    "elevation, degrees\n(90 from above)",
    "distance to the\nbox's centre, m",
    "size of the box:\ncube root of volume, m",
)
"""What the four panels of a row have across."""
METHODS = {"ours": ("#d55e00", "o"), "lines, mended": ("#0072b2", "^"), "practice": ("#009e73", "s")}
"""Colour (Okabe and Ito) and marker of the methods drawn."""
_LEAST = 1e-4
"""Smaller errors are drawn here."""
_PER_GROUP = 25


def draw_methods(samples: Sequence[Sample], rows: Mapping[str, Sequence[Row]], path: Path) -> None:
    """Draw the volume error of three methods on the same scans."""
    places = np.array([[*sample.view, np.cbrt(np.prod(sample.dims))] for sample in samples])
    figure, panels = _figure(1, 3.6)
    for name, (colour, marker) in METHODS.items():
        error = np.abs([row.signed for row in rows[name]])
        for panel, place in zip(panels[0], places.T, strict=True):
            _errors(panel, place, error, colour, marker)
    _error_axis(panels[0])
    _title(figure, f"|volume error| of three methods, the same {len(samples)} scans of boxbench's protocol")
    keys = [key(name, color=colour, marker=marker, markersize=4, linewidth=1.6) for name, (colour, marker) in METHODS.items()]
    _save(figure, panels, keys, path)


def draw_outcomes(name: str, outcomes: Sequence[Outcome], path: Path) -> None:
    """Draw the volume error and the coverage of the 90 % intervals of one camera's scans."""
    found = [outcome for outcome in outcomes if outcome.reason is None]
    places = np.array([[*outcome.view, np.cbrt(outcome.truth[0])] for outcome in found])
    error = np.array([abs(outcome.estimate[0] / outcome.truth[0] - 1) for outcome in found])
    inside, whole = np.array([(outcome.inside[0], outcome.whole) for outcome in found]).T
    figure, panels = _figure(2, 5.4)
    colour, marker = METHODS["ours"]
    for column, place in enumerate(places.T):
        panels[0, column].scatter(place[~whole], np.maximum(error[~whole], _LEAST), s=9, marker="x", color=INK, linewidths=0.5)
        _errors(panels[0, column], place, error, colour, marker, dots=whole)
        _shares(panels[1, column], place, inside)
    _error_axis(panels[0])
    panels[1, 0].set_ylabel("share of the 90 % intervals\nthat hold the volume", fontsize=NORMAL, color=FAINT)
    _title(figure, f"|volume error| and coverage, {name}: the {len(found)} of {len(outcomes)} scans with a box")
    keys = [
        key("scan, box cut by the image", color=INK, marker="x", markersize=4, linestyle="none"),
        key("median |volume error|", color=colour, marker=marker, markersize=4, linewidth=1.6),
        key("coverage", color="#0072b2", marker="o", markersize=4, linewidth=1.2),
        key("right: 0.90", color=INK, linewidth=1.0, linestyle="--"),
    ]
    _save(figure, panels, keys, path)


def _figure(rows: int, height: float) -> tuple[Figure, np.ndarray]:
    figure = Figure(figsize=(9.0, height), dpi=110, layout="constrained", facecolor="white")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, len(AGAINST), sharex="col", sharey="row", squeeze=False)


def _title(figure: Figure, text: str) -> None:
    """Write what the picture shows over it."""
    figure.suptitle(text, x=0.01, horizontalalignment="left", fontsize=LARGE, fontweight="bold", color=INK)


def _groups(place: Array) -> list[Array]:
    """Return the indices of scans in order of ``place``, in equal groups of about 25."""
    return np.array_split(np.argsort(place, kind="stable"), max(round(len(place) / _PER_GROUP), 1))


def _errors(panel: Axes, place: Array, error: Array, colour: str, marker: str, *, dots: Mask | None = None) -> None:
    """Draw every scan's error (those of ``dots`` if given), and the median of groups of all; a missing volume has no dot."""
    drawn = np.isfinite(error) if dots is None else dots
    panel.scatter(place[drawn], np.maximum(error[drawn], _LEAST), s=5, color=colour, marker=marker, alpha=0.3, linewidths=0)
    counted = np.where(np.isfinite(error), error, 1.0)
    groups = _groups(place)
    at = [float(np.median(place[group])) for group in groups]
    ends = np.array([bootstrap(counted[group], np.median, draws=500) for group in groups])
    panel.fill_between(at, *np.maximum(ends.T, _LEAST), color=colour, alpha=0.22, linewidth=0)
    panel.plot(at, [np.median(counted[group]) for group in groups], color=colour, marker=marker, markersize=4, linewidth=1.6)


def _shares(panel: Axes, place: Array, inside: Mask) -> None:
    """Draw the share of intervals that hold the truth, of groups, beside the line of 0.90."""
    groups = _groups(place)
    at = np.array([float(np.median(place[group])) for group in groups])
    share = np.array([float(np.mean(inside[group])) for group in groups])
    ends = np.array([wilson(int(inside[group].sum()), len(group)) for group in groups])
    panel.axhline(0.9, color=INK, linewidth=1.0, linestyle="--")
    apart = np.maximum(np.abs(ends.T - share), 0.0)
    panel.errorbar(at, share, yerr=apart, color="#0072b2", marker="o", markersize=4, linewidth=1.2, elinewidth=1.0, capsize=2)
    panel.set_ylim(0.4, 1.03)


def _error_axis(panels: np.ndarray) -> None:
    panels[0].set(yscale="log", ylim=(0.8 * _LEAST, 1.2))
    panels[0].yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:g} %"))
    panels[0].set_ylabel("|volume error|", fontsize=NORMAL, color=FAINT)


def _save(figure: Figure, panels: np.ndarray, keys: list[object], path: Path) -> None:
    for row in panels:
        for panel in row:
            plain_axes(panel, "", panel.get_ylabel())
            panel.grid(color=GRID, linewidth=0.6)
            panel.set_axisbelow(True)
            panel.spines[["top", "right"]].set_visible(False)
    for panel, name in zip(panels[-1], AGAINST, strict=True):
        panel.set_xlabel(name, fontsize=NORMAL, color=FAINT)
    how = f"Dots: scans. Lines: groups of about {_PER_GROUP} scans, with 95 % intervals (bootstrap of medians, Wilson of shares)."
    figure.legend(
        handles=keys, loc="outside lower center", ncols=len(keys), fontsize=SMALL, frameon=False, labelcolor=INK, title=how,
        title_fontproperties={"size": SMALL},
    )  # fmt: skip
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(to_png(figure))
    print(f"{path.name}: {path.stat().st_size // 1024} kB\n")

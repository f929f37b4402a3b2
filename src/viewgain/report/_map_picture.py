"""What every position around one box is worth, as maps of the upper hemisphere: the truth, and beside it what policies believe.

Seen from above: azimuth goes around, overhead is the middle, the horizon is the rim. Each place has the colour of the position
nearest in direction, so nothing is invented between positions.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Polygon
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from viewgain.arrays import Array, Mask, Points2, Vector
from viewgain.evaluation import MEANINGS, GainMap, Meaning, best_positions
from viewgain.report._colours import FAINT, FIT, GRID, INK, MISSING, NORMAL, SMALL
from viewgain.report._map_places import RASTER, RIM, footprint, on_map, raster
from viewgain.report._style import halo, key, legend_below, line_halo, new_figure, percent, title, write

Style: TypeAlias = dict[str, Any]
"""How something is drawn."""
COLUMNS = 4
"""Maps in a row, at most."""
SIZE = 2.65
"""Of a map, inches."""
TRUTH = "truth"
"""Name of the first map."""
LEAST = 0.001
"""Smaller errors have the colour of this one: 0.1 per cent."""
_OUT_OF_REACH: Style = {"facecolor": MISSING, "edgecolor": FAINT, "hatch": "/////", "linewidth": 0.0}
_MARK: Style = {"markeredgecolor": "white", "markeredgewidth": 0.9, "linestyle": ""}
_HERE: Style = _MARK | {"marker": "^", "markersize": 7, "color": INK}
_TRUE_BEST: Style = _MARK | {"marker": "*", "markersize": 12, "color": FIT}
_AS_GOOD: Style = _MARK | {"marker": "o", "markersize": 4.5, "color": "white", "markeredgecolor": INK}
_OWN_BEST: Style = _MARK | {
    "marker": "o", "markersize": 11, "markerfacecolor": "none", "markeredgecolor": FIT, "markeredgewidth": 1.8,
}  # fmt: skip
_FOOTPRINT: Style = {"edgecolor": INK, "fill": False, "linewidth": 1.4}


@dataclass(frozen=True, slots=True, eq=False)
class _Panel:
    """One map."""

    name: str
    details: tuple[str, ...]
    meaning: Meaning
    values: Vector
    """(V,) the less the better."""
    best: int | None
    """The position that the policy takes; None for the truth, which has a sign of its own."""


def map_figure(drawn: GainMap) -> Figure:
    """Return the picture of a map: the truth first, then the policies in their order."""
    panels = _panels(drawn)
    columns = min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    figure = new_figure(width=SIZE * columns + 0.2, height=(SIZE + 1.05) * rows + 0.45)
    places, nearest, painted = raster(drawn)
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, panel in zip(grid, panels, strict=False):
        norm = _norm(panel, panels, drawn.case.reachable)
        _draw(axes, panel, drawn, norm, nearest, painted)
        _mark(axes, panel, drawn, places)
        _bar(figure, axes, panel.meaning, norm)
    for axes in grid[len(panels) :]:
        axes.set_axis_off()
    legend_below(figure, _keys(drawn), min(6, 2 * columns))
    return figure


def _panels(drawn: GainMap) -> list[_Panel]:
    truth = drawn.truth
    least = percent(float(np.round(truth.mean[truth.least], 4)))
    scans = f"mean of {drawn.case.settings.captures} scans"
    panels = [_Panel(TRUTH, (scans, f"least {least}"), "error", truth.mean, None)]
    for said in drawn.policies:
        agreed = "none" if said.correlation is None else f"{said.correlation:.2f}".replace("-", "−")
        best = "no opinion" if said.best is None else f"its best truly errs {percent(float(np.round(truth.mean[said.best], 4)))}"
        kind, file = _kind_and_file(said.name)
        details = (*file, f"rank correlation {agreed}", best)
        panels.append(_Panel(kind, details, said.meaning, said.values, said.best))
    return panels


def _kind_and_file(name: str) -> tuple[str, tuple[str, ...]]:
    """Return the kind of a policy, and below it the name of its network's file, if any: both in a line are wider than a map."""
    kind, _, file = name.partition(":")
    short = file.replace("\\", "/").rpartition("/")[2].removesuffix(".onnx")
    return kind, (short,) if short else ()


def _norm(panel: _Panel, panels: Sequence[_Panel], reachable: Mask) -> Normalize:
    """Return the scale of a map: that of all maps of its meaning, but for scores without a unit, which only it has.

    Errors go from 1 to 100 per cent, so their scale is logarithmic.
    """
    alike = [panel] if panel.meaning == "minus_score" else [each for each in panels if each.meaning == panel.meaning]
    known = np.concatenate([each.values[reachable] for each in alike])
    known = known[np.isfinite(known)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)
    if panel.meaning != "error":
        return Normalize(low, max(high, low + 1e-6))
    low = min(max(low, LEAST), 0.5)
    return LogNorm(low, max(min(high, 1.0), 1.5 * low), clip=True)


def _draw(axes: Axes, panel: _Panel, drawn: GainMap, norm: Normalize, nearest: Array, painted: Mask) -> None:
    axes.set_aspect("equal")
    axes.set_xlim(-1.16 * RIM, 1.16 * RIM)
    axes.set_ylim(-1.16 * RIM, 1.16 * RIM)
    axes.set_axis_off()
    known = drawn.case.reachable & np.isfinite(panel.values)
    image = np.ma.masked_where(~(painted & known[nearest]), panel.values[nearest])
    axes.imshow(image, cmap=mpl.colormaps["viridis"], norm=norm, origin="lower", extent=(-RIM, RIM, -RIM, RIM), zorder=1)
    hidden = painted & ~drawn.case.reachable[nearest]
    if hidden.any():
        steps = np.linspace(-RIM, RIM, RASTER)
        grey = axes.contourf(steps, steps, hidden.astype(float), levels=[0.5, 1.5], colors=[MISSING], hatches=["/////"], zorder=1)
        grey.set(edgecolor=FAINT, linewidth=0.0)
    _draw_net(axes)
    title(axes, panel.name, panel.details)


def _draw_net(axes: Axes) -> None:
    """Draw the horizon, two circles of elevation, and the azimuths around."""
    small: Style = {"fontsize": SMALL - 1, "ha": "center", "va": "center"}
    for elevation, colour in ((0.0, FAINT), (30.0, GRID), (60.0, GRID)):
        axes.add_patch(Circle((0, 0), RIM - elevation, fill=False, edgecolor=colour, linewidth=0.6, zorder=2))
        if elevation > 0:
            place = on_map(np.deg2rad([22.5]), np.deg2rad([elevation]))[0]
            write(axes, place, f"{elevation:.0f}°", color=INK, path_effects=halo(1.4), zorder=4, **small)
    for azimuth in (0, 90, 180, 270):
        place = on_map(np.deg2rad([azimuth]), np.deg2rad([-0.1 * RIM]))[0]
        write(axes, place, f"{azimuth}°", color=FAINT, **small)


def _mark(axes: Axes, panel: _Panel, drawn: GainMap, places: Points2) -> None:
    axes.add_patch(Polygon(footprint(drawn), **_FOOTPRINT, path_effects=line_halo(3.0), zorder=5))
    axes.plot(*places[drawn.case.present], **_HERE, zorder=6)
    if panel.name == TRUTH:
        axes.plot(*places[best_positions(drawn.truth)].T, **_AS_GOOD, zorder=6)
    axes.plot(*places[drawn.truth.least], **_TRUE_BEST, zorder=7)
    if panel.best is not None:
        axes.plot(*places[panel.best], **_OWN_BEST, path_effects=line_halo(3.2), zorder=8)


def _bar(figure: Figure, axes: Axes, meaning: Meaning, norm: Normalize) -> None:
    """Add a colour bar as wide as the map under it."""
    shares = meaning != "minus_score"
    bar = figure.colorbar(
        ScalarMappable(norm, mpl.colormaps["viridis"]),
        cax=axes.inset_axes((0.07, -0.07, 0.86, 0.045)),
        orientation="horizontal",
        ticks=LogLocator(subs=_steps(norm)) if isinstance(norm, LogNorm) else MaxNLocator(4),
        format=FuncFormatter(lambda share, _: percent(share)) if shares else None,
    )
    bar.ax.xaxis.set_minor_formatter(NullFormatter())
    bar.ax.minorticks_off()
    unit = {"error": ", % of the volume", "sigma_left": ",\n% of today's", "minus_score": ""}[meaning]
    bar.set_label(f"{MEANINGS[meaning]}{unit}", fontsize=NORMAL - 0.5, color=FAINT)
    bar.ax.tick_params(labelsize=SMALL, colors=FAINT, length=2.5, width=0.6)
    bar.outline.set(linewidth=0)


def _steps(norm: LogNorm) -> tuple[float, ...]:
    """Return the numbers within a decade that get a tick: as many as there is room for over all decades."""
    assert norm.vmin is not None
    assert norm.vmax is not None
    decades = np.log10(norm.vmax / norm.vmin)
    return (1.0, 2.0, 5.0) if decades < 1.7 else (1.0, 3.0) if decades < 2.7 else (1.0,)


def _keys(drawn: GainMap) -> list[Line2D | Patch]:
    handles: list[Line2D | Patch] = [
        key("present camera", **_HERE),
        key("truly best position", **_TRUE_BEST),
        key("as good as anyone can tell", **_AS_GOOD),
        key("box from above, not to scale", color=INK, linewidth=1.4, marker="s", markerfacecolor="none", linestyle=""),
    ]
    if drawn.policies:
        handles.insert(2, key("best by the policy", **_OWN_BEST))
    if not drawn.case.reachable.all():
        handles.append(Patch(**_OUT_OF_REACH, label="out of reach"))
    return handles

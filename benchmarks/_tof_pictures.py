"""Pictures of ``real-tof``: what a real camera does in one colour, what the simulator makes of it in the other."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks import _tof_measures as measures
from benchmarks import _tof_views as views
from benchmarks._tables import wilson
from benchmarks._tof_measures import Patches, Profile
from benchmarks._tof_pairs import EDGE_PX, INCIDENCES, LOSS_DEG, Pair, noise_of
from viewgain.arrays import Array
from viewgain.box import FACES, outline

REAL, SIMULATED, WITHOUT = "#d55e00", "#0072b2", "#009e73"
"""Vermilion, blue and green of Okabe and Ito."""
MISSING = "#ffffff"
_STYLE: Any = {"font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.color": "#e3e5e8"}
_NAMES = {"kinect_v2": "Kinect v2 (fau)", "sick_visionary_t": "Visionary-T (sick)", "xtion": "structured light (trai)"}


def draw(pairs: Sequence[Pair], folder: Path) -> None:
    """Write all pictures into a folder."""
    with mpl.rc_context(_STYLE):
        _noise(pairs, folder)
        _bends(pairs, folder)
        _halo(pairs, folder)
        _flying(pairs, folder)
        _missing(pairs, folder)
        for pair in pairs:
            if pair.case.title in ("fau 1", "sick"):
                _ranges(pair, folder / f"sensors-range-{pair.case.title.split()[0]}.png")


def _figure(width: float, height: float, rows: int, columns: int, **keys: Any) -> tuple[Figure, Any]:
    figure = Figure(figsize=(width, height), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, squeeze=False, **keys)


def _save(figure: Figure, path: Path) -> None:
    figure.savefig(path)
    print(f"{path.name}: {path.stat().st_size // 1024} kB")


def _legend(figure: Figure, axes: Axes) -> None:
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=6, frameon=False)


def _line(
    axes: Axes, profile: Profile | None, colour: str, label: str, *, scale: float = 1e3, along: float = 1.0, style: str = "-"
) -> None:
    if profile is None:
        return
    at = along * profile.at
    axes.fill_between(at, scale * profile.low, scale * profile.high, color=colour, alpha=0.22, linewidth=0)
    axes.plot(at, scale * profile.mean, style, color=colour, marker="o", markersize=3.5, linewidth=1.6, label=label)


def _noise(pairs: Sequence[Pair], folder: Path) -> None:
    figure, axes = _figure(10, 4.3, 1, 3)
    for panel, (camera, name) in zip(axes[0], _NAMES.items(), strict=True):
        parts = [noise_of(pair) for pair in pairs if pair.case.camera == camera]
        for colour, label, patches in (
            (REAL, "real", measures.joined([part[0] for part in parts])),
            (SIMULATED, "simulated", measures.joined([part[1] for part in parts])),
        ):
            for on_floor, where, style in (
                (False, "box", "--"),
                (True, "floor" if camera != "sick_visionary_t" else "table, wall", "-"),
            ):
                profile = _sd_profile(patches.take(patches.on_floor == on_floor), INCIDENCES)
                _line(panel, profile, colour, f"{label}, {where}", style=style)
        panel.set(title=name, xlabel="angle of incidence, degrees", xlim=(0, 80))
        panel.set_ylim(bottom=0)
        panel.legend(frameon=False, fontsize=8.5, loc="upper left")
    axes[0, 0].set_ylabel("noise of the range, mm (standard deviation\nabout small planes; bands: 95 %)")
    _save(figure, folder / "sensors-noise.png")


def _sd_profile(patches: Patches, edges: Array, least: int = 8) -> Profile | None:
    rng = np.random.default_rng(0)
    rows = []
    for low, high in pairwise(edges):
        mine = (patches.incidence_deg >= low) & (patches.incidence_deg < high)
        sds = patches.sd[mine]
        if len(sds) >= least:
            drawn = np.median(sds[rng.integers(len(sds), size=(200, len(sds)))], axis=1)
            rows.append((np.median(patches.incidence_deg[mine]), np.median(sds), *np.quantile(drawn, [0.025, 0.975])))
    return Profile(*np.array(rows).T) if rows else None


_SHOWN = (
    ("fau 1", "Kinect v2, fau 1"),
    ("fau 2", "Kinect v2, fau 2"),
    ("sick", "Visionary-T"),
    ("trai small", "structured light, trai"),
)


def _bends(pairs: Sequence[Pair], folder: Path) -> None:
    figure, axes = _figure(10, 6.6, 2, 4)
    for column, (title, name) in enumerate(_SHOWN):
        pair = next(pair for pair in pairs if pair.case.title == title)
        face = measures.side_faces(pair.setup, pair.real)[0]
        tof = pair.direct is not pair.simulated
        looks = [([pair.real], REAL, "real"), (pair.simulated, SIMULATED, "simulated")]
        looks += [(pair.direct, WITHOUT, "simulated without multipath")] if tof else []
        for several, colour, label in looks:
            _line(axes[0, column], measures.face_bend(several, face), colour, label, along=1e3)
            _line(axes[1, column], measures.floor_before(several), colour, label, along=1e3)
        incidence = float(np.median(pair.real.incidence_deg[pair.real.surface == face]))
        axes[0, column].set(title=f"{name}\nface {FACES[face % 5]}, seen at {incidence:.0f}°", xlabel="height over the floor, mm")
        axes[1, column].set(title="floor before that box", xlabel="distance from its foot, mm")
    axes[0, 0].set_ylabel("face towards the camera by, mm\n(of the plane of its upper half)")
    axes[1, 0].set_ylabel("floor too high by, mm\n(over its plane 15 to 40 cm away)")
    for panel in axes.ravel():
        panel.axhline(0, color="#22262b", linewidth=0.8)
    _legend(figure, axes[0, 0])
    _save(figure, folder / "sensors-bend.png")


def _halo(pairs: Sequence[Pair], folder: Path) -> None:
    figure, axes = _figure(8, 3.6, 1, 2, sharey=True)
    for panel, (title, name) in zip(axes[0], _SHOWN[:2], strict=True):
        pair = next(pair for pair in pairs if pair.case.title == title)
        _line(panel, measures.floor_behind([pair.real]), REAL, "real")
        _line(panel, measures.floor_behind(pair.simulated), SIMULATED, "simulated")
        panel.axhline(0, color="#22262b", linewidth=0.8)
        panel.set(title=name, xlabel="distance from the box's outline, pixels")
    axes[0, 0].set_ylabel("dark floor behind the bright box\ntoo high by, mm")
    _legend(figure, axes[0, 0])
    _save(figure, folder / "sensors-halo.png")


def _flying(pairs: Sequence[Pair], folder: Path) -> None:
    shown = (
        ("fau 1", False, "Kinect v2, fau 1, lit"),
        ("fau 1", True, "the same, in the lamp's shadow"),
        ("sick", False, "Visionary-T"),
    )
    figure, axes = _figure(10, 5.8, 2, 3, sharex=True, sharey=True)
    for column, (title, shadowed, name) in enumerate(shown):
        pair = next(pair for pair in pairs if pair.case.title == title)
        real = measures.rim(pair.real, shadowed=shadowed)
        simulated = [part for look in pair.simulated if (part := measures.rim(look, shadowed=shadowed)) is not None]
        for row, what in enumerate(("flying", "missing")):
            panel = axes[row, column]
            for parts, colour, label in (([real], REAL, "real"), (simulated, SIMULATED, "simulated")):
                found = [part for part in parts if part is not None]
                _line(panel, measures.shares_along(found, EDGE_PX, what), colour, label, scale=100)
            panel.axvline(0, color="#22262b", linewidth=0.8)
        axes[0, column].set_title(name)
        axes[1, column].set_xlabel("pixels from the outline\n(background < 0 < box)")
    axes[0, 0].set(ylabel="flying pixels, %", ylim=(-3, 103), xlim=(-8.5, 8.5), xticks=range(-8, 9, 4))
    axes[1, 0].set_ylabel("missing returns, %")
    _legend(figure, axes[0, 0])
    _save(figure, folder / "sensors-flying.png")


def _missing(pairs: Sequence[Pair], folder: Path) -> None:
    shown = (("fau 1", "Kinect v2, fau 1"), ("fau 2", "Kinect v2, fau 2"), ("sick", "Visionary-T"))
    figure, axes = _figure(10, 3.9, 1, 3, sharey=True)
    middle = (LOSS_DEG[:-1] + LOSS_DEG[1:]) / 2
    for panel, (title, name) in zip(axes[0], shown, strict=True):
        pair = next(pair for pair in pairs if pair.case.title == title)
        parts = [measures.missing_counts(look, LOSS_DEG) for look in pair.simulated]
        both = (measures.missing_counts(pair.real, LOSS_DEG), measures.summed(parts))
        enough = (both[0][1] >= 50) & (both[1][1] >= 50)
        for (lost, total), colour, label, aside in zip(both, (REAL, SIMULATED), ("real", "simulated"), (-0.6, 0.6), strict=True):
            for surface, where, mark in ((0, "box", "s"), (1, "floor", "o")):
                k = np.flatnonzero(enough[surface])
                share = lost[surface, k] / total[surface, k]
                ends = np.array([wilson(int(lost[surface, j]), int(total[surface, j])) for j in k]).reshape(-1, 2).T
                bars = 100 * np.maximum([share - ends[0], ends[1] - share], 0)
                face = "white" if where == "box" else colour
                panel.errorbar(
                    middle[k] + aside, 100 * share, bars, fmt=mark, color=colour, markerfacecolor=face, markersize=6, capsize=2,
                    label=f"{label}, {where}",
                )  # fmt: skip
        panel.set(title=name, xlabel="angle of incidence, degrees", xlim=(0, 80))
    axes[0, 0].set_ylabel("missing returns, %")
    _legend(figure, axes[0, 0])
    _save(figure, folder / "sensors-missing.png")


def _ranges(pair: Pair, path: Path) -> None:
    real, simulated = views.range_picture(pair.real), views.range_picture(pair.simulated[0])
    shape = outline(pair.setup.boxes[0]).vertices
    pixels = pair.setup.camera.project(np.column_stack([shape, np.ones(len(shape))]))
    centre, size = (pixels.max(axis=0) + pixels.min(axis=0)) / 2, 0.72 * np.ptp(pixels, axis=0).max()
    low, high = np.nanpercentile(real, [1, 97])
    colours = mpl.colormaps["cividis"].with_extremes(bad=MISSING)
    figure, axes = _figure(10, 4.3, 1, 2)
    for panel, image, name in ((axes[0, 0], real, "real"), (axes[0, 1], simulated, "simulated")):
        shown = panel.imshow(image, cmap=colours, vmin=low, vmax=high, interpolation="nearest")
        camera = {"fau 1": "Kinect v2", "sick": "Visionary-T"}[pair.case.title]
        panel.set(title=f"{camera}, {name}", xlabel="column, pixels")
        height, width = image.shape
        panel.set_xlim(max(centre[0] - size * 1.2, -0.5), min(centre[0] + size * 1.2, width - 0.5))
        panel.set_ylim(min(centre[1] + size, height - 0.5), max(centre[1] - size, -0.5))
        panel.grid(visible=False)
    axes[0, 0].set_ylabel("row, pixels")
    figure.colorbar(shown, ax=axes.ravel().tolist(), label="range, metres (white: no return)", extend="both")
    _save(figure, path)

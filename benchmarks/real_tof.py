"""Real scans against the simulator set to the same camera and pose: noise, bends, flying pixels, missing returns."""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import _tof_measures as measures
from benchmarks import _tof_views as views
from benchmarks._data import data_folder
from benchmarks._tables import markdown, wilson
from benchmarks._tof_measures import Patches, Profile
from benchmarks._tof_pairs import INCIDENCES, LOSS_DEG, Pair, noise_of
from benchmarks._tof_views import Case, Look
from viewgain.arrays import Array, Indices
from viewgain.box import FACES
from viewgain.scans import read_scan
from viewgain.simulate import Effects

SEEDS = range(4)
"""Of the simulated scans of each real one."""
CASES = (
    # The box is taken for 0.6; by the amplitude image the floor gives back a quarter of that.
    Case(file="fau_kinect2/example1.npz", title="fau 1", camera="kinect_v2", box=0.6, floor=0.15),
    Case(file="fau_kinect2/example2.npz", title="fau 2", camera="kinect_v2", box=0.6, floor=0.15),
    Case(
        file="sick_visionary_t/static_scene.pcd", title="sick", camera="sick_visionary_t", box=0.5, floor=0.5, window=5, wall=True
    ),
    Case(file="trai_tof/vedere1_small_box.ply", title="trai small", camera="xtion", box=0.5, floor=0.5, leaf=0.01),
    Case(file="trai_tof/vedere1.pcd", title="trai view 1", camera="xtion", box=0.5, floor=0.5, leaf=0.0149),
    Case(file="trai_tof/vedere2.pcd", title="trai view 2", camera="xtion", box=0.5, floor=0.5, leaf=0.0149),
    Case(file="trai_tof/vedere1_large_box.ply", title="trai large", camera="xtion", box=0.5, floor=0.5, leaf=0.01),
    Case(file="trai_tof/vedere1_large_box_down.ply", title="trai lying", camera="xtion", box=0.5, floor=0.5, leaf=0.01),
    Case(file="trai_tof/vedere1_2boxes.ply", title="trai two", camera="xtion", box=0.5, floor=0.5, leaf=0.01),
)
"""The real scans, the preset each is simulated with, and the reflectivities that are assumed."""
SHARES = ((0.5, 0.5), (0.6, 0.15), (0.8, 0.8))
"""Reflectivities of box and floor for which the bend is told."""
RANGES = np.array([0.5, 0.7, 0.9, 1.1, 1.3, 1.6, 1.9, 2.3, 2.7, 3.2])


def run(options: argparse.Namespace) -> None:
    """Print all tables; with ``--pictures`` also draw."""
    folder = data_folder()
    if folder is None:
        print("The real scans are not there (set VIEWGAIN_DATA to their folder); nothing compared.\n")
        return
    pairs = [_pair(case, folder / "real_boxes" / case.file) for case in CASES]
    for title, table in _tables(pairs):
        print(f"### {title}\n\n{table}\n")
    if options.pictures is not None:
        from benchmarks._tof_pictures import draw

        draw(pairs, Path(options.pictures))


def _pair(case: Case, file: Path) -> Pair:
    scan = read_scan(file)
    setup = views.set_up(case, scan)
    simulated = [views.simulated_look(setup, seed=seed, like=scan) for seed in SEEDS]
    direct = simulated
    if setup.sensor().kind == "tof":
        off = Effects().without("multipath")
        direct = [views.simulated_look(setup, seed=seed, like=scan, effects=off) for seed in SEEDS]
    return Pair(setup, scan, views.real_look(setup, scan), simulated, direct)


def _tables(pairs: list[Pair]) -> Iterator[tuple[str, str]]:
    organised = [pair for pair in pairs if pair.real.shape is not None]
    noise = {pair.case.title: noise_of(pair) for pair in pairs}
    yield "What took the trai clouds", _trai(pairs)
    yield "Noise, by scan", _noise_by_scan(pairs, noise)
    yield "Noise against incidence", _noise_against(pairs, noise, INCIDENCES, "incidence_deg", "{:.0f}°")
    yield "Noise against range", _noise_against(pairs, noise, RANGES, "range", "{:.1f} m")
    yield "Bend of the upright faces", _bends(pairs)
    yield "Bend by the foot for other reflectivities", _bend_shares(pairs)
    yield "The floor beside the box", _floors(organised)
    yield "Depth edges of the box", _edges(organised)
    yield "Missing returns against incidence", _missing(organised)
    yield "What the presets would be by these scans", _fits(organised, noise)


def _trai(pairs: list[Pair]) -> str:
    rows = []
    for pair in pairs:
        if pair.real.shape is None:
            focal, strength, chance = views.pixel_grid(pair.scan)
            step = f"{1e3 * views.depth_step(pair.scan):.2f}"
            rows.append(
                (pair.case.title, f"{focal:.1f}", f"{strength:.2f}", f"{chance:.2f}", step, f"{1e3 * pair.case.leaf:.1f}")
            )
    return markdown(("scan", "focal length [px]", "strength", "by chance", "depth step / z² [mm/m²]", "voxels [mm]"), rows)


def ratio(real: Array, simulated: Array, draws: int = 400) -> tuple[float, float, float]:
    """Return the ratio of two medians and its 95 % interval, by a bootstrap over patches."""
    rng = np.random.default_rng(0)
    drawn = [
        np.median(rng.choice(real, len(real))) / np.median(rng.choice(simulated, min(len(simulated), 2000))) for _ in range(draws)
    ]
    low, high = np.quantile(drawn, [0.025, 0.975])
    return float(np.median(real) / np.median(simulated)), float(low), float(high)


def _noise_by_scan(pairs: list[Pair], noise: dict[str, tuple[Patches, Patches]]) -> str:
    rows = []
    for pair in pairs:
        real, simulated = noise[pair.case.title]
        for name, on_floor in (("faces", False), ("floor", True)):
            a, b = real.take(real.on_floor == on_floor), simulated.take(simulated.on_floor == on_floor)
            if len(a.sd) < 5 or len(b.sd) < 5:
                continue
            organised = pair.real.shape is not None
            lags = tuple(f"{measures.lag_one(part):.2f}" if organised else "" for part in (a, b))
            rows.append((pair.case.title, pair.case.camera, name, len(a.sd), *_sds(a, b), *lags))
    header = ("scan", "simulated as", "on", "patches", "real [mm]", "simulated [mm]", "real / simulated", "lag 1", "simulated")
    return markdown(header, rows)


def _sds(a: Patches, b: Patches) -> tuple[str, str, str]:
    value, low, high = ratio(a.sd, b.sd)
    return f"{1e3 * np.median(a.sd):.2f}", f"{1e3 * np.median(b.sd):.2f}", f"{value:.2f} ({low:.2f} to {high:.2f})"


def _noise_against(
    pairs: list[Pair], noise: dict[str, tuple[Patches, Patches]], edges: Array, what: str, unit: str, least: int = 8
) -> str:
    rows = []
    for camera in dict.fromkeys(pair.case.camera for pair in pairs):
        mine = [noise[pair.case.title] for pair in pairs if pair.case.camera == camera]
        real, simulated = (measures.joined([part[k] for part in mine]) for k in (0, 1))
        for low, high in pairwise(edges):
            a, b = (part.take((getattr(part, what) >= low) & (getattr(part, what) < high)) for part in (real, simulated))
            if len(a.sd) >= least and len(b.sd) >= least:
                rows.append((camera, f"{unit.format(low)} to {unit.format(high)}", len(a.sd), *_sds(a, b)))
    return markdown(("camera", what.split("_")[0], "patches", "real [mm]", "simulated [mm]", "real / simulated"), rows)


def _bends(pairs: list[Pair]) -> str:
    rows = []
    for pair in pairs:
        for face in measures.side_faces(pair.setup, pair.real):
            profiles = [measures.face_bend(looks, face) for looks in ([pair.real], pair.simulated, pair.direct)]
            if pair.direct is pair.simulated:
                profiles = profiles[:2]
            cells = [_cell(profile, 0) for profile in profiles] + [""] * (3 - len(profiles))
            above = [_cell(profile, 2) for profile in profiles] + [""] * (3 - len(profiles))
            incidence = float(np.median(pair.real.incidence_deg[pair.real.surface == face]))
            rows.append((pair.case.title, FACES[face % 5], f"{incidence:.0f}°", *cells, *above))
    places = [f"{place}{what}" for place in ("foot: ", "quarter: ") for what in ("real [mm]", "simulated", "no multipath")]
    return markdown(["scan", "face", "incidence", *places], rows)


def _cell(profile: Profile | None, k: int) -> str:
    if profile is None or not np.isfinite(profile.mean[k]):
        return ""
    return f"{1e3 * profile.mean[k]:.1f} ({1e3 * profile.low[k]:.1f} to {1e3 * profile.high[k]:.1f})"


def _bend_shares(pairs: list[Pair]) -> str:
    rows = []
    for pair in pairs:
        if pair.direct is pair.simulated:
            continue
        alone = Effects.only("multipath")
        looks = [views.simulated_look(pair.setup, seed=0, like=pair.scan, effects=alone, shares=shares) for shares in SHARES]
        for face in measures.side_faces(pair.setup, pair.real):
            real = measures.face_bend([pair.real], face)
            simulated = [f"{1e3 * measures.face_bend([look], face).mean[0]:.1f}" for look in looks]
            rows.append((pair.case.title, f"face {FACES[face % 5]}, foot", _cell(real, 0), *simulated))
        simulated = [f"{1e3 * _mean(measures.floor_before([look]), 0):.1f}" for look in looks]
        rows.append((pair.case.title, "floor, 0 to 1 cm", _cell(measures.floor_before([pair.real]), 0), *simulated))
    return markdown(("scan", "where", "real [mm]", *(f"box {box}, floor {floor} [mm]" for box, floor in SHARES)), rows)


def _mean(profile: Profile | None, k: int) -> float:
    return float("nan") if profile is None else float(profile.mean[k])


def _floors(pairs: list[Pair]) -> str:
    rows = []
    for pair in pairs:
        for name, profile, places in (
            ("before the lit faces", measures.floor_before, ((0, "0 to 1 cm"), (3, "3 to 4.5 cm"), (6, "8 to 10 cm"))),
            ("behind a depth edge", measures.floor_behind, ((1, "2 to 4 px"), (4, "8 to 11 px"), (7, "20 to 26 px"))),
        ):
            real, simulated = profile([pair.real]), profile(pair.simulated)
            if real is None or simulated is None:
                continue
            for k, place in places:
                rows.append((pair.case.title, name, place, _cell(real, k), _cell(simulated, k)))
    return markdown(("scan", "where", "distance", "real [mm]", "simulated [mm]"), rows)


def _edges(pairs: list[Pair]) -> str:
    rows = []
    for pair in pairs:
        for name, shadowed in (("lit", False), ("in the lamp's shadow", True)):
            real = measures.rim(pair.real, shadowed=shadowed)
            simulated = [part for look in pair.simulated if (part := measures.rim(look, shadowed=shadowed)) is not None]
            if real is None or not simulated:
                continue
            shift = ", ".join(f"{value:.1f}" for value in real.shift_px)
            for what in ("flying", "midway", "missing"):
                cells = [_share(*measures.band_share(part, what)) for part in ([real], simulated)]
                rows.append((pair.case.title, name, what, *cells, shift))
    return markdown(("scan", "background", "within 3 px", "real [%]", "simulated [%]", "outline moved in by [px]"), rows)


def _share(mean: float, low: float, high: float) -> str:
    return f"{100 * mean:.1f} ({100 * max(low, 0.0):.1f} to {100 * high:.1f})"


def _missing(pairs: list[Pair]) -> str:
    rows = []
    for pair in pairs:
        lost, total = measures.missing_counts(pair.real, LOSS_DEG)
        lost_too, total_too = measures.summed([measures.missing_counts(look, LOSS_DEG) for look in pair.simulated])
        for surface, name in enumerate(("faces", "floor")):
            for k in np.flatnonzero((total[surface] >= 50) & (total_too[surface] >= 50)):
                counts = [(a[surface, k], b[surface, k]) for a, b in ((lost, total), (lost_too, total_too))]
                cells = [_share(a / b, *wilson(int(a), int(b))) for a, b in counts]
                bin_deg = f"{LOSS_DEG[k]:.0f}° to {LOSS_DEG[k + 1]:.0f}°"
                rows.append((pair.case.title, name, bin_deg, int(total[surface, k]), *cells))
    return markdown(("scan", "on", "incidence", "pixels", "real [%]", "simulated [%]"), rows)


def _fits(pairs: list[Pair], noise: dict[str, tuple[Patches, Patches]]) -> str:
    rows = []
    for camera in dict.fromkeys(pair.case.camera for pair in pairs):
        mine = [pair for pair in pairs if pair.case.camera == camera]
        patches = measures.joined([noise[pair.case.title][0] for pair in mine])
        free, power = noise_fit(patches)
        held, _ = noise_fit(patches, power=1.0)
        rows.append((camera, "noise at 1 m head-on, if it grows as range / cos^p, mm", _interval(free, 1e3)))
        rows.append((camera, "p", _interval(power)))
        rows.append((camera, "the first, with p held at 1, mm", _interval(held, 1e3)))
        lit = mine[0].real.amplitude is not None
        blur = _blur_misfit if lit else _edge_misfit
        fits = [(f"footprint_px {width}", blur, {"footprint_px": width}) for width in FOOTPRINTS]
        if lit:
            fits += [(f"flying_filter {share}", _missing_misfit, {"flying_filter": share}) for share in FILTERS]
        rows += [(camera, f"misfit of {name}", f"{misfit(mine, **changes):.3f}") for name, misfit, changes in fits]
        if lit:
            looks = [pair.real for pair in mine], [pair.simulated[0] for pair in mine]
            real, simulated = (measures.light_profile(part)[:4].mean() for part in looks)
            words = f"{100 * real:.1f} %, simulated {100 * simulated:.1f} %"
            rows.append((camera, "light of the box on the background 2 to 4 px away", words))
    return markdown(("camera", "what", "by the scans"), rows)


FOOTPRINTS = (1.0, 1.25, 1.5, 1.75, 2.0, 2.5)
FILTERS = (0.02, 0.03, 0.05, 0.07, 0.1)


def _interval(value: tuple[float, float, float], scale: float = 1.0) -> str:
    return "{:.2f} ({:.2f} to {:.2f})".format(*(scale * number for number in value))


def _changed(pair: Pair, seed: int = 0, **changes: Any) -> Look:
    return views.simulated_look(pair.setup, seed=seed, like=pair.scan, change=lambda preset: replace(preset, **changes))


def _blur_misfit(pairs: list[Pair], **changes: Any) -> float:
    """Return the root mean square difference of the amplitude's rise within 2 pixels of the lit edges."""
    middle = slice(4, -4)
    real, simulated = (
        measures.light_profile(looks)[middle]
        for looks in ([pair.real for pair in pairs], [_changed(pair, **changes) for pair in pairs])
    )
    return float(np.sqrt(np.mean(np.square(real - simulated))))


def _edge_misfit(pairs: list[Pair], **changes: Any) -> float:
    """Return the root mean square difference of the share of midway pixels, pixel by pixel within BAND_PX of the lit edges."""
    return _rim_misfit(pairs, "midway", np.arange(-measures.BAND_PX, measures.BAND_PX + 0.5), **changes)


def _missing_misfit(pairs: list[Pair], **changes: Any) -> float:
    """Return the root mean square difference of the share of missing pixels within BAND_PX of the lit edges."""
    return _rim_misfit(pairs, "missing", np.array([-measures.BAND_PX, measures.BAND_PX]), **changes)


def _rim_misfit(pairs: list[Pair], what: str, edges: Array, **changes: Any) -> float:
    off: list[Array] = []
    for pair in pairs:
        real = measures.rim(pair.real)
        rims = [measures.rim(_changed(pair, seed, **changes)) for seed in SEEDS]
        simulated = [part for part in rims if part is not None]
        if real is not None and simulated:
            off.append(measures.shares_along([real], edges, what).mean - measures.shares_along(simulated, edges, what).mean)
    return float(np.sqrt(np.mean(np.square(off))))


def noise_fit(patches: Patches, power: float | None = None) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return c and p of sd = c range / cos^p(incidence), each with its 95 % interval (bootstrap over patches); p may be given."""
    rng = np.random.default_rng(0)
    target = np.log(patches.sd / patches.range)
    slope = -np.log(np.cos(np.deg2rad(patches.incidence_deg)))

    def once(chosen: Indices) -> tuple[float, float]:
        if power is not None:
            return float(np.exp(np.median(target[chosen] - power * slope[chosen]))), power
        steepness, constant = np.polyfit(slope[chosen], target[chosen], 1)
        return float(np.exp(constant)), float(steepness)

    value = once(np.arange(len(target)))
    drawn = np.array([once(rng.integers(len(target), size=len(target))) for _ in range(400)])
    low, high = np.quantile(drawn, [0.025, 0.975], axis=0)
    return (value[0], float(low[0]), float(high[0])), (value[1], float(low[1]), float(high[1]))

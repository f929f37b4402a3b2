"""The public real scans: what comes out, beside what is known of them; one box in several scans; the next view."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks._data import data_folder
from benchmarks._tables import markdown, percent
from viewgain.arrays import Pose
from viewgain.cli._text import plan_words
from viewgain.geometry import inverse
from viewgain.measure import POSE_SIGMA, BoxEstimate, Measurement, fuse_measurements, measure
from viewgain.plan import CovariancePolicy, ExpectedErrorPolicy, Policy, next_view
from viewgain.plan._believed import belief_from
from viewgain.scans import read_scan

SCANS = {
    "trai_tof/vedere1_small_box.ply": "volume 0.0169-0.0175 m3",
    "trai_tof/vedere1.pcd": "the same box",
    "trai_tof/vedere2.pcd": "the same box, other view",
    "trai_tof/Vedere_1_final.pcd": "the box's points of vedere1.pcd, no floor",
    "trai_tof/Vedere_2_final.pcd": "the box's points of vedere2.pcd, no floor",
    "trai_tof/vedere1_large_box.ply": "0.73 x 0.69 x 0.38 (measured by others)",
    "trai_tof/vedere1_large_box_down.ply": "the same box, lying",
    "trai_tof/vedere1_2boxes.ply": "both",
    "fau_kinect2/example1.npz": "0.445 x 0.353 x 0.192",
    "fau_kinect2/example2.npz": "the same box",
    "sick_visionary_t/static_scene.pcd": "unknown; a carton, a mug and a third object",
    "trai_blensor/1.pcd": "0.87 x 0.60 x 0.357 (synthetic)",
}
"""Public scans (sources and licences: docs/accuracy.md) and what is known of their boxes, metres."""

VIEWS = {
    "small box": (
        0.01689,
        (
            "trai_tof/vedere1_small_box.ply",
            "trai_tof/vedere1.pcd",
            "trai_tof/vedere2.pcd",
            "trai_tof/vedere1_2boxes.ply",
        ),
    ),
    "Kinect carton": (0.445 * 0.353 * 0.192, ("fau_kinect2/example1.npz", "fau_kinect2/example2.npz")),
}
"""Boxes seen in several scans: the volume each is thought to have, cubic metres, and the scans."""


def run(options: argparse.Namespace) -> None:
    """Print one row per box, the spread over several scans of one box, then the ranking of ring8 per scan."""
    del options
    folder = data_folder()
    if folder is None:
        print("The real scans are not there (set VIEWGAIN_DATA to their folder); nothing measured.\n")
        return
    results = _measured(folder / "real_boxes")
    print("## Real scans\n\nA + marks a lower bound. Fits are by default settings: camera unknown, noise from the scan.\n")
    header = ("scan", "length x width x height [m]", "sigma [mm]", "volume [m3]", "90 % interval [m3]", "flags", "known")
    print(markdown(header, [row for name, result in results.items() for row in _rows(name, result)]))
    _print_views(results)
    _print_predicted(results)
    print("\n## Next view on them, rig ring8\n")
    plans = [row for name, result in results.items() for row in _plan(name, result)]
    print(markdown(("scan", "scores of views 0-7", "best", "it would see", "stop at 5 %, 95 %"), plans))
    print()


def _measured(folder: Path) -> dict[str, Measurement]:
    return {name: measure(read_scan(folder / name)) for name in SCANS}


def _rows(name: str, result: Measurement) -> list[tuple[str, ...]]:
    """Return a row per box, or one with the reason why there is none; what is known stands in the first."""
    if not result.boxes:
        return [(name, f"none: {result.reason}", "", "", "", "", SCANS[name])]
    known = [SCANS[name], *[""] * (len(result.boxes) - 1)]
    return [(name, *_cells(box), told) for box, told in zip(result.boxes, known, strict=True)]


def _cells(box: BoxEstimate) -> tuple[str, ...]:
    sizes = " x ".join(f"{d:.3f}{'+' if b == 'open' else ''}" for d, b in zip(box.dimensions, box.basis, strict=True))
    sigmas = ", ".join("open" if s is None else f"{1e3 * s:.1f}" for s in box.sigma)
    return sizes, sigmas, f"{box.volume:.5f}", _interval(box), ", ".join(box.flags) or "-"


def _interval(box: BoxEstimate) -> str:
    low, high = box.volume_interval90
    return f"{low:.5f} to {'open' if high is None else f'{high:.5f}'}"


def _print_views(results: dict[str, Measurement]) -> None:
    """Print what several scans of one box say of it, each alone and fused without poses."""
    print("\n### One box in several scans\n")
    print("The box of a scan is the one nearest in volume to what is thought. Spread: standard deviation over the scans.\n")
    rows = [_views_row(name, volume, [results[scan] for scan in scans]) for name, (volume, scans) in VIEWS.items()]
    header = ("box", "scans", "thought [m3]", "mean [m3]", "spread", "least to most [m3]", "90 % intervals that hold it")
    print(markdown((*header, "median half-width", "fused without poses [m3]", "holds it"), rows))


def _views_row(name: str, volume: float, results: Sequence[Measurement]) -> tuple[object, ...]:
    boxes = [box for result in results if (box := _nearest(result, volume)) is not None]
    found = np.array([box.volume for box in boxes])
    half = [np.ptp([np.inf if end is None else end for end in box.volume_interval90]) / 2 / box.volume for box in boxes]
    fused = fuse_measurements(list(results))
    both = _nearest(fused, volume)
    joint = ("-", "-") if both is None else (f"{both.volume:.5f} ({_interval(both)})", "yes" if _holds(both, volume) else "no")
    return (
        name, f"{len(boxes)} of {len(results)}", f"{volume:.5f}", f"{found.mean():.5f}",
        percent(float(found.std(ddof=1) / found.mean()), 1),
        f"{found.min():.5f} to {found.max():.5f}", f"{sum(_holds(box, volume) for box in boxes)} of {len(boxes)}",
        percent(float(np.median(half)), 1), *joint,
    )  # fmt: skip


def _print_predicted(results: dict[str, Measurement]) -> None:
    """Print whether the view that is predicted to measure best, among those that were taken, has the smallest error bar."""
    print("\n### Is the error bar of the predicted best view smaller than that of the others?\n")
    print(
        "From each scan of a box the places of its scans (found by fusing without poses) are ranked. Alone: all places, by the\n"
        "expected error of a scan from there alone. Fused: the others, by the predicted covariance after fusing. Bar: standard\n"
        "deviation of the volume over the volume, of each scan alone, or fused with the one that decides. Rows of one box that\n"
        "rank the same scans are one question, not several.\n"
    )
    rows = [
        row
        for name, (volume, scans) in VIEWS.items()
        for row in _predicted_rows(name, volume, {scan: results[scan] for scan in scans})
    ]
    print(markdown(("box", "how", "from", "ranked", "predicted", "bars", "predicted best", "its bar is the smallest"), rows))
    for how in ("alone", "fused"):
        mine = [row for row in rows if row[1] == how]
        by_chance = sum(1 / row[4].count("%") for row in mine)
        print(f"\n{how}: smallest in {sum(row[-1] == 'yes' for row in mine)} of {len(mine)} rows; {by_chance:.1f} by chance.")


@dataclass(frozen=True, slots=True, eq=False)
class _Placed:
    """A scan of a box that several show."""

    scan: str
    result: Measurement
    pose: Pose
    """(4, 4) of its camera, in a frame that all share."""
    box: BoxEstimate


def _predicted_rows(name: str, volume: float, results: dict[str, Measurement]) -> list[tuple[str, ...]]:
    """Return two rows per scan to decide by; scans whose place among the others is unknown, or volume open, are left out."""
    poses = fuse_measurements(list(results.values())).camera_poses
    known = [
        _Placed(scan, result, pose, box)
        for (scan, result), pose in zip(results.items(), poses, strict=True)
        if pose is not None and (box := _nearest(result, volume)) is not None and box.volume_sigma is not None
    ]
    rows = []
    for here in known:
        bars = [_bar(each.box) for each in known]
        rows.append(_predicted_row(name, "alone", here, known, ExpectedErrorPolicy(fused=False), bars))
        others = [each for each in known if each is not here]
        joint = [_bar(_nearest(fuse_measurements([here.result, each.result]), volume)) for each in others]
        rows.append(_predicted_row(name, "fused", here, others, CovariancePolicy(POSE_SIGMA), joint))
    return [row for row in rows if row[4].count("%") > 1]  # of one place there is nothing to choose


def _predicted_row(
    name: str, how: str, here: _Placed, ranked: Sequence[_Placed], policy: Policy, bars: Sequence[float]
) -> tuple[str, ...]:
    there = np.stack([inverse(here.pose) @ each.pose for each in ranked])
    assessed = policy.assess(belief_from(here.box), there, 0.05)
    outlooks = [each.outlook for each in assessed]
    predicted = [
        1 - each.score if after is None else after.volume_sigma / here.box.volume
        for each, after in zip(assessed, outlooks, strict=True)
    ]
    best = int(np.argmin(predicted))
    cells = (", ".join(percent(value, 1) for value in values) for values in (predicted, bars))
    names = ", ".join(Path(each.scan).stem for each in ranked)
    smallest = "yes" if bars[best] == min(bars) else "no"
    return (name, how, Path(here.scan).stem, names, *cells, Path(ranked[best].scan).stem, smallest)


def _bar(box: BoxEstimate | None) -> float:
    return np.inf if box is None or box.volume_sigma is None else box.volume_sigma / box.volume


def _nearest(result: Measurement, volume: float) -> BoxEstimate | None:
    return min(result.boxes, key=lambda box: abs(np.log(box.volume / volume)), default=None)


def _holds(box: BoxEstimate, volume: float) -> bool:
    low, high = box.volume_interval90
    return low <= volume and (high is None or volume <= high)


def _plan(name: str, result: Measurement) -> list[tuple[str, ...]]:
    """Return the row of the next view; none where no view can be ranked."""
    plan = next_view(result)
    if plan.best is None:
        return []
    best = plan.candidates[plan.best]
    seen = [sight for sight in best.assessment.prediction.sights if sight.returns >= 25]  # type: ignore[union-attr]
    faces = ", ".join(f"{sight.name} {np.rad2deg(sight.incidence):.0f}°" for sight in seen)
    scores = " ".join(f"{candidate.assessment.score:.2f}" for candidate in plan.candidates)
    return [(name, scores, f"{plan.best}: {plan_words(plan, plan.best)}", faces, "yes" if plan.stop else "no")]

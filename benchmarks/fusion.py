"""What do further views add, with poses and without? Several scans of one uncut box, fused, beside each of them alone."""

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context

import numpy as np

from benchmarks._tables import bootstrap, markdown, percent, wilson
from viewgain.arrays import Pose
from viewgain.box import Box
from viewgain.camera import Sensor, sensor
from viewgain.episodes import World
from viewgain.geometry import inverse
from viewgain.measure import POSE_SIGMA, Measurement, fuse_measurements, measure
from viewgain.scenes import Scene, SceneRanges, random_box, random_view
from viewgain.simulate import single_threads

CAMERAS = ("pico_flexx", "xtion")
PAIRS = 200
"""Scenes with two views unless ``--scenes`` says otherwise; those with more views are fewer."""
FIRST_SEED = 0
"""What is reported starts here; while the fusion was built, seeds from 100000 on were looked at."""
MARGIN_PX = 3.0
"""A box is uncut if its corners stay this far from the border of the image."""
_ANGLES = (("60 to 90", 60.0, 90.0), ("90 to 120", 90.0, 120.0), ("120 to 150", 120.0, 150.0), ("150 to 180", 150.0, 180.1),
           ("all", 0.0, 180.1))  # fmt: skip
_COLUMNS = ("scans", "results", "median volume error (95 %)", "p90", "volume in its 90 % interval", "sides in theirs")
_SETTING = f"""\
Uncut boxes of 0.1 to 0.6 m per side, elevation 15 to 60 degrees, distance 0.7 to 1.6 m, a camera without scale and offset error,
everything simulated but multipath. With poses: each off by {1000 * POSE_SIGMA[0]:.0f} mm and \
{np.rad2deg(POSE_SIGMA[1]):.1f} degrees per axis. No box counts as 100 % error. Shares with their 95 % Wilson interval.
"""
_TRIES = 40


def views_of(box: Box, azimuths_deg: list[float], camera: Sensor, rng: np.random.Generator) -> list[Pose] | None:
    """Return a view from each azimuth that has the whole outline in the image; None where 40 tries find none."""
    views = []
    for azimuth in azimuths_deg:
        drawn = (random_view(rng, box, replace(SceneRanges(), azimuth_deg=(azimuth, azimuth))) for _ in range(_TRIES))
        whole = next((view for view in drawn if _is_whole(box, view, camera)), None)
        if whole is None:
            return None
        views.append(whole)
    return views


def _is_whole(box: Box, view: Pose, camera: Sensor) -> bool:
    corners = box.in_frame(inverse(view)).corners()
    image = camera.intrinsics
    u = image.fx * corners[:, 0] / corners[:, 2] + image.cx
    v = image.fy * corners[:, 1] / corners[:, 2] + image.cy
    inside = (u > MARGIN_PX) & (v > MARGIN_PX) & (u < image.width - 1 - MARGIN_PX) & (v < image.height - 1 - MARGIN_PX)
    return bool(np.all(inside & (corners[:, 2] > 0.1)))


def azimuths(count: int, rng: np.random.Generator) -> list[float]:
    """Return where ``count`` cameras stand, degrees: two 60 to 180 apart, more of them all around, each off by up to 15."""
    first = float(rng.uniform(0, 360))
    if count == 2:
        return [first, first + float(rng.uniform(60, 180))]
    return [first + 360 * k / count + float(rng.uniform(-15, 15)) for k in range(count)]


def case(name: str, count: int, seed: int) -> tuple[Box, list[float], list[Measurement]]:
    """Return a box, the azimuths, and each scan measured alone, labelled with the pose its camera believes to be at."""
    rng = np.random.default_rng([seed, count, 29])
    camera = sensor(name).without_systematic()
    while True:
        box, at = random_box(rng), azimuths(count, rng)
        views = views_of(box, at, camera, rng)
        if views is not None:
            break
    world = World(Scene((box,)), camera)
    scans = [world.scan(world.arrive(view, rng), view, rng) for view in views]
    return box, at, [measure(scan, camera=camera) for scan in scans]


def run(options: argparse.Namespace) -> None:
    """Print the tables: pairs by angle, then three, four and eight views, with and without poses."""
    print(_SETTING)
    for name in CAMERAS:
        pairs = _cases(name, 2, options)
        print(f"## Two scans of one box, {len(pairs)} seeded pairs, camera {name}\n")
        rows = [row for label, low, high in _ANGLES for row in _rows(label, [p for p in pairs if low <= p.angle < high])]
        print(markdown(("degrees apart", *_COLUMNS), rows) + "\n")
        print(f"## More scans, camera {name}\n")
        more = {count: _cases(name, count, options) for count in (3, 4, 8)}
        rows = [row for count, cases in more.items() for row in _rows(f"{count} views, {len(cases)} scenes", cases)]
        print(markdown(("views", *_COLUMNS), rows) + "\n")


def _cases(name: str, count: int, options: argparse.Namespace) -> list["_Case"]:
    pairs = options.scenes or PAIRS
    number = pairs if count == 2 else max(pairs // (5 * (count - 1)), 5)
    seeds = range(FIRST_SEED, FIRST_SEED + number)
    with single_threads(), ProcessPoolExecutor(options.workers, mp_context=get_context("spawn")) as pool:
        return list(pool.map(_fused_case, [name] * number, [count] * number, seeds, chunksize=2))


@dataclass(frozen=True, slots=True)
class _Outcome:
    """One result against the truth."""

    error: float
    """|V / V* - 1|; 1 without a box."""
    volume_held: bool
    """Whether the 90 % interval holds the volume."""
    held: tuple[bool, ...]
    """Whether the intervals hold length, width and height."""


@dataclass(frozen=True, slots=True)
class _Case:
    """One scene: each scan alone, all with poses, all without."""

    angle: float
    """Between the first two views, degrees."""
    alone: tuple[_Outcome, ...]
    posed: _Outcome
    unposed: _Outcome


def _fused_case(name: str, count: int, seed: int) -> _Case:
    box, at, singles = case(name, count, seed)
    lost = [replace(single, camera_to_world=None) for single in singles]
    return _Case(
        abs((at[1] - at[0] + 180) % 360 - 180),
        tuple(_outcome(single, box) for single in singles),
        _outcome(fuse_measurements(singles), box),
        _outcome(fuse_measurements(lost), box),
    )


def _outcome(measured: Measurement, box: Box) -> _Outcome:
    if not measured.boxes:
        return _Outcome(1.0, False, (False,) * 3)
    found = measured.boxes[0]
    held = [_holds(ends, x) for ends, x in zip(found.interval90, np.sort(box.extents)[::-1], strict=True)]
    return _Outcome(abs(found.volume / box.volume - 1), _holds(found.volume_interval90, box.volume), tuple(held))


def _holds(interval: tuple[float, float | None], truth: float) -> bool:
    return interval[0] <= truth <= (np.inf if interval[1] is None else interval[1])


def _rows(label: str, cases: list[_Case]) -> list[tuple[str, ...]]:
    """Return a row for each scan alone (all of them pooled), for all fused with poses, and without."""
    groups = {
        "each alone": [outcome for one in cases for outcome in one.alone],
        "with poses": [one.posed for one in cases],
        "without": [one.unposed for one in cases],
    }
    return [(label, kind, *_cells(outcomes)) for kind, outcomes in groups.items() if outcomes]


def _cells(outcomes: list[_Outcome]) -> tuple[str, ...]:
    errors = np.array([outcome.error for outcome in outcomes])
    low, high = bootstrap(errors, np.median)
    volume = [outcome.volume_held for outcome in outcomes]
    sides = [held for outcome in outcomes for held in outcome.held]
    p90 = percent(float(np.quantile(errors, 0.9)))
    median = f"{percent(float(np.median(errors)))} ({percent(low)} to {percent(high)})"
    return str(len(errors)), median, p90, _share(volume), _share(sides)


def _share(held: list[bool]) -> str:
    low, high = wilson(sum(held), len(held))
    return f"{np.mean(held):.3f} ({low:.2f} to {high:.2f})"

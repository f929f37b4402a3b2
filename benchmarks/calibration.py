"""Are the error bars right on our own simulated cameras? Scale and offset are drawn per scan, as the covariance believes."""

import argparse
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np
from numpy.typing import NDArray

from benchmarks._tables import bootstrap, markdown, percent, wilson
from viewgain.arrays import Pose
from viewgain.box import Box
from viewgain.camera import PRESETS, Sensor, sensor
from viewgain.episodes import World
from viewgain.errors import ScanError
from viewgain.geometry import inverse
from viewgain.measure import Measurement, measure
from viewgain.scenes import Scene, orbit_pose, random_box
from viewgain.simulate import single_threads

FARTHEST = 2.0
"""Metres from the camera to the box's centre."""
ELEVATION_DEG = (15.0, 90.0)
AIM_SD = 0.05
"""Standard deviation of where the camera is aimed, per axis, metres."""
SCENES = 200
"""Scans per camera unless ``--scenes`` says otherwise."""
REPORTED = 10_000
"""First seed of the reported scans; lower seeds were looked at while the estimator was built."""


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """One scan: what was true, what came out."""

    truth: NDArray[np.float64]
    """(4,) volume, then the true extents along the axes of the measured length, width and height, cubic metres and metres.

    Not sorted by themselves: a lower bound of an open dimension would else be held against another side.
    """
    whole: bool
    """Whether all corners of the box lie in the image."""
    reason: str | None
    """Why there is no box."""
    estimate: NDArray[np.float64]
    """(4,) the same as ``truth`` as measured; NaN without a box."""
    low: NDArray[np.float64]
    """(4,) lower ends of the 90 % intervals."""
    high: NDArray[np.float64]
    """(4,) upper ends; infinite where open."""
    signed: NDArray[np.float64]
    """(3,) measured minus true extent: the shorter and the longer horizontal one, and the vertical one; NaN where open."""
    view: NDArray[np.float64]
    """(3,) folded azimuth and elevation, degrees, and distance, metres."""

    @property
    def inside(self) -> NDArray[np.bool_]:
        """(4,) whether the intervals hold the truth."""
        return np.asarray((self.low <= self.truth) & (self.truth <= self.high))


def run(options: argparse.Namespace) -> None:
    """Print coverage, sharpness, success and bias per camera preset."""
    names, scenes = options.cameras or PRESETS, options.scenes or SCENES
    rows, offs = [], []
    for name in names:
        results = outcomes(name, scenes, options.workers)
        rows.append((name, *_row(results)))
        offs.append((name, *_bias(outcomes(name, scenes, options.workers, systematic=False))))
        if options.pictures is not None:
            from benchmarks._accuracy_pictures import draw_outcomes

            draw_outcomes(name, results, options.pictures / f"accuracy-views-{name}.png")
    print(f"## Error bars: {scenes} fresh scans per camera\n")
    print(
        f"Boxes of 0.1 to 0.6 m a side, all azimuths, elevation 15 to 90 degrees, centre from the camera's least range (plus half"
        f" the box's diagonal) to {FARTHEST:.0f} m, everything simulated but multipath; camera scale and offset drawn per scan.\n"
        "Share of the 90 % intervals that hold the truth (95 % Wilson interval); right is 0.90.\n"
    )
    header = ("camera", "success", "wholly seen", "volume", "length", "width", "height")
    print(markdown((*header, "median |error|", "median half-width of 90 %"), rows))
    print("\nThe same scans without systematic error: median of measured minus true, millimetres (95 % bootstrap interval).\n")
    print(markdown(("camera", "success", "shorter side", "longer side", "vertical", "median |volume error|"), offs))
    print()


def _row(results: Sequence[Outcome]) -> tuple[str, ...]:
    measured = [result for result in results if result.reason is None]
    inside = np.array([result.inside for result in measured])
    cells = []
    for k in range(4):
        low, high = wilson(int(inside[:, k].sum()), len(measured))
        cells.append(f"{inside[:, k].mean():.3f} ({low:.3f} to {high:.3f})")
    error = np.array([abs(result.estimate[0] / result.truth[0] - 1) for result in measured])
    half = np.array([(result.high[0] - result.low[0]) / 2 / result.truth[0] for result in measured])
    whole = [result.reason is None for result in results if result.whole]
    return (_share(len(measured), len(results)), _share(sum(whole), len(whole)), *cells, percent(float(np.median(error))),
            percent(float(np.median(half))))  # fmt: skip


def _bias(results: Sequence[Outcome]) -> tuple[str, ...]:
    measured = [result for result in results if result.reason is None]
    signed = 1e3 * np.array([result.signed for result in measured])
    cells = []
    for k in range(3):
        known = signed[np.isfinite(signed[:, k]), k]
        low, high = bootstrap(known, np.median, draws=500)
        cells.append(f"{np.median(known):+.2f} ({low:+.2f} to {high:+.2f})")
    error = np.array([abs(result.estimate[0] / result.truth[0] - 1) for result in measured])
    return (_share(len(measured), len(results)), *cells, percent(float(np.median(error))))


def _share(hits: int, total: int) -> str:
    return f"{hits / max(total, 1):.3f} of {total}"


def outcomes(name: str, scans: int, workers: int, *, systematic: bool = True, first: int = REPORTED) -> list[Outcome]:
    """Return the outcomes of ``scans`` fresh scans of the camera preset ``name``, seeds from ``first`` on."""
    seeds = range(first, first + scans)
    with single_threads(), ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        return list(pool.map(outcome, [name] * scans, seeds, [systematic] * scans, chunksize=10))


def outcome(name: str, seed: int, systematic: bool) -> Outcome:
    """Return what comes of one scan."""
    rng = np.random.default_rng([seed, 11])
    camera = sensor(name) if systematic else sensor(name).without_systematic()
    box = random_box(rng)
    pose, view = _view(rng, box, camera)
    world = World(Scene((box,)), camera, scale=rng.normal(0, camera.scale_sd), offset=rng.normal(0, camera.offset_sd))
    seen, whole = box.in_frame(inverse(pose)), _whole(box, pose, camera)
    try:
        scan = world.scan(pose, pose, rng)
    except ScanError:  # next to nothing came back: no volume
        return _without_box(seen, "no_scan", whole, view)
    return _judged(seen, measure(scan, camera=camera), whole, view)


def _view(rng: np.random.Generator, box: Box, camera: Sensor) -> tuple[Pose, NDArray[np.float64]]:
    """Return a random view of ``box``, with its folded azimuth, elevation and distance."""
    azimuth, elevation = rng.uniform(0, 360), rng.uniform(*ELEVATION_DEG)
    nearest = camera.range_min + float(np.linalg.norm(box.extents)) / 2
    distance = rng.uniform(nearest, FARTHEST)
    turned = (azimuth - np.rad2deg(np.arctan2(box.box_to_camera[1, 0], box.box_to_camera[0, 0]))) % 90
    target = box.centre + rng.normal(0.0, AIM_SD, 3)
    pose = orbit_pose(target, np.deg2rad(azimuth), np.deg2rad(elevation), distance, float(np.deg2rad(rng.normal(0, 3))))
    return pose, np.array([min(turned, 90 - turned), elevation, distance])


def _whole(box: Box, pose: Pose, camera: Sensor) -> bool:
    corners = box.in_frame(inverse(pose)).corners()
    u, v = camera.intrinsics.project(corners).T
    width, height = camera.intrinsics.width, camera.intrinsics.height
    return bool(np.all((corners[:, 2] > 0) & (u >= 0) & (v >= 0) & (u <= width - 1) & (v <= height - 1)))


def _without_box(box: Box, reason: str | None, whole: bool, view: NDArray[np.float64]) -> Outcome:
    nothing = np.full(4, np.nan)
    return Outcome(np.array([box.volume, *box.extents]), whole, reason, nothing, nothing, nothing, np.full(3, np.nan), view)


def _judged(box: Box, result: Measurement, whole: bool, view: NDArray[np.float64]) -> Outcome:
    """Return the outcome; ``box`` is the true one in the camera's frame."""
    if not result.boxes:
        return _without_box(box, result.reason, whole, view)
    best = result.boxes[0]
    along = np.abs(best.box.box_to_camera[:3, :3].T @ box.box_to_camera[:3, :3])
    true = box.extents[[1, 0, 2]] if along[0, 1] > along[0, 0] else box.extents
    intervals = [best.volume_interval90, *best.interval90]
    low, high = (np.array([np.inf if end[k] is None else end[k] for end in intervals], dtype=float) for k in (0, 1))
    signed = np.where(best.is_open, np.nan, best.box.extents - true)
    sides = signed[:2][np.argsort(true[:2])]
    truth, estimate = np.array([box.volume, *true[best.order]]), np.array([best.volume, *best.dimensions])
    return Outcome(truth, whole, None, estimate, low, high, np.array([*sides, signed[2]]), view)

"""Are the error bars right on our own simulated cameras? Scale and offset are drawn per scene, as the covariance believes."""

import argparse
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from benchmarks._tables import markdown, wilson
from viewgain.camera import sensor
from viewgain.episodes import World
from viewgain.measure import measure
from viewgain.scenes import Scene, SceneRanges, random_box, random_view
from viewgain.simulate import single_threads

CAMERAS = ("pico_flexx", "xtion")


def run(options: argparse.Namespace) -> None:
    """Print coverage of the 90 % intervals per camera preset."""
    rows = []
    for name in CAMERAS:
        with single_threads(), ProcessPoolExecutor(options.workers, mp_context=get_context("spawn")) as pool:
            inside = np.array(list(pool.map(_inside, [name] * options.scenes, range(options.scenes), chunksize=5)))
        measured = inside[inside[:, 0] >= 0]
        cells = []
        for k in range(4):
            low, high = wilson(int(measured[:, k].sum()), len(measured))
            cells.append(f"{measured[:, k].mean():.3f} ({low:.2f} to {high:.2f})")
        rows.append((name, len(inside), f"{len(measured) / len(inside):.3f}", *cells))
    print("## 90 % intervals on simulated scans: share that contains the truth (95 % Wilson interval)\n")
    print(markdown(("camera", "scans", "success", "volume", "length", "width", "height"), rows))
    print()


def _inside(name: str, seed: int) -> tuple[float, ...]:
    """Return whether the intervals of volume, length, width and height contain the truth; -1 without a box."""
    rng = np.random.default_rng([seed, 11])
    camera, ranges = sensor(name), SceneRanges()
    box = random_box(rng, ranges)
    pose = random_view(rng, box, ranges)
    world = World(Scene((box,)), camera, scale=rng.normal(0, camera.scale_sd), offset=rng.normal(0, camera.offset_sd))
    result = measure(world.scan(pose, pose, rng), camera=camera)
    if not result.boxes:
        return (-1.0,) * 4
    best = result.boxes[0]
    truth = [box.volume, *np.sort(box.extents)[::-1]]
    intervals = [best.volume_interval90, *best.interval90]
    return tuple(float(low <= x <= (np.inf if high is None else high)) for (low, high), x in zip(intervals, truth, strict=True))

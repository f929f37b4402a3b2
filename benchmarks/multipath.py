"""What multipath costs the estimator, which has no model of it: volume error by reflectivity of floor and box."""

import argparse
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from benchmarks._tables import bootstrap, markdown, percent
from viewgain.camera import sensor
from viewgain.measure import measure
from viewgain.scenes import Scene, SceneRanges, random_box, random_view
from viewgain.simulate import Effects, capture, single_threads

CAMERA = "pico_flexx"
SCENES = 200
CASES = {
    "noise and losses only": (Effects.only("noise", "loss"), (0.5, 0.5)),
    "all but multipath": (Effects().without("multipath"), (0.5, 0.5)),
    "all, dark floor (box 0.5, floor 0.1)": (Effects(), (0.5, 0.1)),
    "all, box 0.5, floor 0.3": (Effects(), (0.5, 0.3)),
    "all, box and floor 0.5": (Effects(), (0.5, 0.5)),
}


def run(options: argparse.Namespace) -> None:
    """Print the table."""
    rows = []
    scenes = options.scenes or SCENES
    with single_threads(), ProcessPoolExecutor(options.workers, mp_context=get_context("spawn")) as pool:
        for name in CASES:
            found = np.array(list(pool.map(_error, [name] * scenes, range(scenes), chunksize=5)))
            signed, inside = found.T
            size = np.abs(signed)
            low, high = bootstrap(size, np.median)
            numbers = (float(np.median(size)), low, high, float(np.quantile(size, 0.9)))
            median, lower, upper, late = (percent(number) for number in numbers)
            bias, held = f"{100 * np.median(signed):+.2f} %", f"{inside.mean():.3f}"
            rows.append((name, f"{np.mean(signed > -1):.3f}", median, f"{lower} to {upper}", late, bias, held))
    print(f"## What multipath costs the estimator: {scenes} random boxes and views, {CAMERA}, no systematic error\n")
    print(
        markdown(
            ("effects", "success", "median |error|", "95 % of the median", "p90 |error|", "bias", "90 % intervals hold"), rows
        )
    )
    print("\nRelative volume error; a missing volume counts as 100 %.\n")


def _error(name: str, seed: int) -> tuple[float, float]:
    """Return the signed relative volume error (-1 without a box) and whether the interval holds the truth."""
    effects, reflectivity = CASES[name]
    rng, camera, ranges = np.random.default_rng([seed, 17]), sensor(CAMERA).without_systematic(), SceneRanges()
    box = random_box(rng, ranges)
    scan = capture(Scene((box,), reflectivity=reflectivity), random_view(rng, box, ranges), camera, rng=rng, effects=effects)
    result = measure(scan, camera=camera)
    if not result.boxes:
        return -1.0, 0.0
    low, high = result.boxes[0].volume_interval90
    return result.boxes[0].volume / box.volume - 1, float(low <= box.volume <= (np.inf if high is None else high))

"""Scenes without a box: how often one is reported all the same, and the reasons given otherwise."""

import argparse
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from benchmarks._not_boxes import KINDS, view_of
from benchmarks._tables import markdown, wilson
from viewgain.camera import sensor
from viewgain.measure import measure
from viewgain.simulate import Effects, capture, single_threads

CAMERAS = ("pico_flexx", "xtion")
DEVELOPMENT_SEEDS = range(9000, 9300)
"""What the thresholds of viewgain.measure's evidence against a box were chosen on."""
FIRST_SEED = 30_000
"""First seed of what is reported."""
SCENES = 504
"""84 of each kind, half with each camera."""


def run(options: argparse.Namespace) -> None:
    """Print the share of scenes in which a box is reported, by kind."""
    scenes = options.scenes or SCENES
    with single_threads(), ProcessPoolExecutor(options.workers, mp_context=get_context("spawn")) as pool:
        answers = list(pool.map(answer, range(FIRST_SEED, FIRST_SEED + scenes), chunksize=6))
    rows = [_row(kind, [reason for name, reason in answers if name == kind]) for kind in KINDS]
    rows.append(_row("all", [reason for _, reason in answers]))
    print(f"## Scenes without a box ({' and '.join(CAMERAS)}, all effects but multipath, seeds {FIRST_SEED} on)\n")
    print(markdown(("kind", "scenes", "a box reported (95 % Wilson interval)", "reasons otherwise"), rows))
    print()


def answer(seed: int) -> tuple[str, str]:
    """Return the kind of the scene of a seed, and the reason measured, or ``box``."""
    kind = tuple(KINDS)[seed % len(KINDS)]
    camera = sensor(CAMERAS[seed // len(KINDS) % len(CAMERAS)])
    rng = np.random.default_rng([seed, 4])
    scene = KINDS[kind](rng)
    view = view_of(scene, kind, rng)
    measured = measure(capture(scene, view, camera, rng=rng, effects=Effects().without("multipath")), camera=camera)
    return kind, measured.reason or "box"


def _row(kind: str, reasons: list[str]) -> tuple[object, ...]:
    count = Counter(reasons)
    wrong = count.pop("box", 0)
    low, high = wilson(wrong, len(reasons))
    told = ", ".join(f"{name} {number}" for name, number in count.most_common())
    return kind, len(reasons), f"{100 * wrong / max(len(reasons), 1):.1f} % ({100 * low:.1f} to {100 * high:.1f})", told

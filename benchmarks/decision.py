"""How long a decision takes: a scan is measured, eight positions of a ring are ranked; without torch, on one thread.

Processor time of ``viewgain.plan.next_view`` from scan to answer, measuring included, by every policy that tries nothing out. The
first, ``viewgain next``, is the command's default and says how sure its choice is, too.
"""

import argparse
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from time import process_time

import numpy as np
from numpy.typing import NDArray

from benchmarks._data import boxbench_folder
from benchmarks._tables import bootstrap, markdown
from benchmarks.protocol import Sample, boxbench, generated, spread
from viewgain.inference import volume_scorer
from viewgain.measure import POSE_SIGMA, measure
from viewgain.plan import (
    AutomaticPolicy,
    CovariancePolicy,
    ExpectedErrorPolicy,
    Policy,
    VolumeJudge,
    VolumeNetworkAboutBox,
    forget_predictions,
    next_view,
)
from viewgain.simulate import single_threads

_RIG = "ring8"
_SCENES = 32
"""Of boxbench's scans, 224 x 171 pixels, where nobody says how many."""


def run(options: argparse.Namespace) -> None:
    """Print the table."""
    folder = boxbench_folder()
    samples = spread(list(generated(seed=0) if folder is None else boxbench(folder)), options.scenes or _SCENES)
    with single_threads(), ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        pool.submit(_spent, samples[:2]).result()  # networks are read, and libraries make ready
        spent, with_torch = pool.submit(_spent, samples).result()
    source = "boxbench" if folder is not None else "boxbench's protocol, drawn by our own simulator (seed 0)"
    print(f"## A decision: one scan measured, the eight positions of {_RIG} ranked\n")
    print(
        f"{source}, {len(samples)} scans of 224 x 171 pixels; processor time on one thread, ms. All take one scan after another"
        f" in turn, nobody is left another's predictions. torch is {'loaded' if with_torch else 'not loaded'}.\n"
    )
    print(markdown(("", "median (95 % bootstrap)", "90th percentile"), [(name, *_cells(each)) for name, each in spent.items()]))
    print()


def _spent(samples: list[Sample]) -> tuple[dict[str, NDArray[np.float64]], bool]:
    """Return the milliseconds of each work on each sample, (n,) by name, and whether torch was loaded meanwhile."""
    spent = {name: np.empty(len(samples)) for name in WORKS}
    for column, sample in enumerate(samples):
        for name, work in WORKS.items():
            forget_predictions()
            start = process_time()
            work(sample)
            spent[name][column] = 1e3 * (process_time() - start)
    return spent, "torch" in sys.modules


def _cells(spent: NDArray[np.float64]) -> tuple[str, str]:
    low, high = bootstrap(spent, np.median)
    return f"{np.median(spent):.0f} ({low:.0f} to {high:.0f})", f"{np.quantile(spent, 0.9):.0f}"


def _next(sample: Sample, policy: Policy, judge: VolumeJudge | None = None) -> object:
    return next_view(sample.scan, _RIG, policy=policy, camera=sample.sensor, judge=judge)


def _network(sample: Sample, model: ExpectedErrorPolicy | None = None) -> Policy:
    return VolumeNetworkAboutBox(volume_scorer(), sample.scan, model)


WORKS: Mapping[str, Callable[[Sample], object]] = {
    "measuring alone": lambda sample: measure(sample.scan, camera=sample.sensor),
    "viewgain next": lambda sample: _next(sample, AutomaticPolicy(sample.scan), VolumeJudge(sample.scan)),
    "model": lambda sample: _next(sample, CovariancePolicy(POSE_SIGMA)),
    "expected": lambda sample: _next(sample, ExpectedErrorPolicy()),
    "combined": lambda sample: _next(sample, _network(sample, ExpectedErrorPolicy())),
    "network": lambda sample: _next(sample, _network(sample)),
}
"""What is timed, by the names of the table."""

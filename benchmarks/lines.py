"""The paper's estimator (planes, lines, corners), as published and mended, beside the state of practice, on boxbench.

``python -m benchmarks volume`` puts our own estimator beside them.
"""

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks._data import boxbench_folder
from benchmarks._practice import practice_dimensions
from benchmarks._tables import bootstrap, markdown, percent, wilson
from benchmarks.protocol import Sample, boxbench, generated
from viewgain.planes import AS_PUBLISHED, MENDED, measure_lines

Estimator = Callable[[Sample], NDArray[np.float64] | None]
"""A sample's (3,) dimensions, or None without an answer."""

ESTIMATORS: dict[str, Estimator] = {
    "lines, as published": lambda sample: measure_lines(sample.scan, AS_PUBLISHED).dimensions,
    "corners, as published": lambda sample: measure_lines(sample.scan, AS_PUBLISHED.using("corners")).dimensions,
    "lines, mended": lambda sample: measure_lines(sample.scan, MENDED).dimensions,
    "corners, mended": lambda sample: measure_lines(sample.scan, MENDED.using("corners")).dimensions,
    "practice": lambda sample: practice_dimensions(sample.scan),
}
"""What is compared: planes and lines, and RANSAC floor, top height and smallest rectangle."""

BANDS = {
    "all": (0, 45),
    "0-10°": (0, 10),
    "10-20°": (10, 20),
    "20-30°": (20, 30),
    "30-45°": (30, 45),
    ">= 25°": (25, 45),
    "< 25°": (0, 25),
}
"""Ranges of folded azimuth: 0 is face-on, 45 edge-on."""


@dataclass(frozen=True)
class Row:
    """The outcome of one scan."""

    signed: float
    """V / V* - 1; NaN without a volume."""
    folded: float
    cut: bool
    seconds: float
    """Processor time."""
    pixels: int


def run(options: argparse.Namespace) -> None:
    """Print the tables."""
    del options
    folder = boxbench_folder()
    samples = list(generated(seed=0) if folder is None else boxbench(folder))
    source = "boxbench's protocol, drawn by our own simulator (seed 0)" if folder is None else "boxbench: 128 scans"
    print(f"## Planes, lines and corners on {source}\n")
    print("Relative volume error; median, p90 and bias over returned volumes, shares over all scans (none is a miss).\n")
    outcomes = {name: evaluate(estimator, samples) for name, estimator in ESTIMATORS.items()}
    table = [(name, band, *summary(within(rows, band))) for name, rows in outcomes.items() for band in BANDS]
    print(markdown(HEADER, table))
    print()
    whole = [(name, "box in image", *summary([row for row in rows if not row.cut])) for name, rows in outcomes.items()]
    print(markdown(HEADER, whole))
    print()
    for name, rows in outcomes.items():
        print(f"{name}: {milliseconds(rows)} per 224x171 scan (median, p90), processor time.")
    print()


def evaluate(estimator: Estimator, samples: Sequence[Sample]) -> list[Row]:
    """Return one row per sample."""
    rows = []
    for sample in samples:
        start = time.process_time()
        dimensions = estimator(sample)
        seconds = time.process_time() - start
        signed = np.nan if dimensions is None else float(np.prod(dimensions) / np.prod(sample.dims) - 1)
        height, width = sample.scan.shape or (0, 0)
        rows.append(Row(signed, sample.folded_azimuth, sample.cut, seconds, height * width))
    return rows


HEADER = ("estimator", "folded azimuth", "n", "success", "95 %", "median", "95 %", "p90", "bias", "< 10 %", "< 20 %")


def milliseconds(rows: Sequence[Row]) -> str:
    """Return median and 90th percentile of the time of the 224x171 scans (or those of a quarter turn)."""
    small = 1e3 * np.array([row.seconds for row in rows if row.pixels < 100_000])
    return f"{np.median(small):.0f} ms, {np.quantile(small, 0.9):.0f} ms"


def within(rows: list[Row], band: str) -> list[Row]:
    """Return the rows of a band of folded azimuth (a key of :data:`BANDS`)."""
    low, high = BANDS[band]
    return [row for row in rows if low <= row.folded < high or row.folded == high == 45]


def summary(rows: list[Row], digits: int = 1) -> list[str]:
    """Return the cells under :data:`HEADER` from ``n`` on; errors in per cent with so many digits."""
    signed = np.array([row.signed for row in rows])
    found = signed[np.isfinite(signed)]
    low, high = wilson(len(found), len(rows))
    cells = [str(len(rows)), f"{len(found) / max(len(rows), 1):.2f}", f"{low:.2f} to {high:.2f}"]
    if len(found) == 0:
        return [*cells, "-", "-", "-", "-", "0.00", "0.00"]
    error = np.abs(found)
    below, above = bootstrap(error, np.median)
    return [
        *cells, percent(float(np.median(error)), digits), f"{percent(below, digits)} to {percent(above, digits)}",
        percent(float(np.quantile(error, 0.9)), digits), f"{100 * np.median(found):+.{digits}f} %",
        *(f"{np.sum(error < limit) / len(rows):.2f}" for limit in (0.1, 0.2)),
    ]  # fmt: skip

"""Methods side by side on boxbench: the paper's planes, lines and corners, the state of practice, ours, and a constant answer."""

import argparse
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks._data import boxbench_folder
from benchmarks._tables import markdown
from benchmarks.lines import ESTIMATORS, HEADER, Estimator, Row, evaluate, milliseconds, summary, within
from benchmarks.protocol import Sample, boxbench, generated, median_volume, spread
from viewgain.measure import measure

_BANDS = ("0-10°", "10-20°", "20-30°", "30-45°", ">= 25°")


def run(options: argparse.Namespace) -> None:
    """Print the methods side by side, all scans and by folded azimuth; with ``--pictures`` also draw their errors."""
    folder = boxbench_folder()
    samples = spread(list(generated(seed=0) if folder is None else boxbench(folder)), options.scenes)
    source = "boxbench's protocol, drawn by our own simulator (seed 0)" if folder is None else "boxbench"
    rows = {name: evaluate(estimator, samples) for name, estimator in METHODS.items()}
    print(f"## Methods side by side: {source}, {len(samples)} scans\n")
    print(
        "Relative volume error; median (95 % bootstrap interval), p90 and bias over returned volumes; success with its 95 %"
        " Wilson interval; shares under 10 and 20 % over all scans (none is a miss).\n"
        "Processor time per 224x171 scan, median and p90.\n"
    )
    print(markdown((HEADER[0], *HEADER[2:], "time"), [(name, *_cells(some)) for name, some in rows.items()]))
    print("\nThe same, of boxes wholly in the image:\n")
    whole = {name: [row for row in some if not row.cut] for name, some in rows.items()}
    print(markdown((HEADER[0], *HEADER[2:]), [(name, *summary(some, 2)) for name, some in whole.items()]))
    print("\nBy folded azimuth (0 is face-on, 45 edge-on):\n")
    print(markdown((HEADER[1], HEADER[0], *HEADER[2:]), _by_azimuth(rows)))
    print()
    if options.pictures is not None:
        from benchmarks._accuracy_pictures import draw_methods

        draw_methods(samples, rows, options.pictures / "accuracy-methods.png")


def ours(sample: Sample) -> NDArray[np.float64] | None:
    """Return (3,) dimensions of the first box that :func:`viewgain.measure.measure` finds, metres; None without one."""
    boxes = measure(sample.scan, camera=sample.sensor).boxes
    return boxes[0].dimensions if boxes else None


def constant(sample: Sample) -> NDArray[np.float64]:
    """Return (3,) sides of a cube of the protocol's median volume, whatever the scan shows: a floor for every method."""
    del sample
    return np.full(3, np.cbrt(median_volume()))


METHODS: dict[str, Estimator] = {**ESTIMATORS, "ours": ours, "constant answer": constant}
"""What is compared, by the names used in the tables."""


def _cells(rows: Sequence[Row]) -> tuple[str, ...]:
    return (*summary(list(rows), 2), milliseconds(rows))


def _by_azimuth(rows: dict[str, list[Row]]) -> list[tuple[str, ...]]:
    groups = [(band, name, within(some, band)) for band in _BANDS for name, some in rows.items()]
    return [(band, name, *summary(group, 2)) for band, name, group in groups if group]

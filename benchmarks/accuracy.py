"""Accuracy of measuring on boxbench (an independent simulator) and on our own draw of its protocol, with time per scan."""

import argparse
import time
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from benchmarks._data import boxbench_folder
from benchmarks._tables import bootstrap, markdown, percent, wilson
from benchmarks.protocol import Sample, boxbench, generated, median_volume, spread
from viewgain.measure import measure


@dataclass(frozen=True)
class Row:
    """The outcome of one scan."""

    error: float
    """|V / V* - 1|; 1 without a volume."""
    signed: float
    found: bool
    inside: tuple[bool, ...]
    """Whether the 90 % intervals of volume, length, width and height contain the truth."""
    sigma: float
    """Relative standard deviation claimed for the volume."""
    flagged_cut: bool
    cut: bool
    folded: float
    seconds: float
    pixels: int
    constant: float
    """Error of always answering the protocol's median volume."""


def run(options: argparse.Namespace) -> None:
    """Print the tables."""
    folder = boxbench_folder()
    if folder is None:
        print("boxbench is not there; its protocol, drawn anew, stands for it.\n")
    else:
        _print("boxbench: scans by an independent simulator", outcomes(spread(list(boxbench(folder)), options.scenes)))
    _print("boxbench's protocol, drawn by our own simulator (seed 0)", outcomes(spread(list(generated(seed=0)), options.scenes)))


def outcomes(samples: Iterable[Sample]) -> list[Row]:
    """Return one row per scan, measured on one thread."""
    return [outcome(sample) for sample in samples]


def outcome(sample: Sample) -> Row:
    """Measure one scan and hold it against its truth."""
    start = time.perf_counter()
    result = measure(sample.scan, camera=sample.sensor)
    seconds = time.perf_counter() - start
    truth, volume = np.sort(sample.dims)[::-1], float(np.prod(sample.dims))
    shape = sample.scan.shape or (0, 0)
    common = (sample.cut, sample.folded_azimuth, seconds, shape[0] * shape[1], abs(median_volume() / volume - 1))
    if not result.boxes:
        return Row(1.0, -1.0, False, (False,) * 4, np.nan, False, *common)
    box = result.boxes[0]
    signed = box.volume / volume - 1
    intervals = [box.volume_interval90, *box.interval90]
    inside = tuple(
        low <= x <= (np.inf if high is None else high) for (low, high), x in zip(intervals, [volume, *truth], strict=True)
    )
    sigma = np.nan if box.volume_sigma is None else box.volume_sigma / box.volume
    return Row(abs(signed), signed, True, inside, sigma, "cut" in box.flags, *common)


def _print(title: str, rows: list[Row]) -> None:
    whole = [row for row in rows if not row.cut]
    bands = [(f"folded azimuth {low}-{high}°", [row for row in rows if low <= row.folded < high or row.folded == high == 45])
             for low, high in ((0, 10), (10, 20), (20, 30), (30, 45))]  # fmt: skip
    groups = [
        ("all", rows),
        ("box wholly in the image", whole),
        ("box cut by the image", [row for row in rows if row.cut]),
        *bands,
    ]
    header = ("scans", "n", "success", "median |error|", "95 % of the median", "p90 |error|", "bias", "median claimed sigma")
    print(f"## {title}\n\nRelative volume error; a missing volume counts as 100 %.\n")
    print(markdown(header, [(name, len(group), *_accuracy(group)) for name, group in groups if group]))
    constant = percent(float(np.median([row.constant for row in rows])))
    print(f"\nFloor: always answering the protocol's median volume is off by {constant} (median).\n")
    print("Share of the 90 % intervals that contain the truth (95 % Wilson interval); right is 0.90.\n")
    print(
        markdown(
            ("scans", "volume", "length", "width", "height"), [(name, *_coverage(group)) for name, group in groups[:3] if group]
        )
    )
    flagged = sum(row.flagged_cut for row in rows if row.cut)
    wrongly = sum(row.flagged_cut for row in whole)
    print(f"\nFlag cut: {flagged} of {len(rows) - len(whole)} cut boxes, and {wrongly} of {len(whole)} whole ones.")
    for name, low, high in (("224x171", 0, 100_000), ("640x480", 100_000, 10**9)):
        seconds = [row.seconds for row in rows if low < row.pixels < high]
        if seconds:
            median, late = 1e3 * np.median(seconds), 1e3 * np.quantile(seconds, 0.9)
            print(f"Time per {name} scan, one thread: median {median:.0f} ms, p90 {late:.0f} ms.")
    print()


def _accuracy(rows: list[Row]) -> list[str]:
    errors, signed = np.array([row.error for row in rows]), [row.signed for row in rows]
    low, high = bootstrap(errors, np.median)
    sigma = np.nanmedian([row.sigma for row in rows])
    return [
        f"{np.mean([row.found for row in rows]):.3f}", percent(float(np.median(errors))), f"{percent(low)} to {percent(high)}",
        percent(float(np.quantile(errors, 0.9))), f"{100 * np.median(signed):+.2f} %", percent(float(sigma)),
    ]  # fmt: skip


def _coverage(rows: list[Row]) -> list[str]:
    cells = []
    for k in range(4):
        hits = sum(row.inside[k] for row in rows)
        low, high = wilson(hits, len(rows))
        cells.append(f"{hits / len(rows):.3f} ({low:.2f} to {high:.2f})")
    return cells

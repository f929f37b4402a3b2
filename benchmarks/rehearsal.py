"""Does a rehearsal in our simulator say what a scan by another one will bring?

Wherever planners are judged the simulator that rehearses is the one that judges. Here it is not: the scans are those of boxbench,
by a simulator that knows nothing of ours. Asked about the true box and pose, as a planner would be that knows the box.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
from scipy.stats import spearmanr

from benchmarks._data import boxbench_folder
from benchmarks._measured_boxes import outcome
from benchmarks._tables import bootstrap, markdown, percent
from benchmarks.protocol import POSITIONS, Sample, boxbench
from viewgain.arrays import Vector
from viewgain.gain import volume_estimator
from viewgain.geometry import inverse
from viewgain.measure import Knowledge
from viewgain.plan import Belief, arriving_within, expected_error, trials
from viewgain.scenes import standing_box

REHEARSALS = 8
"""Of each scan."""
_WORDS = f"""Outcome: |relative volume error| of the one scan, a miss counts as 100 %. Rehearsed: mean of {REHEARSALS} scans by
our simulator from the same pose. Of the four positions of a box at one level of noise each names the one of which it says least;
the scan from there is what it gets. 95 % intervals by box and level."""


@dataclass(frozen=True, slots=True)
class Said:
    """One scan, and what was said of it before."""

    found: float
    """Its outcome."""
    expected: float
    """The expected error of the formula."""
    rehearsed: float
    """The mean of the rehearsals."""


def run(options: argparse.Namespace) -> None:
    """Print the table."""
    del options
    folder = boxbench_folder()
    if folder is None:
        print("boxbench is not there, and our own draw of its protocol would be no other simulator.\n")
        return
    samples = list(boxbench(folder))
    said = [_said(sample) for sample in samples]
    groups = _groups(samples, said)
    print("## Rehearsals against scans of an independent simulator (boxbench)\n")
    print(f"{len(said)} scans. {_WORDS}\n")
    header = ("by", "mean said", "mean found", "mean absolute miss of one scan", "rank correlation", "outcome where it goes")
    found = np.array([each.found for each in said])
    rows = []
    for name in ("expected", "rehearsed"):
        values = np.array([getattr(each, name) for each in said])
        at_choice = [min(group, key=lambda each: getattr(each, name)).found for group in groups]
        rows.append((name, percent(values.mean()), percent(found.mean()), percent(np.abs(values - found).mean()),
                     f"{spearmanr(values, found).statistic:.3f}", _mean(at_choice)))  # fmt: skip
    any_position = [float(np.mean([each.found for each in group])) for group in groups]
    rows.append(("any position", "", "", "", "", _mean(any_position)))
    rows.append(("best scan", "", "", "", "", _mean([min(each.found for each in group) for group in groups])))
    print(markdown(header, rows) + "\n")


def _said(sample: Sample) -> Said:
    assert sample.scan.camera_to_world is not None
    box, estimator = (
        standing_box(sample.dims).in_frame(inverse(sample.scan.camera_to_world)),
        volume_estimator("default", sample.sensor),
    )
    belief = Belief((box,), Knowledge(np.eye(9), np.zeros((9, 4))), sample.sensor, 1.0, bounded=True)
    arriving = arriving_within(1, (0.0, 0.0))
    rehearsed = [
        trial.outcome(0, np.eye(4), sample.sensor, estimator)
        for trial in islice(trials(belief, arriving, np.random.default_rng(0)), REHEARSALS)
    ]
    found = outcome(estimator(sample.scan) / box.volume - 1)
    return Said(found, expected_error(box, np.eye(4), sample.sensor), float(np.mean(rehearsed)))


def _groups(samples: Sequence[Sample], said: Sequence[Said]) -> list[list[Said]]:
    """Return the scans of one box at one level of noise, one of each position."""
    groups: dict[tuple[float, ...], list[Said]] = {}
    for sample, each in zip(samples, said, strict=True):
        groups.setdefault((*sample.dims, sample.sensor.noise_per_metre), []).append(each)
    assert all(len(group) == POSITIONS for group in groups.values())
    return list(groups.values())


def _mean(values: Sequence[float] | Vector) -> str:
    low, high = bootstrap(values)
    return f"{percent(float(np.mean(values)))} ({percent(low)} to {percent(high)})"

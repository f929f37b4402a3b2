"""Does a rehearsal in our simulator say what a scan by another one will bring?

Wherever planners are judged the simulator that rehearses is the one that judges. Here it is not: the scans are those of boxbench,
by a simulator that knows nothing of ours. Asked about the true box and pose, as a planner would be that knows the box.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from operator import attrgetter

import numpy as np
from scipy.stats import spearmanr

from benchmarks._data import boxbench_folder
from benchmarks._tables import bootstrap, markdown, percent
from benchmarks.protocol import NOISE_LEVELS, POSITIONS, Sample, boxbench
from viewgain.arrays import Vector
from viewgain.gain import costs, volume_estimator
from viewgain.geometry import inverse
from viewgain.measure import Knowledge
from viewgain.plan import Belief, arriving_within, expected_error, trials
from viewgain.scenes import standing_box

REHEARSALS = 8
"""Of each scan."""
_SCANS = POSITIONS * len(NOISE_LEVELS)
"""Of each box, one after another."""
_WORDS = f"""Outcome: |relative volume error| of the one scan, a miss counts as 100 %. Rehearsed: mean of {REHEARSALS} scans by
our simulator from the same pose, without what is expected. Of the four positions of a box at one level of noise each names the
one of which it says least; the scan from there is what it gets. 95 % intervals by box, both levels of it together."""


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
    found = np.array([each.found for each in said])
    at_choice = {name: _by_box(samples, said, name) for name in ("expected", "rehearsed", "found")}
    print("## Rehearsals against scans of an independent simulator (boxbench)\n")
    print(f"{len(said)} scans. {_WORDS}\n")
    rows = []
    for name in ("expected", "rehearsed"):
        values = np.array([getattr(each, name) for each in said])
        off = percent(float(np.abs(values - found).mean()))
        correlation = f"{spearmanr(values, found).statistic:.3f}"
        rows.append((name, percent(float(values.mean())), off, correlation, _mean(at_choice[name])))
    rows.append(("rehearsed less expected", "", "", "", _mean(at_choice["rehearsed"] - at_choice["expected"])))
    rows.append(("any position", percent(float(found.mean())), "", "", _mean(found.reshape(-1, _SCANS).mean(axis=1))))
    rows.append(("best scan", "", "", "", _mean(at_choice["found"])))
    print(markdown(("by", "mean", "off the one scan", "rank correlation", "outcome where it goes"), rows) + "\n")


def _said(sample: Sample) -> Said:
    assert sample.scan.camera_to_world is not None
    box = standing_box(sample.dims).in_frame(inverse(sample.scan.camera_to_world))
    estimator = volume_estimator("default", sample.sensor)
    belief = Belief((box,), Knowledge(np.eye(9), np.zeros((9, 4))), sample.sensor, 1.0, bounded=True)
    tries = trials(belief, arriving_within(1, (0.0, 0.0)), np.random.default_rng(0))
    rehearsed = [trial.outcome(0, np.eye(4), estimator) for trial in islice(tries, REHEARSALS)]
    found = float(costs(estimator(sample.scan) / box.volume - 1))
    return Said(found, expected_error(box, np.eye(4), sample.sensor), float(np.mean(rehearsed)))


def _by_box(samples: Sequence[Sample], said: Sequence[Said], name: str) -> Vector:
    """Return (boxes,) the outcome at the position of which a column says least, mean over the levels of noise."""
    groups: dict[bytes, dict[float, list[Said]]] = {}
    for sample, each in zip(samples, said, strict=True):
        groups.setdefault(sample.dims.tobytes(), {}).setdefault(sample.sensor.noise_per_metre, []).append(each)
    chosen = [[min(group, key=attrgetter(name)).found for group in levels.values()] for levels in groups.values()]
    assert all(len(group) == POSITIONS for levels in groups.values() for group in levels.values())
    return np.array(chosen).mean(axis=1)


def _mean(values: Vector) -> str:
    low, high = bootstrap(values)
    return f"{percent(float(np.mean(values)))} ({percent(low)} to {percent(high)})"

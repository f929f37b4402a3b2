"""Fit the learned part of the expected error to measured boxes, and say how well it does on boxes it was not fitted to."""

import argparse
import json
from itertools import pairwise

import numpy as np
import torch

from benchmarks._error_fit import Runs, fitted, runs_of
from benchmarks._measured_boxes import measured_boxes
from benchmarks._tables import markdown, percent
from viewgain.arrays import Array
from viewgain.datasets import write_whole
from viewgain.evaluation import shares_by_object
from viewgain.plan import ErrorModel

BOXES = 1000
"""Boxes that the shipped one is fitted to."""
FOLDS = 5
GROUPS = (0.0, 0.005, 0.01, 0.02, 0.05, 0.2, 1.0)
"""Runs are put together by what is said of them."""
_WORDS = """Mean squared error of what is said of a run, a miss counts as 1; intervals: boxes drawn anew. Then the mean
outcome at each box's position that is said to be best, among one run of each (the best run is partly luck)."""


def run(options: argparse.Namespace) -> None:
    """Print the tables; write the model that is fitted to all boxes where ``--out`` says."""
    torch.set_num_threads(1)
    boxes = list(measured_boxes(options.scenes or BOXES, options.kept, options.workers))
    runs = runs_of(boxes)
    physical = np.array([guess.expected for guess in runs.physical])
    learned = _out_of_fold(runs, len(boxes))
    print("## Learned part of the expected error\n")
    print(f"{len(boxes)} boxes, {FOLDS} folds by box. {_WORDS}\n")
    header = ("scans", "runs", "mean outcome", "constant answer", "physical guess", "learned", "at the physical guess's best",
              "at the learned one's", "at any position", "best run")  # fmt: skip
    parts = (("alone", ~runs.fused), ("fused in pairs", runs.fused))
    print(markdown(header, [_row(name, runs.of(part), physical[part], learned[part]) for name, part in parts]) + "\n")
    print("Said : found, mean outcome in percent, of the runs of which so much is said:\n")
    columns = [f"{100 * low:g} to {100 * high:g}" for low, high in pairwise(GROUPS)]
    rows = [(name, *_said_and_found(said, runs)) for name, said in (("physical guess", physical), ("learned", learned))]
    print(markdown(("", *columns), rows) + "\n")
    if options.out is not None:
        write_whole(options.out, (json.dumps(fitted(runs).to_dict()) + "\n").encode())


def _out_of_fold(runs: Runs, boxes: int) -> Array:
    """Return (n,) what is said of each run by a fit that saw nothing of its box."""
    fold = np.random.default_rng(0).integers(FOLDS, size=boxes)[runs.owner]
    learned = np.zeros(len(runs.found))
    for k in range(FOLDS):
        learned[fold == k] = _said(fitted(runs.of(fold != k)), runs.of(fold == k))
    return learned


def _said(model: ErrorModel, runs: Runs) -> Array:
    pairs = zip(runs.physical, runs.inputs, strict=True)
    return np.array([model.corrected(guess, numbers[:-2]).expected for guess, numbers in pairs])


def _row(name: str, runs: Runs, physical: Array, learned: Array) -> tuple[str, ...]:
    squares = [f"{mean:.4f} ({low:.4f} to {high:.4f})" for mean, low, high in
               (_by_box((said - runs.found) ** 2, runs) for said in (physical, learned))]  # fmt: skip
    if runs.fused.any():
        chosen = ["-"] * 4
    else:
        chosen = [percent(float(np.mean(_at_best(runs, said)))) for said in (physical, learned)]
        own = [runs.found[runs.owner == box] for box in np.unique(runs.owner)]
        chosen += [percent(float(np.mean([each.mean() for each in own]))), percent(float(np.mean([each.min() for each in own])))]
    return (name, f"{len(runs.found):,}", percent(float(runs.found.mean())), f"{runs.found.var():.4f}", *squares, *chosen)


def _at_best(runs: Runs, said: Array) -> list[float]:
    """Return what came of each box's run of which the least error was said."""
    places = [np.flatnonzero(runs.owner == box) for box in np.unique(runs.owner)]
    return [float(runs.found[own[np.argmin(said[own])]]) for own in places]


def _said_and_found(said: Array, runs: Runs) -> list[str]:
    """Return for each group what is said in the mean, what is found, its interval, and how many runs."""
    group = np.digitize(said, GROUPS[1:-1])
    cells = []
    for k in range(len(GROUPS) - 1):
        own = group == k
        if not own.any():
            cells.append("none")
            continue
        mean, low, high = _by_box(runs.found[own], runs.of(own))
        cells.append(f"{100 * said[own].mean():.2f} : {100 * mean:.2f} ({100 * low:.2f} to {100 * high:.2f}), {own.sum():,}")
    return cells


def _by_box(values: Array, runs: Runs) -> tuple[float, float, float]:
    """Return the mean of (n,) values over runs and its 95 % interval."""
    found = shares_by_object(values[:, None], runs.owner, rng=np.random.default_rng(0))
    return found.mean[0], found.low[0], found.high[0]

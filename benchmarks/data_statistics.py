"""What a built data set holds: coverage by step, how often each position is best, floors, volume errors by position."""

import argparse
from pathlib import Path

import numpy as np

from benchmarks._histogram_pictures import error_histograms
from benchmarks._tables import bootstrap, markdown, percent
from viewgain.arrays import Array
from viewgain.datasets import Dataset, estimators_of, object_errors
from viewgain.gain import HISTOGRAM_OBJECTIVES, ErrorHistogram

RULES = ("union", "published")


def run(options: argparse.Namespace) -> None:
    """Print the tables of every data set that ``--data`` names."""
    if not options.data:
        print("data-statistics: name data sets with --data DIR ... (viewgain dataset build)\n")
    for folder in options.data or ():
        data = Dataset(folder)
        print(f"## {data.manifest.recipe['name']}: {len(data):,} samples of {len(np.unique(data.column('object'))):,} objects\n")
        _coverage(data)
        for estimator in estimators_of(Path(folder)):
            _errors(data, estimator, options.pictures)


def _coverage(data: Dataset) -> None:
    """Print, where there are coverage targets, the gain of the best view and of floors, and how often each offset is best."""
    objects = data.column("object")
    names = [name for rule in RULES for name in data.manifest.targets if rule in name]
    for name in names:
        gains = np.stack([data[k].targets[name] for k in range(len(data))])
        ahead = gains[:, 1:]  # offset 0 is the present view, which adds nothing
        best = ahead.max(axis=1, keepdims=True)
        hits = ahead >= best - 1e-12
        common = int(np.argmax(hits.mean(axis=0)))
        rows = [
            ("the best view", best[:, 0], np.ones(len(gains))),
            (f"always {common + 1} positions further (most common)", ahead[:, common], hits[:, common]),
            ("a view at random, mean over views", ahead.mean(axis=1), hits.mean(axis=1)),
        ]
        print(f"Coverage that the next view adds, target `{name}`:\n")
        table = [
            (what, percent(gain.mean()), _by_object(gain, objects), percent(hit.mean(), 1), _by_object(hit * 1.0, objects, 1))
            for what, gain, hit in rows
        ]
        print(markdown(("next view", "gain", "95 %, by object", "is the best", "95 %, by object"), table))
        shares = ", ".join(f"{k + 1}: {percent(share, 1)}" for k, share in enumerate(hits.mean(axis=0)))
        print(f"\nHow often each offset from the present view is best (ties count for each): {shares}.\n")


def _by_object(values: Array, objects: Array, digits: int = 2) -> str:
    """Return the 95 % bootstrap interval of a mean over samples, drawn by object."""
    means = np.bincount(objects.astype(int), values) / np.maximum(np.bincount(objects.astype(int)), 1)
    low, high = bootstrap(means[np.unique(objects.astype(int))])
    return f"{percent(low, digits)} to {percent(high, digits)}"


def _errors(data: Dataset, estimator: str, pictures: Path | None) -> None:
    """Print success and error of each box and position, which position is best by error and by label, and the floors."""
    errors = object_errors(data, estimator)
    rows = []
    choices: dict[str, list[list[int]]] = {"expected_error": [], "soft": []}  # of all scans, and of each half
    for number, own in errors.items():
        histogram = ErrorHistogram.from_errors(own)
        scores = HISTOGRAM_OBJECTIVES["near_zero"].gains(histogram)
        histograms = (histogram, *(ErrorHistogram.from_errors(own[:, k::2]) for k in (0, 1)))
        for name, made in choices.items():
            made.append([int(np.argmax(HISTOGRAM_OBJECTIVES[name].gains(each))) for each in histograms])
        cells = [_cell(view, score) for view, score in zip(own, scores, strict=True)]
        rows.append((number, *cells, choices["expected_error"][-1][0], choices["soft"][-1][0]))
    positions = len(next(iter(errors.values())))
    print(f"Volume errors by `{estimator}`: success / median |error| / share in the bin about zero (±2.5 %), by position:\n")
    print(markdown(("box", *(f"position {k}" for k in range(positions)), "least expected error", "label `soft`"), rows))
    tally, label = (np.bincount([each[0] for each in made], minlength=positions) for made in choices.values())
    agree, agree_on_label = (sum(one == other for _, one, other in made) for made in choices.values())
    print(
        f"\nHow often each position has the least expected error: {', '.join(map(str, tally))}. Floors: a uniform guess"
        f" {percent(1 / positions, 1)}, always position {int(np.argmax(tally))} {percent(tally.max() / tally.sum(), 1)}."
        f" Both halves of the scans agree on it for {agree} of {len(errors)} boxes. How often each is the label's, which goes by"
        f" the scans near zero alone: {', '.join(map(str, label))}; both halves agree on it for {agree_on_label}.\n"
    )
    if pictures is not None:
        error_histograms(errors, estimator, pictures / f"histograms-{estimator}.png")


def _cell(errors: Array, near_zero: float) -> str:
    found = errors[np.isfinite(errors)]
    median = percent(float(np.median(np.abs(found))), 1) if len(found) else "-"
    return f"{len(found) / len(errors):.2f} / {median} / {near_zero:.2f}"

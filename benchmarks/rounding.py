"""What storing weights as half floats costs: exact position on a run's validation objects, before and after."""

import argparse

import numpy as np

from benchmarks._tables import markdown, percent
from viewgain.datasets import Dataset
from viewgain.network import half_rounded
from viewgain.training import load_trained, shown_and_aside, validate


def run(options: argparse.Namespace) -> None:
    """Print one line per run that ``--runs`` names."""
    if not options.runs:
        print("rounding: name training runs with --runs RUN ...\n")
        return
    rows = []
    for path in options.runs:
        trained = load_trained(path)
        recipe = trained.record.recipe
        data = Dataset(options.data[0] if options.data else trained.record.data)
        examples, aside = shown_and_aside(recipe, data)
        rows_aside = np.flatnonzero(aside)
        single, half = (validate(each, recipe, examples, rows_aside) for each in (trained.module, half_rounded(trained.module)))
        cost = percent(single.exact - half.exact, 2)
        rows.append((path.name, f"{single.samples:,}", percent(single.exact), percent(half.exact), cost))
    print("## Weights stored as half floats, exact position on the run's validation objects\n")
    print(markdown(("run", "samples", "as trained", "rounded", "cost"), rows))
    print()

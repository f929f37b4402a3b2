"""What storing weights as half floats costs: exact position on a run's validation objects, before and after."""

import argparse

import numpy as np

from benchmarks._tables import markdown, percent
from viewgain.datasets import Dataset
from viewgain.network import half_rounded
from viewgain.training import held_out, load_examples, load_trained, validate


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
        examples = load_examples(data, recipe.data, views=recipe.network.views, seed=recipe.training.seed)
        aside = np.flatnonzero(held_out(examples.objects, recipe.data.validation_share, seed=recipe.training.seed))
        single, half = (validate(each, recipe, examples, aside) for each in (trained.module, half_rounded(trained.module)))
        cost = percent(single.exact - half.exact, 2)
        rows.append((path.name, f"{len(aside):,}", percent(single.exact), percent(half.exact), cost))
    print("## Weights stored as half floats, exact position on the run's validation objects\n")
    print(markdown(("run", "samples", "as trained", "rounded", "cost"), rows))
    print()

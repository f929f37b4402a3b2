"""What storing weights as half floats costs on a run's validation objects: exact position before and after; parity of files."""

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import torch
from numpy.typing import NDArray

from benchmarks._tables import markdown, percent
from viewgain.datasets import Dataset
from viewgain.evaluation import difference_by_object
from viewgain.gain import choices, hits, shortfall
from viewgain.inference import Scorer
from viewgain.network import ScoreNetwork, half_rounded, scores_of, unrepeated
from viewgain.training import (
    Batch,
    Examples,
    Trained,
    export_run,
    in_order,
    load_trained,
    present_first,
    shown_and_aside,
    validate,
)

_BATCH = 64
_INTERVALS = 0x726F


def run(options: argparse.Namespace) -> None:
    """Print one line per run that ``--runs`` names."""
    if not options.runs:
        print("rounding: name training runs with --runs RUN ...\n")
        return
    rows = [_row(path, options.data[0] if options.data else None) for path in options.runs]
    print("## Weights stored as half floats, exact position on the run's validation objects\n")
    print("Cost: paired, 95 % interval by object. Parity: largest difference of a score between onnxruntime and torch, both")
    print("with the rounded weights.\n")
    print(markdown(("run", "samples", "as trained", "rounded", "cost", "parity"), rows))
    print()


def _row(path: Path, folder: Path | None) -> tuple[str, ...]:
    trained = load_trained(path)
    recipe = trained.record.recipe
    examples, aside = shown_and_aside(recipe, Dataset(folder or trained.record.data))
    rows, rounded = np.flatnonzero(aside), half_rounded(trained.module)
    single, half = (validate(each, recipe, examples, rows) for each in (trained.module, rounded))
    cost = percent(single.exact - half.exact, 2)
    head = (path.name, f"{single.samples:,}", percent(single.exact), percent(half.exact))
    if recipe.network.with_poses:
        return (*head, cost, "")
    before, after, filed = (_scores(each, trained, examples, rows) for each in (trained.module, rounded, _exported(path)))
    whole, half_right = (_exact(scores, examples, rows, rig_order=recipe.network.with_view_state) for scores in (before, after))
    spread = difference_by_object(whole, half_right, examples.objects[rows], rng=np.random.default_rng(_INTERVALS))
    return (*head, f"{cost} ({percent(spread.low[0])} to {percent(spread.high[0])})", _parity(np.abs(filed - after).max(axis=1)))


def _parity(apart: NDArray[np.float32]) -> str:
    """Return the largest difference, and in how many samples it is over a hundred-thousandth."""
    return f"{apart.max():.1e}, over 1e-5 in {np.count_nonzero(apart > 1e-5)}"


def _exported(run: Path) -> Scorer:
    with TemporaryDirectory() as folder:
        export_run(run, Path(folder) / "run.onnx")
        return Scorer.load(Path(folder) / "run.onnx", threads=1)


def _scores(network: ScoreNetwork | Scorer, trained: Trained, examples: Examples, rows: NDArray[np.intp]) -> NDArray[np.float32]:
    """Return (N, V) scores of some samples as the network orders them."""
    settings = trained.record.recipe.network
    batches = in_order(examples, rows, batch=_BATCH, points=settings.points, uses_state=settings.with_view_state)
    return np.concatenate([_asked(network, batch) for _, batch in batches])


def _asked(network: ScoreNetwork | Scorer, batch: Batch) -> NDArray[np.float32]:
    if isinstance(network, Scorer):
        mask = unrepeated(batch.points, batch.mask)  # who scores a cloud leaves out points given twice, as torch's module does
        answer = network.run(batch.points.numpy(), mask.numpy(), None if batch.told is None else batch.told.numpy())
        return answer if answer.ndim == 2 else answer[..., 0]
    with torch.inference_mode():
        found: NDArray[np.float32] = scores_of(network(batch.points, batch.mask, batch.told)).numpy()
    return found


def _exact(scores: NDArray[np.float32], examples: Examples, rows: NDArray[np.intp], *, rig_order: bool) -> NDArray[np.bool_]:
    """Return (N, 1) whether the view of the highest score is worth as much as the best."""
    gains, states = examples.targets[rows], examples.states[rows]
    if not rig_order:
        gains, states = (present_first(each, examples.views[rows]) for each in (gains, states))
    free = ~states.numpy()
    return np.asarray(hits(shortfall(gains.numpy(), choices(scores, free), free))[:, :1])

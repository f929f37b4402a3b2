"""Fit the learned part of the expected error to measured boxes, and say how well it does on boxes it was not fitted to."""

import argparse
import json
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from benchmarks._measured_boxes import MeasuredBox, measured_boxes, outcome
from benchmarks._tables import bootstrap, markdown, percent
from viewgain.arrays import Array, Mask
from viewgain.box import Box
from viewgain.camera import Sensor, sensor
from viewgain.datasets import write_whole
from viewgain.geometry import inverse
from viewgain.measure import Knowledge
from viewgain.plan import (
    MOST_SHIFT,
    WITHIN,
    ErrorModel,
    Showing,
    circumstances,
    fused_showing,
    log_odds,
    physical_error,
    showing,
)

BOXES = 695
"""Boxes that the shipped one is fitted to."""
FOLDS = 5
STEPS, BATCH, RATE, DECAY = 4000, 256, 3e-3, 0.3
JITTER = 0.03
"""Noise on the scaled inputs while fitting."""
WIDTH = 48


@dataclass(frozen=True, slots=True, eq=False)
class Runs:
    """Scans, and pairs of scans, that were measured."""

    inputs: Array
    """(n, F) circumstances, the log-odds of the physical guess last."""
    physical: Array
    """(n,) physical guesses."""
    found: Array
    """(n,) min(|relative volume error|, 1), 1 for a miss."""
    owner: NDArray[np.intp]
    """(n,) which box."""
    fused: Mask
    """(n,) whether of two scans."""

    def of(self, part: Mask) -> "Runs":
        """Return some of them."""
        return Runs(self.inputs[part], self.physical[part], self.found[part], self.owner[part], self.fused[part])


def run(options: argparse.Namespace) -> None:
    """Print the table; write the model that is fitted to all boxes where ``--out`` says."""
    torch.set_num_threads(1)
    boxes = list(measured_boxes(options.scenes or BOXES, options.kept, options.workers))
    runs = _runs_of(boxes)
    fold = np.random.default_rng(0).integers(FOLDS, size=len(boxes))[runs.owner]
    learned = np.zeros(len(runs.found))
    for k in range(FOLDS):
        learned[fold == k] = _said(_fitted(runs.of(fold != k)), runs.of(fold == k))
    print("## Learned part of the expected error\n")
    print(f"{len(boxes)} boxes, {FOLDS} folds by box. Mean squared error of what is said of a run, a miss counts as 1; then the")
    print("mean outcome at each box's position that is said to be best, among one run of each (the best run is partly luck).\n")
    header = ("scans", "runs", "mean outcome", "constant answer", "physical guess", "learned", "at the physical guess's best",
              "at the learned one's", "at any position", "best run")  # fmt: skip
    rows = [_row(name, runs.of(part), learned[part]) for name, part in (("alone", ~runs.fused), ("fused in pairs", runs.fused))]
    print(markdown(header, rows) + "\n")
    if options.out is not None:
        write_whole(options.out, (json.dumps(_fitted(runs).to_dict()) + "\n").encode())


def _row(name: str, runs: Runs, learned: Array) -> tuple[str, ...]:
    said = {"physical": runs.physical, "learned": learned}
    squares = [bootstrap((each - runs.found) ** 2) for each in said.values()]
    errors = [
        f"{np.mean((each - runs.found) ** 2):.4f} ({low:.4f} to {high:.4f})"
        for each, (low, high) in zip(said.values(), squares, strict=True)
    ]
    if runs.fused.any():
        chosen = ["-"] * 4
    else:
        chosen = [percent(float(np.mean(_at_best(runs, each)))) for each in (runs.physical, learned)]
        own = [runs.found[runs.owner == box] for box in np.unique(runs.owner)]
        chosen += [percent(float(np.mean([each.mean() for each in own]))), percent(float(np.mean([each.min() for each in own])))]
    return (name, f"{len(runs.found):,}", percent(float(runs.found.mean())), f"{runs.found.var():.4f}", *errors, *chosen)


def _at_best(runs: Runs, said: Array) -> list[float]:
    """Return what came of each box's run of which the least error was said."""
    places = [np.flatnonzero(runs.owner == box) for box in np.unique(runs.owner)]
    return [float(runs.found[own[np.argmin(said[own])]]) for own in places]


def _runs_of(boxes: list[MeasuredBox]) -> Runs:
    inputs, physical, found, owner, fused = [], [], [], [], []
    for number, measured in enumerate(boxes):
        for box, known, seen, camera, error in _measurements(measured):
            if not any(view.returns.any() for view in seen):
                continue  # of what shows nothing nothing has to be learned
            guess = physical_error(box, known, seen, camera)
            inputs.append(np.append(circumstances(box, known, seen, camera), log_odds(guess)))
            physical.append(guess)
            found.append(outcome(error))
            owner.append(number)
            fused.append(len(seen) > 1)
    return Runs(np.array(inputs), np.array(physical), np.array(found), np.array(owner), np.array(fused))


def _measurements(measured: MeasuredBox) -> list[tuple[Box, Knowledge, tuple[Showing, ...], Sensor, float]]:
    """Return all of one box: the box, what is known of it, what each view shows, the camera, and the error."""
    camera, rows = sensor(measured.camera), []
    for view, error in measured.alone.items():
        seen = showing(measured.box, measured.stations[view], camera, 1.0)
        rows.append((measured.box, seen.knowledge, (seen,), camera, error))
    for present, following, error in measured.pairs:
        to_present = inverse(measured.stations[present])
        here = measured.box.in_frame(to_present)
        first = showing(here, np.eye(4), camera, 1.0)
        known, both = fused_showing(here, first, to_present @ measured.stations[following], camera)
        rows.append((here, known, both, camera, error))
    return rows


class _Correction(nn.Module):
    """The perceptron of :class:`viewgain.plan.ErrorModel`, to be fitted."""

    def __init__(self, inputs: int) -> None:
        super().__init__()
        self.layers = nn.Sequential(nn.Linear(inputs, WIDTH), nn.Tanh(), nn.Linear(WIDTH, WIDTH), nn.Tanh(), nn.Linear(WIDTH, 1))
        nn.init.zeros_(self.layers[-1].weight)
        nn.init.zeros_(self.layers[-1].bias)

    def forward(self, scaled: Tensor, odds: Tensor) -> Tensor:
        moved: Tensor = self.layers(scaled)[:, 0]
        return odds + MOST_SHIFT * torch.tanh(moved / MOST_SHIFT)


def _fitted(runs: Runs) -> ErrorModel:
    """Return the model that makes what is said likeliest, as a chance of a whole miss."""
    torch.manual_seed(0)
    draw = torch.Generator().manual_seed(0)
    mean, scale = runs.inputs.mean(axis=0), runs.inputs.std(axis=0) + 1e-3
    inputs = torch.tensor((runs.inputs - mean) / scale, dtype=torch.float32).clamp(-WITHIN, WITHIN)
    odds = torch.tensor(runs.inputs[:, -1], dtype=torch.float32)
    found = torch.tensor(runs.found, dtype=torch.float32)
    network = _Correction(inputs.shape[1])
    optimiser = torch.optim.AdamW(network.parameters(), RATE, weight_decay=DECAY)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, STEPS)
    for _ in range(STEPS):
        some = torch.randint(len(found), (BATCH,), generator=draw)
        blurred = inputs[some] + JITTER * torch.randn(BATCH, inputs.shape[1], generator=draw)
        loss = nn.functional.binary_cross_entropy_with_logits(network(blurred, odds[some]), found[some])
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
    layers = [layer for layer in network.layers if isinstance(layer, nn.Linear)]
    weights = tuple((_numbers(layer.weight), _numbers(layer.bias)) for layer in layers)
    return ErrorModel(np.round(mean, 5), np.round(scale, 5), weights)


def _numbers(parameter: Tensor) -> Array:
    return np.round(parameter.detach().numpy().astype(float), 5)


def _said(model: ErrorModel, runs: Runs) -> Array:
    pairs = zip(runs.physical, runs.inputs, strict=True)
    return np.array([model.corrected(float(guess), numbers[:-1]) for guess, numbers in pairs])

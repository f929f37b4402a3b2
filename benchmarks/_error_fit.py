"""The perceptrons of :class:`viewgain.plan.ErrorModel`, fitted to boxes that were measured."""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from benchmarks._measured_boxes import MeasuredBox
from viewgain.arrays import Array, Mask
from viewgain.box import Box
from viewgain.camera import Sensor, sensor
from viewgain.gain import costs
from viewgain.geometry import inverse
from viewgain.measure import Knowledge
from viewgain.plan import (
    MOST_SHIFT,
    WITHIN,
    ErrorModel,
    Outcome,
    Showing,
    circumstances,
    fused_showing,
    physical_outcome,
    showing,
    transformed,
)

MEMBERS = 4
"""Perceptrons of which the mean counts."""
WIDTH = 32
STEPS, BATCH, RATE, DECAY = 2000, 256, 3e-3, 0.3
JITTER = 0.03
"""Noise on the scaled inputs while fitting."""
WORTH = 100.0
"""Weight of how far off volumes are beside whether there are any: of the size of errors, a percent, turned over."""


@dataclass(frozen=True, slots=True, eq=False)
class Runs:
    """Scans, and pairs of scans, that were measured."""

    inputs: Array
    """(n, F) circumstances, then the physical guess as :func:`viewgain.plan.transformed` has it."""
    physical: tuple[Outcome, ...]
    """n physical guesses."""
    found: Array
    """(n,) min(|relative volume error|, 1), 1 for a miss."""
    owner: NDArray[np.intp]
    """(n,) which box."""
    fused: Mask
    """(n,) whether of two scans."""

    def of(self, part: Mask) -> "Runs":
        """Return some of them."""
        physical = tuple(self.physical[k] for k in np.flatnonzero(part))
        return Runs(self.inputs[part], physical, self.found[part], self.owner[part], self.fused[part])


def runs_of(boxes: list[MeasuredBox]) -> Runs:
    """Return what came of measuring some boxes, but for scans that show nothing: of these nothing has to be learned."""
    inputs, physical, found, owner, fused = [], [], [], [], []
    for number, measured in enumerate(boxes):
        for box, known, seen, camera, error in _measurements(measured):
            if not any(view.returns.any() for view in seen):
                continue
            guess = physical_outcome(box, known, seen, camera)
            inputs.append(np.append(circumstances(box, known, seen, camera), transformed(guess)))
            physical.append(guess)
            found.append(float(costs(error)))
            owner.append(number)
            fused.append(len(seen) > 1)
    return Runs(np.array(inputs), tuple(physical), np.array(found), np.array(owner), np.array(fused))


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


def fitted(runs: Runs) -> ErrorModel:
    """Return the model under which the runs are likeliest: misses as draws of a chance, errors as if they were counts.

    Both losses are least where what is said is the mean of what is found, whatever the spread.
    """
    mean, scale = runs.inputs.mean(axis=0), runs.inputs.std(axis=0) + 1e-3
    inputs = torch.tensor((runs.inputs - mean) / scale, dtype=torch.float32).clamp(-WITHIN, WITHIN)
    guesses = torch.tensor(runs.inputs[:, -2:], dtype=torch.float32)
    found = torch.tensor(runs.found, dtype=torch.float32)
    members = [_member(inputs, guesses, found, seed) for seed in range(MEMBERS)]
    layers = tuple(
        (_numbers([one.weight for one in same]), _numbers([one.bias for one in same])) for same in zip(*members, strict=True)
    )
    return ErrorModel(np.round(mean, 5), np.round(scale, 5), layers)


def _member(inputs: Tensor, guesses: Tensor, found: Tensor, seed: int) -> list[nn.Linear]:
    torch.manual_seed(seed)
    draw = torch.Generator().manual_seed(seed)
    layers = [nn.Linear(inputs.shape[1], WIDTH), nn.Linear(WIDTH, WIDTH), nn.Linear(WIDTH, 2)]
    nn.init.zeros_(layers[-1].weight)
    nn.init.zeros_(layers[-1].bias)
    network = nn.Sequential(layers[0], nn.Tanh(), layers[1], nn.Tanh(), layers[2])
    optimiser = torch.optim.AdamW(network.parameters(), RATE, weight_decay=DECAY)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, STEPS)
    for _ in range(STEPS):
        some = torch.randint(len(found), (BATCH,), generator=draw)
        blurred = inputs[some] + JITTER * torch.randn(BATCH, inputs.shape[1], generator=draw)
        moved = guesses[some] + MOST_SHIFT * torch.tanh(network(blurred) / MOST_SHIFT)
        loss = _loss(moved[:, 0], moved[:, 1], found[some])
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
    return layers


def _loss(odds: Tensor, size: Tensor, found: Tensor) -> Tensor:
    """Return the cross entropy of misses, and the Poisson deviance of the errors of volumes."""
    missed = (found >= 1).float()
    errors = size.exp() - found * size
    return nn.functional.binary_cross_entropy_with_logits(odds, missed) + WORTH * ((1 - missed) * errors).mean()


def _numbers(parameters: list[Tensor]) -> Array:
    return np.round(torch.stack(parameters).detach().numpy().astype(float), 4)

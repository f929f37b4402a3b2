"""How fast the networks are on one thread: forward, training step, onnxruntime; the textbook's edge convolution beside ours.

CPU time, medians; clouds are random, since no time depends on what they hold.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from benchmarks._tables import markdown
from tests.oracles.network import dense_edge_conv
from tests.oracles.networks_on_disk import card_of
from viewgain.inference import Scorer
from viewgain.network import PcNbv, ScoreNetwork, build, export_onnx, parameters_of, score_loss, weight_penalty
from viewgain.training import TrainingRecipe, training_recipe

RECIPES = ("pc_nbv", "pc_nbv_noview", "compact", "compact_fast")
BATCH = 4
REPEATS = 9
WARM_UP = 3


class Textbook(nn.Module):
    """A dense edge convolution as a textbook has it: all edges (n, k, 2C) of a cloud are laid into memory first."""

    def __init__(self, block: nn.Module) -> None:
        """Take the parameters of a fast one."""
        super().__init__()
        self.block = block

    def forward(self, features: Tensor, rows: Tensor) -> Tensor:
        """Return the same features, a cloud at a time."""
        first = features.shape[1] * torch.arange(len(features))
        neighbours = rows - first[:, None, None]
        return torch.stack([dense_edge_conv(self.block, *cloud) for cloud in zip(features, neighbours, strict=True)])


def run(options: argparse.Namespace) -> None:
    """Print the time of every network of :data:`RECIPES`, and of the paper-size ones with the textbook's edge convolution."""
    torch.set_num_threads(1)
    print(f"## Networks: milliseconds of CPU time per cloud, one thread, median of {REPEATS}; training batch {BATCH}\n")
    rows = [row for name in RECIPES for row in _rows(name)]
    header = ("network", "points", "parameters", "forward, torch", "forward, onnxruntime", "training step")
    print(markdown(header, rows) + "\n")
    _one_layer()


def _rows(name: str) -> list[tuple[object, ...]]:
    recipe = training_recipe(name)
    network = _fresh(recipe)
    size = (recipe.network.points, f"{parameters_of(network):,}")
    rows: list[tuple[object, ...]] = [(name, *size, _forward(network, recipe), _onnx(network, recipe), _step(network, recipe))]
    if isinstance(network, PcNbv):
        slow = _with_textbook(_fresh(recipe))
        rows.append((f"{name}, textbook edges", *size, _forward(slow, recipe), "", _step(slow, recipe)))
    return rows


def _fresh(recipe: TrainingRecipe) -> ScoreNetwork:
    return build(recipe.network, generator=torch.Generator().manual_seed(0))


def _with_textbook(network: PcNbv) -> PcNbv:
    blocks = network.features.blocks
    network.features.blocks = nn.ModuleList(Textbook(block) for block in blocks)
    return network


def _clouds(recipe: TrainingRecipe, batch: int) -> tuple[Tensor, Tensor, Tensor | None]:
    settings, generator = recipe.network, torch.Generator().manual_seed(1)
    points = torch.rand((batch, settings.points, 3), generator=generator) * 0.5 - 0.25
    state = torch.eye(settings.views)[:batch] if settings.with_view_state else None
    return points, torch.ones(points.shape[:2], dtype=torch.bool), state


def _forward(network: ScoreNetwork, recipe: TrainingRecipe) -> str:
    inputs = _clouds(recipe, 1)
    network.eval()
    with torch.inference_mode():
        return _milliseconds(lambda: network(*inputs))


def _step(network: ScoreNetwork, recipe: TrainingRecipe) -> str:
    """Return the time of one step of Adam, per cloud."""
    inputs, targets = _clouds(recipe, BATCH), torch.rand((BATCH, recipe.network.views))
    optimiser = torch.optim.Adam(network.parameters(), lr=1e-4)
    network.train()

    def step() -> None:
        optimiser.zero_grad()
        (score_loss(network(*inputs), targets, recipe.loss) + weight_penalty(network)).backward()
        optimiser.step()

    return _milliseconds(step, BATCH)


def _onnx(network: ScoreNetwork, recipe: TrainingRecipe) -> str:
    points, mask, state = _clouds(recipe, 1)
    feed = (points.numpy(), mask.numpy(), None if state is None else state.numpy())
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "network.onnx"
        export_onnx(network, recipe.network, card_of(recipe.network), path)
        scorer = Scorer.load(path, threads=1)
        return _milliseconds(lambda: scorer.run(*feed))


def _one_layer() -> None:
    """Print the time of one dense edge convolution of the paper's size."""
    recipe = training_recipe("pc_nbv")
    block = _fresh(recipe).features.blocks[0]
    features = torch.rand((BATCH, 512, 24), generator=torch.Generator().manual_seed(2)).requires_grad_()
    rows = torch.randint(512, (BATCH, 512, 16), generator=torch.Generator().manual_seed(3))
    rows = rows + 512 * torch.arange(BATCH)[:, None, None]
    print(f"One dense edge convolution, 512 points, 16 neighbours, 24 channels, per cloud of {BATCH}:\n")
    table = []
    for name, layer in (("ours, projected before gathered", block), ("textbook, edges in memory", Textbook(block))):
        with torch.no_grad():
            forward = _milliseconds(lambda layer=layer: layer(features, rows), BATCH)
        both = _milliseconds(lambda layer=layer: layer(features, rows).sum().backward(), BATCH)
        table.append((name, forward, both))
    print(markdown(("layer", "forward", "forward and backward"), table) + "\n")


def _milliseconds(work: Callable[[], object], clouds: int = 1) -> str:
    """Return the median CPU time per cloud, after some runs to warm up."""
    for _ in range(WARM_UP):
        work()
    spent = []
    for _ in range(REPEATS):
        start = time.process_time()
        work()
        spent.append(time.process_time() - start)
    return f"{1e3 * float(np.median(spent)) / clouds:.1f}"

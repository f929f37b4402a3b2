"""How fast the networks are on one thread: forward, training step, onnxruntime; the textbook's edge convolution beside ours.

CPU time, medians; clouds are random, since no time depends on what they hold.
"""

import argparse
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TypeAlias

import numpy as np
import torch
from torch import Tensor, nn

from benchmarks._tables import markdown
from tests.oracles.network import dense_edge_conv
from tests.oracles.networks_on_disk import card_of
from viewgain.inference import Scorer
from viewgain.network import PcNbv, ScoreNetwork, build, export_onnx, parameters_of, score_loss, weight_penalty
from viewgain.training import TrainingRecipe, training_recipe

Work: TypeAlias = Callable[[], object]
PUBLISHED = ("pc_nbv", "pc_nbv_noview")
"""Also with the textbook's edge convolution."""
RECIPES = (*PUBLISHED, "pc_nbv_noview_short", "compact")
TEXTBOOK = ", textbook edges"
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
    networks = {name: (network, training_recipe(recipe)) for name, recipe, network in _networks()}
    sizes = [(recipe.network.points, f"{parameters_of(network):,}") for network, recipe in networks.values()]
    forward = _milliseconds([_forward(*each) for each in networks.values()])
    onnx = _milliseconds([_onnx(*each) for name, each in networks.items() if TEXTBOOK not in name])
    steps, halves = (_milliseconds([_step(*each, half=half) for each in networks.values()], BATCH) for half in (False, True))
    exported = iter(onnx)
    rows = [
        (name, *size, ahead, "" if TEXTBOOK in name else next(exported), step, half)
        for name, size, ahead, step, half in zip(networks, sizes, forward, steps, halves, strict=True)
    ]
    header = (
        "network",
        "points",
        "parameters",
        "forward, torch",
        "forward, onnxruntime",
        "training step",
        "training step, bfloat16",
    )
    print(markdown(header, rows) + "\n")
    _one_layer()


def _networks() -> Iterator[tuple[str, str, ScoreNetwork]]:
    """Yield the name of each network, that of its recipe, and itself."""
    for recipe in RECIPES:
        network = _fresh(training_recipe(recipe))
        yield recipe, recipe, network
        if recipe in PUBLISHED:
            yield f"{recipe}{TEXTBOOK}", recipe, _with_textbook(_fresh(training_recipe(recipe)))


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


def _forward(network: ScoreNetwork, recipe: TrainingRecipe) -> Work:
    """Return the scoring of one cloud."""
    inputs = _clouds(recipe, 1)

    def forward() -> None:
        network.eval()
        with torch.inference_mode():
            network(*inputs)

    return forward


def _step(network: ScoreNetwork, recipe: TrainingRecipe, *, half: bool) -> Work:
    """Return one step of Adam on a batch, the network in single precision or in bfloat16."""
    inputs, targets = _clouds(recipe, BATCH), torch.rand((BATCH, recipe.network.views))
    optimiser = torch.optim.Adam(network.parameters(), lr=1e-4)

    def step() -> None:
        network.train()
        optimiser.zero_grad()
        with torch.autocast("cpu", dtype=torch.bfloat16, enabled=half):
            scores = network(*inputs)
        (score_loss(scores.float(), targets, recipe.loss) + weight_penalty(network)).backward()
        optimiser.step()

    return step


def _onnx(network: ScoreNetwork, recipe: TrainingRecipe) -> Work:
    """Return the scoring of one cloud by onnxruntime."""
    points, mask, state = _clouds(recipe, 1)
    feed = (points.numpy(), mask.numpy(), None if state is None else state.numpy())
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "network.onnx"
        export_onnx(network, recipe.network, card_of(recipe.network), path)
        scorer = Scorer.load(path, threads=1)
    return lambda: scorer.run(*feed)


def _one_layer() -> None:
    """Print the time of one dense edge convolution of the paper's size."""
    recipe = training_recipe("pc_nbv")
    block = _fresh(recipe).features.blocks[0]
    features = torch.rand((BATCH, 512, 24), generator=torch.Generator().manual_seed(2)).requires_grad_()
    rows = torch.randint(512, (BATCH, 512, 16), generator=torch.Generator().manual_seed(3))
    rows = rows + 512 * torch.arange(BATCH)[:, None, None]
    print(f"One dense edge convolution, 512 points, 16 neighbours, 24 channels, per cloud of {BATCH}:\n")
    layers = {"ours, projected before gathered": block, "textbook, edges in memory": Textbook(block)}
    with torch.no_grad():
        forward = _milliseconds([partial(layer, features, rows) for layer in layers.values()], BATCH)
    both = _milliseconds([partial(_there_and_back, layer, features, rows) for layer in layers.values()], BATCH)
    print(markdown(("layer", "forward", "forward and backward"), list(zip(layers, forward, both, strict=True))) + "\n")


def _there_and_back(layer: nn.Module, features: Tensor, rows: Tensor) -> None:
    layer(features, rows).sum().backward()


def _milliseconds(works: Sequence[Work], clouds: int = 1) -> list[str]:
    """Return the median CPU time per cloud of each work; they take turns, so that a busy machine slows all alike."""
    spent = np.zeros((WARM_UP + REPEATS, len(works)))
    for turn, column in np.ndindex(spent.shape):
        start = time.process_time()
        works[column]()
        spent[turn, column] = time.process_time() - start
    return [f"{1e3 * seconds / clouds:.1f}" for seconds in np.median(spent[WARM_UP:], axis=0)]

"""Can a cloud tell from which view it was seen? By how evenly its points lie in each image, and by networks that guess."""

import argparse
from collections.abc import Iterator

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from benchmarks._tables import markdown, percent
from viewgain.arrays import Points
from viewgain.datasets import CoverageSettings, recipe
from viewgain.evaluation import shares_by_object
from viewgain.gain import COVERAGE_PROTOCOLS, model_clouds
from viewgain.inference import thinned
from viewgain.network import STATISTICS, ScoreNetwork, evenness, half_rounded, in_order, stations_of
from viewgain.shapes import procedural
from viewgain.training import load_trained

OBJECTS = 6
"""Of each category."""
SEED = 6100
"""Of the objects; nothing else draws them."""
POINTS = 512
_PROTOCOL = COVERAGE_PROTOCOLS["paper"]


def run(options: argparse.Namespace) -> None:
    """Print one table per kind; networks are the runs that ``--runs`` names."""
    torch.set_num_threads(1)
    networks = {path.name: half_rounded(load_trained(path).module) for path in options.runs or []}
    count = options.scenes or OBJECTS
    print(f"## From which of {_PROTOCOL.rig}'s views a cloud of {POINTS} points was seen, right in percent\n")
    print(f"{count} fresh objects of each of 8 categories, from every view; 95 % intervals by object.\n")
    for kind, categories in _kinds().items():
        rows = list(_answers(categories, count, networks))
        owner = np.array([number for number, _ in rows])
        right = {name: np.array([answers[name] for _, answers in rows]) for name in rows[0][1]}
        print(markdown((kind, f"right, of {len(owner):,}"), [(name, _share(each, owner)) for name, each in right.items()]))
        print()


def _kinds() -> dict[str, tuple[str, ...]]:
    """Return the categories that train the 16-view networks, and those that do not."""
    content = recipe("coverage_table1").content
    assert isinstance(content, CoverageSettings)
    return {"seen": content.categories, "unseen": content.held_out}


def _share(right: NDArray[np.float64], owner: NDArray[np.int64]) -> str:
    found = shares_by_object(right[:, None], owner, rng=np.random.default_rng(0))
    return f"{percent(found.mean[0])} ({percent(found.low[0])} to {percent(found.high[0])})"


def _answers(
    categories: tuple[str, ...], count: int, networks: dict[str, ScoreNetwork]
) -> Iterator[tuple[int, dict[str, float]]]:
    """Yield of each cloud the number of its object, and who names its view."""
    stations = torch.from_numpy(stations_of(_PROTOCOL.rig)).float()
    for number, category in enumerate(categories * count):
        rng = np.random.default_rng([SEED, number])
        for view, cloud in enumerate(model_clouds(procedural(category, rng=rng), _PROTOCOL)):
            if len(cloud) >= POINTS:
                points = _drawn(cloud, rng)
                yield number, {"by chance": 1 / len(stations), **_right(points, view, stations, networks)}


def _right(points: Tensor, view: int, stations: Tensor, networks: dict[str, ScoreNetwork]) -> dict[str, float]:
    mask = torch.ones(points.shape[:2], dtype=torch.bool)
    even = evenness(*in_order(points, mask), stations)[0]
    named = {f"least {name}": int(even[:, k].argmin()) for k, name in enumerate(STATISTICS) if k}
    with torch.inference_mode():
        named |= {f"guess of {name}": int(network.located(points, mask)[1][0].argmax()) for name, network in networks.items()}
    return {name: float(answer == view) for name, answer in named.items()}


def _drawn(cloud: Points, rng: np.random.Generator) -> Tensor:
    return torch.from_numpy(cloud[thinned(cloud, POINTS, "random", rng=rng)]).float()[None]

"""Small networks with fresh weights as files, for tests of everything that reads one."""

from pathlib import Path
from typing import Any

import torch

from viewgain.inference import ModelCard
from viewgain.network import Kind, NetworkSettings, ScoreNetwork, build, export_onnx, half_rounded


def small_settings(kind: Kind, *, views: int = 16, uncertainty: Any = "none", points: int = 64, rig: str = "") -> NetworkSettings:
    """Return a narrow network."""
    return NetworkSettings(
        kind=kind, views=views, points=points, neighbours=8, growth=4, shared=(32, 24), head=(24, 16), width=16,
        uncertainty=uncertainty, rig=rig,
    )  # fmt: skip


def card_of(settings: NetworkSettings, **changes: Any) -> ModelCard:
    """Return a card that fits a network; ``changes`` are its other fields."""
    told = settings.with_view_state
    values: dict[str, Any] = {
        "name": "small", "task": "Share of the surface that each view would add.", "kind": settings.kind, "rig": "pcnbv16",
        "views": settings.views, "points": settings.points, "with_view_state": told,
        "order": "rig" if told else "present_first", "uncertainty": settings.uncertainty != "none",
    }  # fmt: skip
    return ModelCard(**(values | changes))


def exported(path: Path, settings: NetworkSettings, *, seed: int = 0, **changes: Any) -> ScoreNetwork:
    """Write a network of fresh weights and its card; return the network as the file holds it."""
    torch.set_num_threads(1)
    network = build(settings, generator=torch.Generator().manual_seed(seed))
    with torch.no_grad():
        for name, parameter in network.named_parameters():
            if name.endswith("gamma"):
                parameter.fill_(0.5)
    export_onnx(network, settings, card_of(settings, **changes), path)
    return half_rounded(network)

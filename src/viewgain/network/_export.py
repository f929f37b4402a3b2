"""From a trained network to an ONNX file with its card: weights stored as half floats, all computed in single precision."""

import contextlib
import copy
import math
import tempfile
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from viewgain.errors import ConfigError, MissingExtraError
from viewgain.inference import CARD_KEY, INPUTS, POSE_INPUTS, ModelCard, to_markdown
from viewgain.network._build import parameters_of
from viewgain.network._inputs import ScoreNetwork
from viewgain.network._output import log_variance_of, scores_of
from viewgain.network._settings import NetworkSettings

OPSET = 18
"""Version of the ONNX operators: of 2022, so that older runtimes read the file too."""
EXAMPLE = 40
"""Points of the clouds that the network is traced with, at least; the number stays open."""


class _Scored(nn.Module):
    """What is exported: the network behind its checks; with uncertainty (B, V, 2), scores and logarithms of variances."""

    def __init__(self, network: ScoreNetwork, sigma_scale: float) -> None:
        super().__init__()
        self.network, self.added = network, 2 * math.log(sigma_scale)

    def forward(self, points: Tensor, mask: Tensor, view_state: Tensor | None = None) -> Tensor:
        output = self.network.scored(points, mask, view_state)
        log_variance = log_variance_of(output)
        return output if log_variance is None else torch.stack((scores_of(output), log_variance + self.added), dim=-1)


def half_rounded(network: ScoreNetwork) -> ScoreNetwork:
    """Return a copy on the CPU, for use and not for training, whose parameters are those that the file will hold.

    Raises:
        ConfigError: If a parameter is not finite, or too large for a half float.
    """
    rounded = copy.deepcopy(network).to("cpu", torch.float32).eval()
    with torch.no_grad():
        for name, parameter in rounded.named_parameters():
            parameter.copy_(parameter.half().float())
            if not torch.isfinite(parameter).all():
                raise ConfigError(f"export: got numbers in {name} that are not finite as half floats, wanted sound weights")
    return rounded.requires_grad_(False)


def export_onnx(
    module: ScoreNetwork, settings: NetworkSettings, card: ModelCard, path: Path, *, sigma_scale: float = 1.0
) -> None:
    """Write a network as ONNX with its card inside, and the card as Markdown beside it (``.md``).

    Batch and number of points stay open; the latter must exceed the neighbours that the network looks at. The file holds exactly
    :func:`half_rounded`.

    Args:
        module: The network.
        settings: What it was built from.
        card: Its card; ``parameters`` is filled in.
        path: File to write, ``.onnx``.
        sigma_scale: Factor on all standard deviations, over 0: how much larger errors on objects aside are than the network says.

    Raises:
        ConfigError: If card and network contradict each other, or weights do not fit half floats.
        MissingExtraError: If onnx is not installed.
    """
    try:
        import onnx
    except ImportError as error:
        raise MissingExtraError("export wants onnx; pip install 'viewgain[train]'") from error
    card = replace(card, parameters=parameters_of(module))
    _check(settings, card, path, sigma_scale)
    model = onnx.load_model_from_string(_traced(half_rounded(module), settings, sigma_scale))
    _store_halves(model)
    onnx.helper.set_model_props(model, {CARD_KEY: card.to_json()})
    model.producer_name, model.doc_string = "viewgain", card.task
    onnx.checker.check_model(model)
    _written(path, model.SerializeToString())
    _written(path.with_suffix(".md"), to_markdown(card).encode())


def _check(settings: NetworkSettings, card: ModelCard, path: Path, sigma_scale: float) -> None:
    told = (settings.kind, settings.views, settings.points, settings.with_view_state, settings.uncertainty != "none")
    said = (card.kind, card.views, card.points, card.with_view_state, card.uncertainty)
    if told != said:
        raise ConfigError(
            f"export: got a card of kind, views, points, view state, uncertainty {said}, wanted {told} as the network has"
        )
    if settings.points <= settings.neighbours:
        raise ConfigError(f"export: got {settings.points} points and {settings.neighbours} neighbours, wanted more points")
    if not 0 < sigma_scale < math.inf:
        raise ConfigError(f"export: got a factor of {sigma_scale} on the standard deviations, wanted a positive one")
    if path.suffix != ".onnx":
        raise ConfigError(f"export: got {path.name}, wanted a file name ending in .onnx")


def _traced(network: ScoreNetwork, settings: NetworkSettings, sigma_scale: float) -> bytes:
    """Return the network as ONNX in single precision, every parameter as it is."""
    number = max(EXAMPLE, 2 * settings.neighbours)
    inputs = [torch.linspace(-0.5, 0.5, 6 * number).sin().reshape(2, number, 3), torch.ones(2, number, dtype=torch.bool)]
    inputs += [torch.zeros(2, settings.views)] if settings.with_view_state else []
    inputs += [torch.eye(4).expand(2, 3, 4, 4).clone()] if settings.with_poses else []
    names = POSE_INPUTS if settings.with_poses else INPUTS[: len(inputs)]
    axes = {name: {0: "batch"} for name in (*names, "scores")}
    for name in ("points", "mask"):
        axes[name][1] = "number"
    for name in ("candidates", "scores") if settings.with_poses else ():
        axes[name][1] = "views"
    with tempfile.TemporaryDirectory() as folder, _quiet():
        file = Path(folder) / "traced.onnx"
        # The tracing exporter: that by torch.export takes ten times as long and wants onnxscript. Nothing is folded, or a
        # difference of two parameters would be stored, which is no half float.
        torch.onnx.export(
            _Scored(network, sigma_scale).eval(),
            tuple(inputs),
            file,
            dynamo=False,
            input_names=list(names),
            output_names=["scores"],
            dynamic_axes=axes,
            opset_version=OPSET,
            do_constant_folding=False,
        )
        return file.read_bytes()


@contextlib.contextmanager
def _quiet() -> Iterator[None]:
    """Keep torch's remarks about tracing to itself: what they warn of (fixed sizes) is tested."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def _store_halves(model: Any) -> None:
    """Store every parameter as half floats and cast it to single precision when the file is loaded."""
    from onnx import TensorProto, helper, numpy_helper

    graph, casts = model.graph, []
    for place, stored in enumerate(list(graph.initializer)):
        if stored.data_type != TensorProto.FLOAT or int(np.prod(stored.dims)) == 1:
            continue
        values = numpy_helper.to_array(stored)
        half = values.astype(np.float16)
        if not np.array_equal(half.astype(np.float32), values):
            raise ConfigError(f"export: parameter {stored.name} is no half float; export a network as half_rounded returns it")
        casts.append(helper.make_node("Cast", [f"{stored.name}.half"], [stored.name], to=TensorProto.FLOAT))
        graph.initializer[place].CopyFrom(numpy_helper.from_array(half, f"{stored.name}.half"))
    nodes = [*casts, *graph.node]
    del graph.node[:]
    graph.node.extend(nodes)


def _written(path: Path, content: bytes) -> None:
    """Write a file whole or not at all."""
    part = path.with_name(f"{path.name}.part")
    part.write_bytes(content)
    part.replace(path)

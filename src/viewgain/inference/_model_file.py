"""A network file and its card, opened by onnxruntime: what every scorer runs on."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewgain.errors import ConfigError, ModelError, one_line
from viewgain.inference._card import ModelCard
from viewgain.inference._shipped import find_model

CARD_KEY = "viewgain_card"
"""Where the card lies in the file's metadata."""
_SILENT = 4


@dataclass(frozen=True, slots=True, eq=False)
class ModelFile:
    """An open network."""

    path: Path
    """Where it was read from."""
    session: Any
    """Of onnxruntime."""
    card: ModelCard
    """What it says of itself."""

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of its inputs."""
        return tuple(each.name for each in self.session.get_inputs())

    @property
    def output_shape(self) -> list[Any]:
        """Shape of its output without the batch: numbers, or names where they may vary."""
        return list(self.session.get_outputs()[0].shape[1:])

    def run(self, feed: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
        """Return what the network gives.

        Raises:
            ModelError: If it cannot be run, or its result is not finite: the file is damaged.
        """
        try:
            output: NDArray[np.float32] = self.session.run(None, dict(feed))[0]
        except Exception as error:  # onnxruntime's errors share no base class of their own
            raise ModelError(f"network {self.card.name}: cannot be run ({one_line(error)}); get the file again") from error
        if not np.all(np.isfinite(output)):
            raise ModelError(f"network {self.card.name}: gave scores that are not finite; get the file again")
        return output


def open_model(model: str | Path, threads: int) -> ModelFile:
    """Return the network of a file, or of a shipped name.

    Raises:
        ModelError: If there is no such file or name, or it is damaged, or of another program.
        ConfigError: If ``threads`` is under 1.
    """
    if threads < 1:
        raise ConfigError(f"network: got {threads} threads, wanted at least 1")
    path = find_model(model)
    session = _opened(path, threads)
    text = session.get_modelmeta().custom_metadata_map.get(CARD_KEY)
    if text is None:
        raise ModelError(f"{path}: a network of another program (it has no viewgain card); use viewgain export")
    try:
        return ModelFile(path, session, ModelCard.from_json(text))
    except ModelError as error:
        raise ModelError(f"{path}: {error}") from error


def _opened(path: Path, threads: int) -> Any:
    """Return a session of onnxruntime. The content is read first, so that the file cannot refer to others."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads, options.inter_op_num_threads = threads, 1
    options.log_severity_level = _SILENT
    try:
        content = path.read_bytes()
        return onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime's errors share no base class of their own
        raise ModelError(f"{path}: cannot be read as a network ({one_line(error)}); get the file again") from error

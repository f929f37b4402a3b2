"""Checkpoints as safetensors files: written whole or not at all, checked when read, and never unpickled.

A file states the checksum of its tensors, so that one that a full disk or a crash cut short is known for what it is.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from viewgain.datasets import write_whole
from viewgain.errors import MissingExtraError, TrainingError, one_line

_STATE, _DIGEST = "viewgain", "sha256"
KEPT = 2
"""Checkpoints of a run that are kept: the newest, and the one before it in case the newest is damaged."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Checkpoint:
    """Tensors by name, and the rest as plain values."""

    tensors: Mapping[str, Tensor]
    """On the CPU."""
    state: Mapping[str, Any]
    """What JSON can say."""

    def part(self, name: str) -> dict[str, Tensor]:
        """Return the tensors whose names begin with ``NAME.``, without that beginning."""
        start = f"{name}."
        return {key.removeprefix(start): value for key, value in self.tensors.items() if key.startswith(start)}


def write_checkpoint(path: Path, checkpoint: Checkpoint) -> None:
    """Write a checkpoint in place of an old one, whole or not at all.

    Raises:
        StorageError: If it cannot be written.
        MissingExtraError: If safetensors is not installed.
    """
    require_safetensors()
    from safetensors.torch import save

    tensors = {name: tensor.detach().cpu().contiguous().clone() for name, tensor in checkpoint.tensors.items()}
    write_whole(path, save(tensors, {_STATE: json.dumps(checkpoint.state), _DIGEST: _digest(tensors)}))


def read_checkpoint(path: Path) -> Checkpoint:
    """Return a checkpoint.

    Raises:
        TrainingError: If it is missing, cut short, changed or no checkpoint at all.
        MissingExtraError: If safetensors is not installed.
    """
    require_safetensors()
    from safetensors import SafetensorError, safe_open

    try:
        with safe_open(path, framework="pt") as file:
            metadata = file.metadata() or {}
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - it is no mapping
    except (OSError, SafetensorError, ValueError) as error:
        raise TrainingError(f"{path}: cannot be read as a checkpoint ({one_line(error)})") from error
    if metadata.get(_DIGEST) != _digest(tensors):
        raise TrainingError(f"{path}: its tensors are not those that were written; use another checkpoint")
    return Checkpoint(tensors=tensors, state=json.loads(metadata[_STATE]))


def newest_good(folder: Path) -> Checkpoint | None:
    """Return the newest checkpoint of a folder that can be read; None if there is none."""
    for path in sorted(folder.glob("step-*.safetensors"), reverse=True):
        try:
            return read_checkpoint(path)
        except TrainingError:
            continue
    return None


def step_path(folder: Path, step: int) -> Path:
    """Return the path of the checkpoint of a step."""
    return folder / f"step-{step:09d}.safetensors"


def remove_old(folder: Path) -> None:
    """Remove all checkpoints but the last :data:`KEPT`, and what a killed write left behind."""
    for path in sorted(folder.glob("step-*.safetensors"))[:-KEPT]:
        path.unlink(missing_ok=True)
    for path in folder.glob(".*.tmp"):
        path.unlink(missing_ok=True)


def require_safetensors() -> None:
    """Check that torch and safetensors can be imported.

    Raises:
        MissingExtraError: If one is not installed.
    """
    try:
        import safetensors.torch  # noqa: F401
    except ImportError as error:
        raise MissingExtraError('training needs torch and safetensors: pip install "viewgain[train]"') from error


def _digest(tensors: Mapping[str, Tensor]) -> str:

    digest = hashlib.sha256()
    for name in sorted(tensors):
        tensor = tensors[name].contiguous()
        digest.update(f"{name} {tensor.dtype} {tuple(tensor.shape)}\n".encode())
        digest.update(tensor.reshape(-1).view(torch.uint8).numpy().tobytes())
    return digest.hexdigest()

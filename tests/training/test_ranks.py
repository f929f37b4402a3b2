"""Two processes that work together: their averaged gradients are those of one process with the whole batch."""

import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest
import torch
from safetensors.torch import load_file

from viewgain.datasets import Dataset

ROOT = Path(__file__).parents[2]


def gradients(processes: int, data: Path, out: Path, *loss: str) -> dict[str, torch.Tensor]:
    """Return what process 0 has after one step, whose gradients stay until the next."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    shared = {**os.environ, "MASTER_ADDR": "127.0.0.1", "MASTER_PORT": str(port), "WORLD_SIZE": str(processes)}
    command = [sys.executable, "-m", "tests.training.gradients", str(data), str(out), *loss]
    started = [
        subprocess.Popen(command, cwd=ROOT, env={**shared, "RANK": str(rank)}, stderr=subprocess.PIPE, text=True)
        for rank in range(processes)
    ]
    for process in started:
        _, complaint = process.communicate(timeout=300)
        assert process.returncode == 0, complaint
    return load_file(out)


@pytest.mark.slow
@pytest.mark.parametrize("loss", [("listwise", "mean"), ("none", "half_sum")])
def test_gradients_of_two_processes_are_those_of_one(loss: tuple[str, str], data: Dataset, tmp_path: Path) -> None:
    one = gradients(1, data.folder, tmp_path / "one", *loss)
    two = gradients(2, data.folder, tmp_path / "two", *loss)
    assert one.keys() == two.keys()
    largest = max(float(each.abs().max()) for each in one.values())
    assert largest > 1e-2
    for name, wanted in one.items():  # a small gradient is a sum of large terms that cancel, and is rounded as those are
        torch.testing.assert_close(two[name], wanted, rtol=0, atol=1e-6 * max(1.0, largest), msg=name)

"""``viewgain train`` as processes: killed and taken up again, two that work together, and what goes wrong."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import torch

from tests.training.conftest import built_in
from viewgain.datasets import Dataset
from viewgain.training import RunFolder, read_checkpoint

RECIPE = """
makes = "nothing of use"
[network]
kind = "compact_view"
views = 16
points = 32
neighbours = 4
width = 4
[data]
rig = "pcnbv16"
validation_share = 0.5
resident = 64
[training]
iterations = {iterations}
batch = 6
learning_rate = {rate}
log_every = 2
validate_every = 4
checkpoint_minutes = 0.0
"""


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return built_in(tmp_path_factory.mktemp("data"))


def recipe_in(folder: Path, *, iterations: int = 40, rate: float = 1e-2) -> Path:
    path = folder / "quick.toml"
    path.write_text(RECIPE.format(iterations=iterations, rate=rate))
    return path


def command(*arguments: object, module: str = "viewgain") -> list[str]:
    return [sys.executable, "-m", module, *map(str, arguments)]


def run(*arguments: object, module: str = "viewgain") -> subprocess.CompletedProcess[str]:
    done = command(*arguments, module=module)
    return subprocess.run(done, capture_output=True, text=True, timeout=300, check=False)


def curve(folder: Path) -> list[tuple[int, object]]:
    return [(line["step"], line.get("validation", line.get("loss"))) for line in RunFolder(folder).metrics()]


def kill_after(folder: Path, lines: int, *arguments: object) -> None:
    """Start a command and kill it once its metrics have so many lines."""
    process = subprocess.Popen(command(*arguments), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 200
    while process.poll() is None and len(RunFolder(folder).metrics()) < lines and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="a kill that cannot be caught")
def test_a_killed_run_goes_on_as_if_it_had_not_been_killed(data: Dataset, tmp_path: Path) -> None:
    recipe = recipe_in(tmp_path, iterations=200)
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    done = run("train", recipe, "--data", data.folder, "--out", whole, "--device", "cpu")
    assert done.returncode == 0, done.stderr
    assert "best weights are of step" in done.stdout
    assert (whole / "curves.png").read_bytes().startswith(b"\x89PNG")
    kill_after(killed, 20, "train", recipe, "--data", data.folder, "--out", killed, "--device", "cpu")
    assert run("train", "--resume", killed, "--device", "cpu").returncode == 0
    assert curve(killed) == curve(whole)


@pytest.mark.slow
def test_two_processes_make_the_steps_of_one(data: Dataset, tmp_path: Path) -> None:
    recipe = recipe_in(tmp_path, iterations=8)
    arguments = ("train", recipe, "--data", data.folder, "--device", "cpu", "--out")
    assert run(*arguments, tmp_path / "one").returncode == 0
    launcher = ("--nproc-per-node", 2, "--master-port", 0, "--standalone", "-m", "viewgain")
    done = run(*launcher, *arguments, tmp_path / "two", module="torch.distributed.run")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("ended after 8 steps") == 1
    one, two = (read_checkpoint(tmp_path / name / "checkpoints" / "step-000000008.safetensors") for name in ("one", "two"))
    for name, tensor in one.part("model").items():
        if name.endswith("key.bias"):
            continue  # softmax does not see it: its gradient is rounding alone, which Adam makes whole steps of
        # The mean of two means is rounded otherwise than one mean, and Adam's first steps are as long for small gradients.
        torch.testing.assert_close(two.part("model")[name], tensor, rtol=0, atol=2e-4, msg=name)
    assert [step for step, _ in curve(tmp_path / "two")] == [step for step, _ in curve(tmp_path / "one")]


@pytest.mark.slow
def test_a_run_that_diverges_says_so(data: Dataset, tmp_path: Path) -> None:
    done = run("train", recipe_in(tmp_path, rate=1e18), "--data", data.folder, "--out", tmp_path / "run")
    assert done.returncode == 3
    assert "not finite" in done.stdout


@pytest.mark.slow
def test_wrong_usage_is_one_line_and_exit_code_2(tmp_path: Path) -> None:
    recipe = recipe_in(tmp_path)
    for arguments, word in [
        ((recipe, "--data", tmp_path / "nowhere", "--out", tmp_path / "a"), "holds no data set"),
        (("--resume", tmp_path), "holds no run"),
        ((recipe, "--minutes", -1), "minutes"),
    ]:
        done = run("train", *arguments)
        assert done.returncode == 2
        assert done.stderr.strip().splitlines()[-1].startswith("viewgain: error:")
        assert word in done.stderr


@pytest.mark.slow
def test_the_tiny_recipe_learns_through_the_real_command(tmp_path: Path) -> None:
    done = run("train", "tiny", "--out", tmp_path / "run", "--device", "cpu")
    assert done.returncode == 0, done.stderr
    losses = [loss for _, loss in curve(tmp_path / "run") if isinstance(loss, float)]
    assert losses[-1] < 0.5 * losses[0]
    assert json.loads((tmp_path / "run" / "run.json").read_text())["facts"]["training"]["objects"] == 9

"""What a user reads where the extra that a command stands on is not installed."""

import subprocess
import sys

import pytest

WITHOUT_TORCH = """
import sys
class Missing:
    def find_spec(self, name, path=None, target=None):
        if name == "torch":
            raise ModuleNotFoundError("No module named 'torch'", name="torch")
sys.meta_path.insert(0, Missing())
from viewgain.cli import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize("command", [["train", "tiny"], ["export", "run", "--out", "network.onnx"]])
def test_without_torch_training_names_the_extra_in_one_line(command: list[str]) -> None:
    done = subprocess.run([sys.executable, "-c", WITHOUT_TORCH, *command], capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr == 'viewgain: error: this command needs torch: pip install "viewgain[train]"\n'


def test_without_torch_a_data_set_is_judged_all_the_same() -> None:
    """Evaluation runs through onnxruntime; here only as far as the missing folder."""
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_TORCH, "evaluate", "table1", "--data", "nowhere"], capture_output=True, text=True
    )
    assert done.returncode == 2
    assert done.stderr.startswith("viewgain: error: nowhere")

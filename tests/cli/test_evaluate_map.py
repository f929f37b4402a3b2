"""``viewgain evaluate map`` through the real command: one box, its table, its files, and what goes wrong."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.oracles.networks_on_disk import exported
from viewgain.cli import main
from viewgain.evaluation import VolumeSettings, volume_case
from viewgain.evaluation._choice import seen_of
from viewgain.inference import PoseScorer
from viewgain.network import NetworkSettings
from viewgain.plan import VolumeNetworkPolicy

ARGUMENTS = ("--captures", "2", "--estimator", "lines_published", "--side", "0.2", "0.5", "--seed", "5", "--rig", "ring8")


def test_the_map_is_written_with_its_policies_and_a_network_says_errors(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    pytest.importorskip("matplotlib")
    file = tmp_path / "net.onnx"
    settings = NetworkSettings(kind="pose_scores", views=5, points=64, neighbours=8, width=8, centres=(16, 8))
    exported(file, settings, rig="irregular", normalisation="metres", frame="camera")
    out = tmp_path / "map"
    names = ("farthest", f"network:{file}")
    assert main(["evaluate", "map", "--json", *ARGUMENTS, "--box", "1", "--policies", *names, "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    content = json.loads(printed)
    assert (out / "map.json").read_text() == printed
    assert (out / "map.md").read_text().startswith("## What each position is worth: box 1 of seed 5")
    assert (out / "map.png").read_bytes().startswith(b"\x89PNG")
    case = volume_case(VolumeSettings(seed=5, captures=2, estimator="lines_published", side=(0.2, 0.5), rig="ring8"), 1)
    scores = VolumeNetworkPolicy(PoseScorer.load(file)).scores(seen_of(case))
    network = content["policies"][1]
    assert (network["name"], network["meaning"]) == (names[1], "error")
    np.testing.assert_allclose(network["values"], -scores, rtol=1e-4)
    assert network["best"] == int(np.argmax(np.where(case.reachable, scores, -np.inf)))
    worth = [each["error"] for each in content["positions"]]
    assert content["best"] == int(np.argmin([np.inf if each is None else each for each in worth]))
    assert network["error_of_its_best"] == worth[network["best"]]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--box", "-1"], "got box -1, wanted 0 or more"),
        (["--policies", "oracle"], "'oracle' scores no positions"),
        (["--policies", "wizard"], "'wizard' is not known"),
        (["--policies", "network:nowhere.onnx"], "nowhere.onnx"),
        (["--rig", "paper4"], "stand in one direction"),
        (["--captures", "1"], "2 or more"),
    ],
)
def test_bad_questions_end_in_one_line(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", "map", *ARGUMENTS, *arguments]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count("\n") == 1


def test_a_folder_that_cannot_be_written_ends_in_exit_code_4(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert main(["evaluate", "map", *ARGUMENTS, "--policies", "farthest", "--out", str(tmp_path / "file" / "x")]) == 4
    assert "Traceback" not in capsys.readouterr().err

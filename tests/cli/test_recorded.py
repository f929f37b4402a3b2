"""From simulated recordings in folders to Table 2, all through the real commands (docs/recording.md)."""

import json
from pathlib import Path

import pytest

from viewgain.cli import main
from viewgain.datasets import Dataset
from viewgain.inference import Scorer

CAMERA = """
extends = "pico_flexx"
name = "small"
[image]
width = 112
height = 86
horizontal_deg = 62.0
vertical_deg = 45.0
"""
SIZES = {"large_one": (0.4, 0.3, 0.2), "large_two": (0.4, 0.3, 0.2), "small_one": (0.3, 0.22, 0.26)}
"""The first two folders are one box, seen by two cameras."""


@pytest.fixture
def recordings(tmp_path: Path) -> Path:
    """Four scans of each from the four positions; the last without poses, as from a hand-held camera."""
    (tmp_path / "camera.toml").write_text(CAMERA)
    folder = tmp_path / "recordings"
    for seed, (name, size) in enumerate(SIZES.items()):
        rest = ["--camera", str(tmp_path / "camera.toml"), "--rig", "recorded4", "--captures", "4", "--formats", "png"]
        dims = ["--dims", *map(str, size), "--seed", str(seed), "--by-station", "--out", str(folder / name)]
        assert main(["simulate", *rest, *dims]) == 0
    for file in (folder / "small_one").glob("*/*.json"):
        file.write_text(json.dumps({key: value for key, value in json.loads(file.read_text()).items() if "world" not in key}))
    (folder / "boxes.toml").write_text("".join(f"{name} = {list(size)}\n" for name, size in SIZES.items()))
    return folder


@pytest.mark.slow
def test_from_a_folder_to_table_2(recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data, run, model = tmp_path / "data", tmp_path / "run", tmp_path / "recorded.onnx"
    built = ["dataset", "build", "boxes_recorded_paper", "--recordings", str(recordings), "--out", str(data)]
    assert main([*built, "--errors", "lines_published"]) == 0
    assert "48 samples of 3 objects" in capsys.readouterr().out
    views = [[int(sample.view) for sample in Dataset(data) if sample.object == box] for box in range(3)]
    assert views == [[0] * 4 + [1] * 4 + [2] * 4 + [3] * 4] * 3
    assert main(["train", "volume_recorded_short", "--data", str(data), "--out", str(run), "--minutes", "0.05"]) == 0
    assert json.loads((run / "run.json").read_text())["facts"]["training"]["objects"] == 3
    assert main(["export", str(run), "--out", str(model)]) == 0
    assert not any("simulated" in limit for limit in Scorer.load(model).card.limits)
    capsys.readouterr()
    folds = ["--folds", "2", "--leave", "1", "--recipe", "volume_recorded_short", "--minutes", "0.05"]
    asked = ["--json", "--data", str(data), "--models", str(model), "--out", str(tmp_path / "tables")]
    assert main(["evaluate", "table2", *asked, *folds]) == 0
    table, across = map(json.loads, capsys.readouterr().out.splitlines())
    assert (table["same_boxes"], table["other_boxes"]) == ([0, 1, 2], [])
    rows = {row["name"]: row for row in table["rows"]}
    assert 0 <= rows["recorded"]["same"]["mean"][0] <= 1
    assert rows["uniform guess"]["same"]["mean"] == [0.25]
    assert all(row["other"] is None for row in table["rows"])
    assert sorted(each["other_boxes"] for each in across["folds"]) == [[0, 1], [2]]


def test_without_recordings_the_recipe_asks_for_data(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["train", "volume_recorded_short", "--out", str(tmp_path / "run")]) == 2
    assert "name a data set with --data" in capsys.readouterr().err

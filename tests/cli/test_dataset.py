"""``viewgain dataset`` as a user types it: every shipped recipe in its tiny form, and your own recordings."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from viewgain.cli import main
from viewgain.datasets import RECIPES, Dataset

TINY = [name for name in RECIPES if name.endswith("_tiny") and "recorded" not in name]


@pytest.mark.parametrize("name", TINY)
def test_every_recipe_builds_in_its_tiny_form(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dataset", "build", name, "--out", str(tmp_path / "out")]) == 0
    objects = 12 if name == "coverage_learn_tiny" else 6 if name.startswith("volume") else 2  # those are to learn from
    assert f"samples of {objects} objects" in capsys.readouterr().out
    data = Dataset(tmp_path / "out")
    assert len(data) > 0
    assert data.manifest.recipe["name"] == name
    assert main(["dataset", "verify", str(tmp_path / "out")]) == 0


@pytest.fixture
def recordings(tmp_path: Path, scans: Path) -> Path:
    """Two boxes from two positions with a scan or two each, in several formats, and one file that is no scan."""
    folder = tmp_path / "recordings"
    for box in ("big", "small"):
        for position, names in (("a", ["one.ply", "two.ply"]), ("b", ["two.png", "two.json"])):
            (folder / box / position).mkdir(parents=True)
            for name in names:
                shutil.copy(scans / name, folder / box / position / name)
    (folder / "small" / "a" / "broken.ply").write_text("ply\nbroken")
    (folder / "boxes.toml").write_text("big = [0.4, 0.3, 0.2]\n")
    return folder


def test_own_recordings_become_samples(recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["dataset", "build", "boxes_recorded_tiny", "--recordings", str(recordings), "--out", str(tmp_path / "out")]
    assert main([*command, "--errors", "default"]) == 0
    printed = capsys.readouterr().out
    assert "6 samples of 2 objects" in printed
    assert "1 skipped" in printed
    data = Dataset(tmp_path / "out")
    assert data.manifest.skipped[0].name == "small/a/broken.ply"
    errors = data.volume_errors("default")
    for index, sample in enumerate(data):
        assert (sample.camera, sample.frame, len(sample.points)) == ("recorded", "camera", 1024)
        if data.manifest.objects[sample.object].startswith("big"):
            np.testing.assert_allclose(sample.dims, [0.4, 0.3, 0.2], rtol=1e-6)
            assert abs(errors[index]) < 0.1
        else:
            assert np.isnan(sample.dims).all()
            assert np.isnan(errors[index])
    # The positions stand where their first scans stood: a's first scan sees position a where itself is.
    first = next(sample for sample in data if (sample.object, sample.view, sample.capture) == (0, 0, 0))
    np.testing.assert_allclose(first.candidates[0], np.eye(4), atol=1e-6)
    assert not np.allclose(first.candidates[1], np.eye(4), atol=0.1)
    assert {name: set(data.column("object")[data.part("other_box", name)]) for name in ("train", "test")} == {
        "train": {0}, "test": {1}
    }  # fmt: skip


def test_recordings_without_poses_have_no_candidate_poses(recordings: Path, scans: Path, tmp_path: Path) -> None:
    shutil.copy(scans / "one_unposed.ply", recordings / "small" / "b" / "aaa.ply")
    command = ["dataset", "build", "boxes_recorded_tiny", "--recordings", str(recordings), "--out", str(tmp_path / "out")]
    assert main(command) == 0
    for sample in Dataset(tmp_path / "out"):
        assert bool(np.isnan(sample.candidates).all()) == (sample.object == 1)


def test_recipes_are_listed_with_what_they_make(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dataset", "recipes"]) == 0
    printed = capsys.readouterr().out
    for name in RECIPES:
        assert name in printed
    assert "44,000" in printed


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ("build boxes_papr --out OUT", "boxes_paper_tiny"),
        ("build boxes_paper_tiny --out OUT --workers 0", "0 workers"),
        ("build boxes_paper_tiny --out OUT --ray-address auto", "--engine ray"),
        ("build boxes_paper_tiny --out OUT --seed -1", "seed"),
        ("build boxes_recorded_tiny --out OUT", "--recordings"),
        ("build boxes_recorded_tiny --recordings nowhere --out OUT", "nowhere"),
        ("build coverage_paper_tiny --meshes nowhere --out OUT", "nowhere"),
        ("build boxes_paper_tiny --out OUT --errors magic", "magic"),
        ("build coverage_paper_tiny --out OUT --errors default", "has none"),
        ("info OUT", "no data set"),
        ("verify OUT", "no data set"),
        ("export-hf OUT --out there", "no data set"),
    ],
)
def test_wrong_input_ends_in_one_line_and_exit_code_2(
    wrong: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["dataset", *wrong.replace("OUT", str(tmp_path / "out")).split()]) == 2
    printed = capsys.readouterr()
    assert says in printed.err
    assert len(printed.err.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()

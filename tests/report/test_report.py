"""Writing a report: which files appear, that they are whole, that they come out the same again, and what is said if not."""

import io
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from viewgain.episodes import Episode
from viewgain.errors import ConfigError, MissingExtraError, StorageError
from viewgain.measure import measure
from viewgain.report import draw_scan, draw_scene, save_scan_picture, write_report
from viewgain.scans import Scan


@pytest.fixture(scope="module")
def folder(episode: Episode, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_report(episode, tmp_path_factory.mktemp("run") / "new" / "report").parent


def picture(content: bytes) -> np.ndarray:
    image = Image.open(io.BytesIO(content))
    assert image.format == "PNG"
    return np.asarray(image.convert("RGB"))


def assert_one_line(error: BaseException) -> None:
    assert "\n" not in str(error)


def test_a_report_has_two_pictures_per_view_one_of_all_the_numbers_and_the_page(folder: Path) -> None:
    views = {f"view{number}_{kind}.png" for number in (1, 2) for kind in ("range", "scene")}
    assert {path.name for path in folder.iterdir()} == views | {"dimensions.png", "numbers.json", "index.html"}


def test_it_returns_the_page(blob: Episode, tmp_path: Path) -> None:
    assert write_report(blob, tmp_path) == tmp_path / "index.html"


def test_pictures_decode_and_are_large_enough_to_read(folder: Path) -> None:
    for path in folder.glob("*.png"):
        pixels = picture(path.read_bytes())
        assert min(pixels.shape[:2]) > 400
        assert pixels.std() > 10


def test_the_numbers_are_those_of_the_episode(folder: Path, episode: Episode) -> None:
    content = json.loads((folder / "numbers.json").read_text())
    assert len(content["steps"]) == len(episode.steps)
    for written, step in zip(content["steps"], episode.steps, strict=True):
        assert written["single"] == step.single.to_dict()
        assert written["fused"] == step.fused.to_dict()
        assert written["next"] == step.plan.to_dict()
    np.testing.assert_allclose(content["truth"]["dimensions_m"], np.sort(episode.world.box.extents)[::-1], atol=1e-6)
    np.testing.assert_allclose(content["volume_errors"], episode.errors, atol=1e-6)


def test_errors_are_those_of_each_dimension_against_the_side_it_runs_along(folder: Path, episode: Episode) -> None:
    against = json.loads((folder / "numbers.json").read_text())["steps"][0]["against_truth"]
    estimate = episode.steps[0].fused.boxes[0]
    assert against["true_dimensions_m"] == pytest.approx([0.45, 0.30, 0.25])
    np.testing.assert_allclose(against["relative_errors"], estimate.dimensions / [0.45, 0.30, 0.25] - 1, atol=1e-6)
    assert abs(against["relative_volume_error"]) == pytest.approx(episode.errors[0], abs=1e-6)


def test_the_same_episode_gives_the_same_bytes(folder: Path, episode: Episode, tmp_path: Path) -> None:
    write_report(episode, tmp_path)
    for path in folder.iterdir():
        assert (tmp_path / path.name).read_bytes() == path.read_bytes(), path.name


@pytest.mark.parametrize("name", ["blob", "empty"])
def test_an_episode_that_measures_nothing_is_reported_too(name: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    played: Episode = request.getfixturevalue(name)
    page = write_report(played, tmp_path).read_text()
    assert "No box measured in 1 view" in page
    content = json.loads((tmp_path / "numbers.json").read_text())
    assert content["steps"][0]["against_truth"] is None
    assert content["volume_errors"] == [1.0]


def test_older_files_are_replaced_and_nothing_temporary_stays(blob: Episode, tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text("old")
    (tmp_path / "mine.txt").write_text("mine")
    write_report(blob, tmp_path)
    assert (tmp_path / "index.html").read_text().startswith("<!DOCTYPE html>")
    assert (tmp_path / "mine.txt").read_text() == "mine"
    assert not list(tmp_path.glob(".*"))


def test_a_folder_that_cannot_be_made_is_one_line(blob: Episode, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "report"):
        with pytest.raises(StorageError, match="cannot be written") as caught:
            write_report(blob, folder)
        assert str(folder) in str(caught.value)
        assert_one_line(caught.value)


def test_a_file_that_cannot_be_written_is_one_line_and_leaves_nothing_behind(blob: Episode, tmp_path: Path) -> None:
    (tmp_path / "numbers.json").mkdir()
    with pytest.raises(StorageError, match=r"numbers\.json.*cannot be written") as caught:
        write_report(blob, tmp_path)
    assert_one_line(caught.value)
    assert not list(tmp_path.glob(".*"))


@pytest.mark.parametrize("missing", ["matplotlib", "jinja2"])
def test_a_missing_extra_is_named_in_one_line(
    missing: str, blob: Episode, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, missing, None)
    step = blob.steps[0]
    calls = (
        lambda: write_report(blob, tmp_path / "report"),
        lambda: save_scan_picture(step.scan, step.fused, tmp_path / "scan.png"),
        lambda: draw_scan(step.scan, step.fused),
        lambda: draw_scene(step.scan, step.fused),
    )
    for call in calls:
        with pytest.raises(MissingExtraError) as caught:
            call()
        assert str(caught.value) == 'the report needs matplotlib and jinja2: pip install "viewgain[report]"'
    assert not list(tmp_path.iterdir())


def test_importing_the_room_loads_no_drawing_library_and_drawing_no_pyplot() -> None:
    code = (
        "import sys, numpy as np\n"
        "import viewgain.report\n"
        "assert not {'matplotlib', 'jinja2'} & set(sys.modules)\n"
        "from viewgain import Measurement, Scan\n"
        "rays = np.dstack([*np.meshgrid(np.linspace(-.4, .4, 20), np.linspace(-.3, .3, 15)), np.ones((15, 20))])\n"
        "viewgain.report.draw_scan(Scan.from_array(rays), Measurement((), None, (), 'no_floor')).savefig(sys.argv[1])\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-c", code, "/dev/null"], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr


def test_the_picture_of_one_scan_has_the_cameras_beside_it_after_planning(episode: Episode, tmp_path: Path) -> None:
    step = episode.steps[1]
    alone = picture(save_scan_picture(step.scan, step.fused, tmp_path / "alone.png").read_bytes())
    both = picture(save_scan_picture(step.scan, step.fused, tmp_path / "both.png", step.plan).read_bytes())
    assert both.shape[1] > 1.8 * alone.shape[1]
    np.testing.assert_array_equal(both[: alone.shape[0], : alone.shape[1]], alone)


def test_a_plan_without_candidates_adds_nothing(empty: Episode, tmp_path: Path) -> None:
    step = empty.steps[0]
    alone = save_scan_picture(step.scan, step.fused, tmp_path / "alone.png").read_bytes()
    assert save_scan_picture(step.scan, step.fused, tmp_path / "both.png", step.plan).read_bytes() == alone


def test_an_unorganised_cloud_without_pose_is_drawn(episode: Episode, tmp_path: Path) -> None:
    cloud = Scan.from_array(episode.steps[1].scan.points, source="cloud")
    measured = measure(cloud)
    assert measured.boxes
    picture(save_scan_picture(cloud, measured, tmp_path / "cloud.png").read_bytes())
    assert draw_scene(cloud, measured).axes


def test_a_scan_without_a_floor_is_drawn(tmp_path: Path) -> None:
    lump = Scan.from_array(np.random.default_rng(0).normal([0, 0, 1.0], 0.05, (300, 3)))
    measured = replace(measure(lump), floor=None, boxes=(), rejected=(), reason="no_floor")
    picture(save_scan_picture(lump, measured, tmp_path / "lump.png").read_bytes())
    assert draw_scene(lump, measured).axes


def test_only_png_files_are_drawn(blob: Episode, tmp_path: Path) -> None:
    step = blob.steps[0]
    with pytest.raises(ConfigError, match=r"ends in \.png") as caught:
        save_scan_picture(step.scan, step.fused, tmp_path / "scan.jpeg")
    assert_one_line(caught.value)


def test_a_picture_in_a_missing_folder_is_one_line(blob: Episode, tmp_path: Path) -> None:
    step = blob.steps[0]
    with pytest.raises(StorageError, match="cannot be written") as caught:
        save_scan_picture(step.scan, step.fused, tmp_path / "nowhere" / "scan.png")
    assert_one_line(caught.value)

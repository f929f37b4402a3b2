"""``viewgain calibrate`` as a user runs it: a known box tells this camera's scale and offset, and the file keeps them."""

import json
from pathlib import Path

import numpy as np
import pytest

from viewgain.camera import sensor
from viewgain.cli import main

DIMS = ["--dims", "0.3", "0.4", "0.2"]
SEEDS = (7, 11, 12)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    """The same box by three cameras, each with a scale and offset of its own."""
    folders = {seed: tmp_path_factory.mktemp(f"seed{seed}") for seed in SEEDS}
    command = "simulate --scene box --dims 0.4 0.3 0.2 --rig ring4 --without multipath --systematic --formats npz"
    for seed, folder in folders.items():
        assert main([*command.split(), "--seed", str(seed), "--out", str(folder)]) == 0
    return folders


def views(folder: Path) -> list[str]:
    return [str(path) for path in sorted(folder.glob("view*.npz"))]


def drawn(folder: Path) -> dict[str, float]:
    error: dict[str, float] = json.loads((folder / "truth.json").read_text())["range_error"]
    return error


def calibrated(arguments: list[str], out: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, float]:
    assert main(["calibrate", *arguments, *DIMS, "--out", str(out), "--json"]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    found: dict[str, float] = json.loads(line)
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_the_drawn_error_is_found_within_three_sigmas(
    seed: int, recordings: dict[int, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    found = calibrated([*views(recordings[seed]), "--camera", "pico_flexx"], tmp_path / "camera.toml", capsys)
    truth, before = drawn(recordings[seed]), sensor("pico_flexx")
    assert abs(found["scale"] - truth["scale"]) < 3 * found["scale_sd"]
    assert abs(found["offset_m"] - truth["offset"]) < 3 * found["offset_sd_m"]
    assert found["scale_sd"] < 0.6 * before.scale_sd  # four views at one distance: mostly what scale and offset do together
    assert found["offset_sd_m"] < 0.9 * before.offset_sd


def test_one_of_the_errors_is_too_large_to_be_missed(recordings: dict[int, Path]) -> None:
    """Else an answer of zero would pass the test above."""
    assert abs(drawn(recordings[7])["scale"]) > 0.004


def test_the_file_is_read_back_with_the_same_numbers_and_measures_better(
    recordings: dict[int, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    out = tmp_path / "camera.toml"
    found = calibrated([*views(recordings[7]), "--camera", "pico_flexx"], out, capsys)
    camera = sensor(str(out))
    numbers = [camera.scale, camera.scale_sd, camera.offset, camera.offset_sd]
    assert np.allclose(numbers, [found[key] for key in ("scale", "scale_sd", "offset_m", "offset_sd_m")], atol=1e-6)
    errors, sigmas = [], []
    for name in ("pico_flexx", str(out)):
        assert main(["measure", views(recordings[7])[0], "--camera", name, "--json"]) == 0
        (box,) = json.loads(capsys.readouterr().out)["boxes"]
        errors.append(abs(box["volume_m3"] / 0.024 - 1))
        sigmas.append(box["volume_sigma_m3"])
    assert errors[1] < errors[0]
    assert sigmas[1] < sigmas[0]


def test_calibrating_a_calibrated_camera_starts_from_what_it_knows(
    recordings: dict[int, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    first, second = tmp_path / "first.toml", tmp_path / "second.toml"
    once = calibrated([*views(recordings[7])[:2], "--camera", "pico_flexx"], first, capsys)
    twice = calibrated([*views(recordings[7])[2:], "--camera", str(first)], second, capsys)
    whole = calibrated([*views(recordings[7]), "--camera", "pico_flexx"], tmp_path / "whole.toml", capsys)
    assert twice["scale_sd"] < once["scale_sd"]
    assert abs(twice["scale"] - whole["scale"]) < whole["scale_sd"]  # a correlation of scale and offset is not kept in the file


def test_the_words_give_per_cent_millimetres_and_the_file(
    recordings: dict[int, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    out = tmp_path / "camera.toml"
    assert main(["calibrate", views(recordings[7])[0], *DIMS, "--camera", "pico_flexx", "--out", str(out)]) == 0
    told = capsys.readouterr().out
    assert all(word in told for word in ("scale", " %", "offset", " mm", f"--camera {out}"))
    assert out.read_text().startswith("# pico_flexx, calibrated")


WRONG = [
    (["--dims", "0.7", "0.4", "0.2"], "another box"),
    (["--dims", "400", "300", "200"], "another unit"),
    (["--dims", "0.4", "-0.3", "0.2"], "positive"),
    (["--dims", "0.4", "nan", "0.2"], "positive"),
    ([*DIMS, "--out", "camera.json"], ".toml"),
    ([*DIMS, "--camera", "nikon"], "nikon"),
    ([*DIMS, "--pose", "a.txt", "b.txt"], "2 poses"),
]


@pytest.mark.parametrize(("options", "word"), WRONG)
def test_wrong_input_is_one_line_exit_2_and_no_file(
    options: list[str], word: str, recordings: dict[int, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    out = tmp_path / "camera.toml"
    assert main(["calibrate", views(recordings[7])[0], "--out", str(out), *options]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    (error,) = captured.err.splitlines()
    assert word in error
    assert not out.exists()


def test_a_scan_without_the_box_is_one_line(scans: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["calibrate", str(scans / "floor.npz"), *DIMS, "--out", str(tmp_path / "camera.toml")]) == 2
    (error,) = capsys.readouterr().err.splitlines()
    assert "got no box (nothing_on_floor)" in error
    assert not (tmp_path / "camera.toml").exists()


def test_a_folder_that_cannot_be_written_is_one_line(
    recordings: dict[int, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    (tmp_path / "file").write_text("in the way")
    assert main(["calibrate", views(recordings[7])[0], *DIMS, "--out", str(tmp_path / "file" / "camera.toml")]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1

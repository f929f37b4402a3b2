"""``viewgain measure --shape`` and the parcel rules, as a user runs them."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest

from tests.cli.conftest import EXTENTS
from viewgain.camera import camera_text, sensor
from viewgain.cli import main

TRUTH = np.sort(EXTENTS)[::-1]


@pytest.fixture(scope="module")
def mug(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A scan of something that is no box."""
    folder = tmp_path_factory.mktemp("mug")
    command = "simulate --scene object --category mug --size 0.4 --rig ring2 --without multipath --formats npz --out"
    assert main([*command.split(), str(folder)]) == 0
    return str(folder / "view00_000.npz")


def result_of(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    assert main(["measure", *arguments, "--json"]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    return json.loads(line)


def test_auto_gives_a_box_for_a_box_and_a_reason_for_a_mug(scans: Path, mug: str, capsys: pytest.CaptureFixture[str]) -> None:
    boxed = result_of([str(scans / "one.png"), "--shape", "auto"], capsys)
    plain = result_of([str(scans / "one.png")], capsys)
    (thing,) = boxed["objects"]
    assert (thing["shape"], thing["enclosure"], thing["why_no_box"]) == ("box", None, None)
    assert [thing["box"]] == plain["boxes"]
    (thing,) = result_of([mug, "--shape", "auto"], capsys)["objects"]
    assert (thing["shape"], thing["box"], thing["why_no_box"]) == ("any", None, "not_a_box")


def test_any_encloses_everything_and_tries_no_box(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (thing,) = result_of([str(scans / "one.png"), "--shape", "any"], capsys)["objects"]
    assert (thing["shape"], thing["box"], thing["why_no_box"]) == ("any", None, None)
    for length, truth in zip(thing["enclosure"]["upright"]["dimensions_m"], (0.4, 0.3, 0.2), strict=True):
        low, high = length["interval90"]
        assert low < truth < high


def test_a_cameras_known_scale_is_taken_off_any_shape(mug: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "long.toml").write_text(camera_text(sensor("pico_flexx").corrected(0.05, 0.0, 0.001, 0.001)))
    seen = []
    for camera in ("pico_flexx", str(tmp_path / "long.toml")):
        (thing,) = result_of([mug, "--shape", "any", "--camera", camera], capsys)["objects"]
        found = thing["enclosure"]
        seen.append([np.linalg.norm(found["centre_camera_m"]), found["upright"]["dimensions_m"][2]["seen"]])
    assert np.allclose(np.array(seen[1]) / seen[0], 1 / 1.05, atol=0.01)  # a footprint hangs on single pixels at its rim


def test_the_table_says_what_it_was_and_why_and_the_rules_words(mug: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", mug, "--shape", "auto", "--division", "0.005", "--divisor", "5000"]) == 0
    out = capsys.readouterr().out
    quantities = ("upright length", "free height", "hull volume", "heap volume")
    for word in (*quantities, "90 %", "box likeness", "not_a_box", "does not fit"):
        assert word in out
    assert "dimensional weight" in out
    assert "not a certified measurement" in out
    assert main(["measure", mug, "--shape", "any", "--round-up", "0.01"]) == 0
    out = capsys.readouterr().out
    assert "billed" in out
    assert "certified" not in out  # no division was asked for, so nobody can mistake it for one
    assert "not_a_box" not in out


@pytest.mark.parametrize("options", [[], ["--shape", "auto"]])
def test_rules_bill_a_box_whatever_the_shape_option(options: list[str], scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rules = ["--division", "0.02", "--round-up", "0.05", "--divisor", "5000"]
    result = result_of([str(scans / "one.png"), *options, *rules], capsys)
    (bill,) = [each["billed"] for each in result.get("boxes", result.get("objects"))]
    assert np.allclose(bill["dimensions_m"], [0.4, 0.3, 0.2])
    assert bill["under_12_divisions"] is True
    assert bill["dimensional_weight_kg"] == pytest.approx(0.4 * 0.3 * 0.2 * 1e6 / 5000)


def test_without_rules_boxes_are_not_billed(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "billed" not in result_of([str(scans / "one.png")], capsys)["boxes"][0]


def test_rules_bill_fused_scans_and_lines_too(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    both = [str(scans / "one.ply"), str(scans / "two.ply")]
    assert result_of([*both, "--fuse", "--round-up", "0.05"], capsys)["boxes"][0]["billed"]["volume_m3"] > 0
    assert result_of([both[0], "--method", "corners", "--round-up", "0.1"], capsys)["billed"]["dimensions_m"][0] >= 0.4
    assert main(["measure", both[0], "--method", "corners", "--division", "0.001"]) == 0
    assert "not a certified measurement" in capsys.readouterr().out


def test_csv_of_shapes_has_a_row_per_object_and_full_width(scans: Path, mug: str, capsys: pytest.CaptureFixture[str]) -> None:
    files = [str(scans / "one.png"), mug, str(scans / "floor.npz")]
    assert main(["measure", *files, "--shape", "auto", "--csv", "--division", "0.005"]) == 3
    text = capsys.readouterr().out
    assert len({len(row) for row in csv.reader(io.StringIO(text))}) == 1
    box, thing, nothing = csv.DictReader(io.StringIO(text))
    assert (box["shape"], thing["shape"], nothing["shape"]) == ("box", "any", "")
    assert (thing["why_no_box"], nothing["reason"]) == ("not_a_box", "nothing_on_floor")
    assert np.allclose([float(box[f"{name}_m"]) for name in ("length", "width", "height")], TRUTH, atol=0.006)
    assert box["free_length_m"] == box["hull_volume_m3"] == box["box_likeness"] == ""
    for name in ("volume", "free_volume", "hull_volume", "heap_volume"):
        low, value, high = (float(thing[f"{name}{end}_m3"]) for end in ("_low90", "", "_high90"))
        assert low < value < high
    assert float(box["billed_length_m"]) == pytest.approx(0.4)
    assert box["under_12_divisions"] == "0"
    assert box["dimensional_weight_kg"] == nothing["billed_length_m"] == ""


def test_csv_of_boxes_grows_by_the_billed_columns_only(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [str(scans / "one.png"), str(scans / "floor.npz")]
    assert main(["measure", *files, "--csv"]) == 3
    plain = list(csv.reader(io.StringIO(capsys.readouterr().out)))
    assert main(["measure", *files, "--csv", "--divisor", "6000"]) == 3
    rows = list(csv.reader(io.StringIO(capsys.readouterr().out)))
    assert [row[: len(plain[0])] for row in rows] == plain
    assert [len(row) for row in rows] == [len(plain[0]) + 6] * 3


def test_a_bare_floor_is_said_in_a_sentence(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "floor.npz"), "--shape", "any"]) == 3
    captured = capsys.readouterr()
    assert "nothing stands on the floor" in captured.err
    assert "nothing_on_floor" in captured.out


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ("--division -0.005", "division"),
        ("--division 0", "division"),
        ("--division nan", "division"),
        ("--division 5", "0.005"),
        ("--round-up inf", "round_up"),
        ("--round-up 10", "--round-up"),
        ("--divisor 0", "divisor"),
        ("--divisor nan", "divisor"),
        ("--divisor -5000 --shape any", "divisor"),
        ("--fuse --shape any", "--fuse"),
        ("--shape auto --json --csv", "--csv"),
    ],
)
def test_wrong_rules_and_shapes_are_one_line(options: str, word: str, scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "one.png"), *options.split()]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    (error,) = captured.err.splitlines()
    assert word in error


@pytest.mark.parametrize("options", ["--shape round", "--division five"])
def test_words_that_are_none_are_refused(options: str, scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "one.png"), *options.split()]) == 2
    assert "Traceback" not in capsys.readouterr().err

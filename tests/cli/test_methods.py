"""``viewgain measure --method``: the paper's estimators through the same door, without error bars."""

import csv
import io
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.cli.conftest import EXTENTS
from viewgain.camera import camera_text, sensor
from viewgain.cli import main
from viewgain.measure import measure
from viewgain.planes import AS_PUBLISHED, MENDED, measure_lines
from viewgain.scans import read_scan

LOADED = """
import sys
from viewgain.cli import main
main(sys.argv[1:])
print(*(name for name in sys.modules if name.startswith("viewgain.")))
"""


def test_plain_json_is_the_measurement_and_nothing_more(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plain = json.dumps(measure(read_scan(scans / "one.png")).to_dict()) + "\n"
    for options in ([], ["--method", "likelihood"], ["--shape", "box"], ["--no-as-published", "--no-fuse"]):
        assert main(["measure", str(scans / "one.png"), "--json", *options]) == 0
        assert capsys.readouterr().out == plain


def test_plain_csv_has_the_columns_it_always_had(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "one.png"), "--csv"]) == 0
    assert capsys.readouterr().out.splitlines()[0] == (
        "scan,box,length_m,width_m,height_m,length_sigma_m,width_sigma_m,height_sigma_m,vertical,"
        "volume_m3,volume_sigma_m3,volume_low90_m3,volume_high90_m3,flags,reason"
    )


def test_plain_measuring_loads_neither_planes_nor_parcels(scans: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LOADED, "measure", str(scans / "one.png"), "--json"], capture_output=True, text=True, check=True
    )
    loaded = done.stdout.splitlines()[-1].split()
    assert "viewgain.measure" in loaded
    assert not {"viewgain.planes", "viewgain.parcels"} & set(loaded)


@pytest.mark.parametrize("published", [False, True])
@pytest.mark.parametrize("method", ["lines", "corners"])
def test_json_is_what_the_room_of_planes_returns(
    method: str, published: bool, scans: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = (AS_PUBLISHED if published else MENDED).using(method)
    expected = measure_lines(read_scan(scans / "one.png"), settings).to_dict()
    options = ["--method", method, *(["--as-published"] if published else [])]
    assert main(["measure", str(scans / "one.png"), *options, "--json"]) == (0 if expected["reason"] is None else 3)
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(expected))


def test_the_table_says_none_for_error_bars_and_is_near_the_truth(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "one.png"), "--method", "corners"]) == 0
    out = capsys.readouterr().out
    rows = [line.split("│") for line in out.splitlines() if " mm " in line]
    assert np.allclose([float(row[3].split()[0]) / 1000 for row in rows], np.sort(EXTENTS)[::-1], atol=0.03)
    assert [row[4].strip() for row in rows] == ["none"] * 3
    assert "corners, mended" in out


def test_csv_has_the_same_columns_with_the_unknown_ones_empty(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [str(scans / "one.png"), str(scans / "floor.npz")]
    assert main(["measure", *files, "--method", "lines", "--csv"]) == 3
    measured, refused = csv.DictReader(io.StringIO(capsys.readouterr().out))
    assert main(["measure", *files, "--csv"]) == 3
    assert list(measured) == list(next(csv.DictReader(io.StringIO(capsys.readouterr().out))))
    sides = [float(measured[name]) for name in ("length_m", "width_m", "height_m")]
    assert float(measured["volume_m3"]) == pytest.approx(np.prod(sides), rel=1e-4)
    assert {measured[name] for name in ("length_sigma_m", "volume_sigma_m3", "volume_low90_m3", "vertical", "reason")} == {""}
    assert refused["reason"]
    assert refused["volume_m3"] == ""


def test_nothing_measurable_is_said_in_a_sentence(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "floor.npz"), "--method", "lines"]) == 3
    captured = capsys.readouterr()
    assert "planes" in captured.err.splitlines()[-1] or "edges" in captured.err.splitlines()[-1]
    assert "none" in captured.out


def test_a_cameras_known_scale_is_taken_off(scans: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A scale of all ranges about the camera scales a box seen from it, up to the method's own bands in metres."""
    (tmp_path / "long.toml").write_text(camera_text(sensor("pico_flexx").corrected(0.02, 0.0, 0.001, 0.001)))
    volumes = []
    for camera in ("pico_flexx", str(tmp_path / "long.toml")):
        assert main(["measure", str(scans / "one.png"), "--method", "corners", "--camera", camera, "--json"]) == 0
        volumes.append(json.loads(capsys.readouterr().out)["volume_m3"])
    assert volumes[1] / volumes[0] == pytest.approx(1.02**-3, abs=0.03)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ("--as-published", "--as-published"),
        ("--method lines --fuse", "--fuse"),
        ("--method corners --shape any", "--shape any"),
        ("--method lines --floor floor.npz", "--floor"),
        ("--method lines --camera nikon", "nikon"),
        ("--method lines --json --csv", "--csv"),
    ],
)
def test_options_that_do_not_go_together_are_one_line(
    options: str, word: str, scans: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["measure", str(scans / "one.png"), *options.replace("floor.npz", str(scans / "floor.npz")).split()]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    (error,) = captured.err.splitlines()
    assert word in error


def test_an_unknown_method_is_refused_with_the_known_ones(scans: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["measure", str(scans / "one.png"), "--method", "planes"]) == 2
    assert "corners" in capsys.readouterr().err

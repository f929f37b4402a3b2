"""``viewgain demo`` writes its report and tells the same story twice."""

import json
from pathlib import Path

import pytest

from viewgain.cli import main


@pytest.mark.slow
def test_the_demo_closes_the_loop_and_leaves_a_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "--out", str(tmp_path / "a")]) == 0
    told = capsys.readouterr().out
    assert "Stop:" in told
    assert (tmp_path / "a" / "index.html").stat().st_size > 10_000
    assert list((tmp_path / "a").glob("*.png"))
    numbers = json.loads((tmp_path / "a" / "numbers.json").read_text())
    assert main(["demo", "--out", str(tmp_path / "b")]) == 0
    assert json.loads((tmp_path / "b" / "numbers.json").read_text()) == numbers
    assert capsys.readouterr().out.replace(str(tmp_path / "b"), str(tmp_path / "a")) == told


def test_an_unknown_camera_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "--out", str(tmp_path), "--camera", "nikon"]) == 2
    assert "pico_flexx" in capsys.readouterr().err

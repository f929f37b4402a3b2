"""What ``make`` runs, with a stand-in for the program: nothing is installed and nothing trains."""

import os
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
STAND_IN = """#!/bin/sh
echo "$@" >> calls
case "$1" in simulate)
    while test $# -gt 1; do shift; done
    mkdir -p "$1" && touch "$1/truth.json";;
train)
    case "$2" in --resume) run=$3;; *) run=$6;; esac
    mkdir -p "$run" && touch "$run/run.json"
    test ! -e interrupt || exit 130
esac
"""
RECIPES = ("volume_paper_short", "volume_paper_tally")


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A folder in which everything is installed, as far as make can tell."""
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        shutil.copyfile(ROOT / name, tmp_path / name)
        os.utime(tmp_path / name, (0, 0))
    program = tmp_path / ".venv" / "bin" / "viewgain"
    program.parent.mkdir(parents=True)
    program.write_text(STAND_IN)
    program.chmod(0o755)
    for at, name in enumerate(("venv", "demo", "dev"), start=1):
        stamp = tmp_path / ".venv" / f"{name}.stamp"
        stamp.touch()
        os.utime(stamp, (at, at))
    return tmp_path


def made(checkout: Path, target: str = "table2") -> tuple[int, list[str]]:
    """Return the exit code of make, and the trainings it asked for since the last time."""
    (checkout / "calls").write_text("")
    code = subprocess.run(["make", target], cwd=checkout, capture_output=True, timeout=60, check=False).returncode
    return code, [line for line in (checkout / "calls").read_text().splitlines() if line.startswith("train")]


@pytest.mark.skipif(shutil.which("make") is None, reason="needs make")
def test_table2_goes_on_with_an_interrupted_run_and_skips_a_finished_one(checkout: Path) -> None:
    rest = "--data data/boxes --minutes 30"
    fresh = [f"train {name} --data data/boxes --out runs/{name} --minutes 30" for name in RECIPES]
    (checkout / "interrupt").touch()
    code, trained = made(checkout)
    assert code != 0
    assert trained == fresh[:1]
    code, trained = made(checkout)
    assert code != 0
    assert trained == [f"train --resume runs/{RECIPES[0]} {rest}"]
    (checkout / "interrupt").unlink()
    assert made(checkout) == (0, [f"train --resume runs/{RECIPES[0]} {rest}", fresh[1]])
    assert made(checkout) == (0, [])
    assert (checkout / "calls").read_text().count("evaluate table2") == 2


@pytest.mark.skipif(shutil.which("make") is None, reason="needs make")
def test_table2_terms_trains_and_judges_each_labelling_by_itself(checkout: Path) -> None:
    terms = ("", "+incidence", "+border", "+incidence+border")
    rest, target = "--data data/tenth --minutes 30", "histogram:lines_published:soft"
    begun = "train volume_paper_short --data data/tenth --out runs/terms"
    fresh = [f"{begun}{each} --minutes 30 --target {target}{each} --iterations 1200" for each in terms]
    (checkout / "interrupt").touch()
    code, trained = made(checkout, "table2-terms")
    assert code != 0
    assert trained == fresh[:1]
    (checkout / "interrupt").unlink()
    assert made(checkout, "table2-terms") == (0, [f"train --resume runs/terms {rest}", *fresh[1:]])
    calls = (checkout / "calls").read_text().splitlines()
    judged = [call.split() for call in calls if call.startswith("evaluate table2")]
    for each, call in zip(terms, judged, strict=True):
        assert call[call.index("--models") + 1] == f"runs/terms{each}.onnx"
        assert call[call.index("--target") + 1] == f"{target}{each}"
    assert len({call[call.index("--out") + 1] for call in judged}) == 4
    assert sum(call.startswith("evaluate labels") for call in calls) == 1
    assert made(checkout, "table2-terms") == (0, [])


@pytest.mark.skipif(shutil.which("make") is None, reason="needs make")
def test_table2_recorded_simulates_each_box_by_both_cameras_once(checkout: Path) -> None:
    for again in (False, True):
        subprocess.run(["make", "table2-recorded"], cwd=checkout, capture_output=True, timeout=60, check=True)
        calls = [line.split() for line in (checkout / "calls").read_text().splitlines()]
        simulated = [call for call in calls if call[0] == "simulate"]
        assert len(simulated) == len({call[call.index("--seed") + 1] for call in simulated}) == 6
        assert [call[0] for call in calls].count("evaluate") == 1 + again
    folder = checkout / "data" / "recordings-simulated"
    sizes = tomllib.loads((folder / "boxes.toml").read_text())
    assert set(sizes) == {each.name for each in folder.iterdir() if each.is_dir()}
    for call in simulated:
        assert sizes[Path(call[-1]).name] == [float(side) for side in call[2:5]]

"""Benchmarks that look into a run: what they print of one that was trained here."""

import argparse
import re

import pytest

from benchmarks import present_view, rounding, run_episodes
from tests.training.conftest import changed
from viewgain.datasets import Dataset
from viewgain.training import start

PERCENT = r"(-?\d+\.\d)%"


@pytest.fixture(scope="module")
def options(data: Dataset, tmp_path_factory: pytest.TempPathFactory) -> argparse.Namespace:
    folder = tmp_path_factory.mktemp("runs") / "quick"
    start(changed(), folder, data=data.folder)
    return argparse.Namespace(runs=[folder], data=[data.folder], workers=1)


def test_episodes_of_a_run_stand_beside_those_of_shipped_networks(
    options: argparse.Namespace, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_episodes, "STEPS", 2)
    run_episodes.run(options)
    said = capsys.readouterr().out
    rows = {line.split("|")[1].strip(): line for line in said.splitlines() if line.startswith("| ")}
    assert {"quick", "shipped compact-pcnbv16-object", "shipped compact_view-pcnbv16-object"} <= set(rows)
    closed = {name: float(found[1]) for name, line in rows.items() if (found := re.search(PERCENT, line))}
    assert closed["random"] == 0.0
    assert closed["oracle"] == 100.0
    assert max(closed.values()) == 100.0
    assert "validation objects of the run quick" in said
    assert len(re.findall(r"0\.\d{3}", rows["oracle"].split("|")[-2])) == run_episodes.STEPS


def test_without_a_run_it_says_what_it_wants(capsys: pytest.CaptureFixture[str]) -> None:
    run_episodes.run(argparse.Namespace(runs=[], data=None, workers=1))
    assert "--runs" in capsys.readouterr().out


def test_rounding_is_told_with_its_interval(options: argparse.Namespace, capsys: pytest.CaptureFixture[str]) -> None:
    rounding.run(options)
    row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("| quick"))
    before, after, cost = (float(each) for each in re.findall(r"(-?\d+\.\d+) ?%", row)[:3])
    assert cost == pytest.approx(before - after, abs=0.11)


def test_who_names_the_present_view_stands_beside_chance(
    options: argparse.Namespace, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(present_view, "_kinds", lambda: {"seen": ("car",)})
    present_view.run(argparse.Namespace(runs=options.runs, scenes=1))
    rows = [line.split("|")[1:3] for line in capsys.readouterr().out.splitlines() if line.startswith("|") and "%" in line]
    right = {name.strip(): float(share.split()[0]) for name, share in rows}
    assert right["by chance"] == 6.25
    assert right["least standard deviation"] > 50 > right["guess of quick"], (
        "the one needs no learning, the other had twelve steps"
    )

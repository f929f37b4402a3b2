"""Decisions that take long are kept: for this very program, merged with those of other policies, and never half read."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from viewgain.errors import DataError
from viewgain.evaluation._choice import Choice
from viewgain.evaluation._volume_case import VolumeSettings
from viewgain.evaluation._volume_decided import Decided, decided_text, decisions_file, kept_decisions, program
from viewgain.evaluation._volume_runs import VolumeRun, run_boxes

SETTINGS = VolumeSettings(seed=5, captures=2, estimator="lines_published", side=(0.2, 0.5))
MADE = {"rehearsed": Decided(Choice(2, True, 0.125), 12345.5), "rehearsed_around": Decided(Choice(0, False), 7.0)}


def write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)


def test_what_is_kept_comes_back_but_for_another_program(tmp_path: Path) -> None:
    file = decisions_file(tmp_path, 12)
    assert file.name == "box00012.json"
    assert kept_decisions(file, SETTINGS) == {}
    write(file, decided_text(MADE))
    assert kept_decisions(file, SETTINGS) == MADE
    content = json.loads(file.read_text())
    assert content["program"] == program()
    write(file, json.dumps({**content, "program": "another"}))
    assert kept_decisions(file, SETTINGS) == {}


@pytest.mark.parametrize(
    "text",
    ["{", "[]", '{"decisions": {}}', '{"program": "P", "decisions": {"rehearsed": {"choice": {}, "milliseconds": 1}}}']
    + [
        decided_text({"rehearsed": Decided(replace(MADE["rehearsed"].choice, position=place), 1.0)}) for place in (-1, 4)
    ],  # of a rig of four
)
def test_what_makes_no_sense_is_refused(text: str, tmp_path: Path) -> None:
    file = decisions_file(tmp_path, 0)
    write(file, text.replace('"P"', f'"{program()}"'))
    with pytest.raises(DataError, match="is damaged; remove it"):
        kept_decisions(file, SETTINGS)


@pytest.mark.slow
def test_nobody_rehearses_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The kept choice is taken even where it is not what a rehearsal would say; a policy that was not asked before is added."""
    monkeypatch.setattr("viewgain.plan._rehearsed.MOST", 4)

    def run(*policies: str) -> VolumeRun:
        return run_boxes(SETTINGS, 1, policies, folder=tmp_path)[0]

    first = run("farthest", "rehearsed")
    file = decisions_file(tmp_path, 0)
    kept = kept_decisions(file, SETTINGS)
    assert kept == {"rehearsed": Decided(first.choices["rehearsed"], first.milliseconds["rehearsed"])}

    other = replace(first.choices["rehearsed"], position=(first.choices["rehearsed"].position + 1) % 4)
    write(file, decided_text({"rehearsed": Decided(other, 3.0)}))
    again = run("rehearsed", "farthest")
    assert list(again.choices) == ["rehearsed", "farthest"]
    assert (again.choices["rehearsed"], again.milliseconds["rehearsed"]) == (other, 3.0)
    assert again.choices["farthest"] == first.choices["farthest"]

    run("rehearsed_around")
    after = kept_decisions(file, SETTINGS)
    assert after["rehearsed"].choice == other
    assert set(after) == {"rehearsed", "rehearsed_around"}
    untouched = file.stat().st_mtime_ns
    run("rehearsed_around", "rehearsed")
    assert file.stat().st_mtime_ns == untouched


def test_quick_decisions_are_not_kept(tmp_path: Path) -> None:
    run_boxes(SETTINGS, 1, ("farthest",), folder=tmp_path)
    assert not decisions_file(tmp_path, 0).parent.exists()


def test_every_file_of_the_package_makes_another_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "plan").mkdir()
    for name in ("__init__.py", "plan/error_model.json"):
        (tmp_path / name).write_text("1")
    monkeypatch.setattr("viewgain.__file__", str(tmp_path / "__init__.py"))
    found = set()
    for name, text in (("__init__.py", "1"), ("__init__.py", "2"), ("plan/error_model.json", "2"), ("plan/camera.toml", "2")):
        (tmp_path / name).write_text(text)
        program.cache_clear()
        found.add(program())
    program.cache_clear()
    assert len(found) == 4

"""Decisions that take long are kept: for this very program, merged with those of other policies, and never half read."""

import hashlib
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from tests.oracles.networks_on_disk import exported
from viewgain.errors import DataError
from viewgain.evaluation._choice import Choice
from viewgain.evaluation._volume_case import VolumeSettings
from viewgain.evaluation._volume_decided import Decided, Decisions, decided_text, decisions_file, fingerprint_of, kept_decisions
from viewgain.evaluation._volume_runs import VolumeRun, run_boxes
from viewgain.network import NetworkSettings

SETTINGS = VolumeSettings(seed=5, captures=2, estimator="lines_published", side=(0.7, 0.9))
"""Of its first box nothing can be measured, so that whoever rehearses is quickly done."""
NOW = fingerprint_of(SETTINGS)
MADE = {"rehearsed": Decided(Choice(2, True, 0.125), 12345.5), "rehearsed_around": Decided(Choice(0, False), 7.0)}


@pytest.fixture(scope="module")
def errors(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of results that has the errors of the first box, and no decisions."""
    folder = tmp_path_factory.mktemp("errors")
    run_boxes(SETTINGS, 1, ("farthest",), folder=folder)
    return folder


@pytest.fixture
def folder(errors: Path, tmp_path: Path) -> Path:
    return shutil.copytree(errors, tmp_path / "results")


def write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)


def kept(file: Path, fingerprint: str = NOW) -> dict[str, Decided]:
    return kept_decisions(file, SETTINGS, fingerprint)


def test_what_is_kept_comes_back_but_for_another_question_or_program(tmp_path: Path) -> None:
    file = decisions_file(tmp_path, 12)
    assert file.name == "box00012.json"
    assert kept(file) == {}
    write(file, decided_text(MADE, NOW))
    assert kept(file) == MADE
    assert kept(file, "another") == {}


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "[]",
        '{"decisions": {}}',
        '{"made_under": "NOW", "decisions": {"rehearsed": {"choice": {}, "milliseconds": 1}}}',
        decided_text(MADE, "NOW").replace('"position": 2', '"position": -1'),
        decided_text(MADE, "NOW").replace('"position": 2', '"position": 4'),  # of a rig of four
        decided_text(MADE, "NOW").replace('"position": 2', '"position": Infinity'),
    ],
)
def test_what_makes_no_sense_is_refused(text: str, tmp_path: Path) -> None:
    file = decisions_file(tmp_path, 0)
    write(file, text)
    with pytest.raises(DataError, match="is damaged; remove it"):
        kept(file, "NOW")


def test_nobody_rehearses_twice(folder: Path) -> None:
    """The kept choice is taken even where it is not what a rehearsal would say; a policy that was not asked before is added."""

    def run(*policies: str) -> VolumeRun:
        return run_boxes(SETTINGS, 1, policies, folder=folder)[0]

    first = run("farthest", "rehearsed")
    file = decisions_file(folder, 0)
    assert kept(file) == {"rehearsed": Decided(first.choices["rehearsed"], first.milliseconds["rehearsed"])}

    other = replace(first.choices["rehearsed"], position=(first.choices["rehearsed"].position + 1) % 4)
    write(file, decided_text({"rehearsed": Decided(other, 3.0)}, NOW))
    again = run("rehearsed", "farthest")
    assert list(again.choices) == ["rehearsed", "farthest"]
    assert (again.choices["rehearsed"], again.milliseconds["rehearsed"]) == (other, 3.0)
    assert again.choices["farthest"] == first.choices["farthest"]

    run("rehearsed_around")
    after = kept(file)
    assert after["rehearsed"].choice == other
    assert set(after) == {"rehearsed", "rehearsed_around"}
    untouched = file.stat().st_mtime_ns
    run("rehearsed_around", "rehearsed")
    assert file.stat().st_mtime_ns == untouched


def test_with_a_network_a_decision_is_kept_for_what_is_in_its_file(folder: Path, tmp_path: Path) -> None:
    """Not for the file's name: another network under the same name decides for itself, the same one under another does not."""
    settings = NetworkSettings(kind="pose_scores", views=5, points=64, neighbours=8, width=8, centres=(16, 8))
    files = {name: tmp_path / f"{name}.onnx" for name in ("one", "two")}
    for seed, each in enumerate(files.values()):
        exported(each, settings, seed=seed, rig="irregular", normalisation="metres", frame="camera")

    def run(name: str, **files: Path) -> VolumeRun:
        return run_boxes(SETTINGS, 1, [f"{name}:{file}" for file in files.values()], folder=folder)[0]

    first = run("rehearsed", **files)
    file = decisions_file(folder, 0)
    keys = [f"rehearsed:{hashlib.sha256(each.read_bytes()).hexdigest()}" for each in files.values()]
    assert list(kept(file)) == keys
    assert [each.milliseconds for each in kept(file).values()] == list(first.milliseconds.values())
    copy = Path(shutil.copy(files["one"], tmp_path / "copy.onnx"))
    assert run("rehearsed", copy=copy).milliseconds == {f"rehearsed:{copy}": first.milliseconds[f"rehearsed:{files['one']}"]}
    copy.write_bytes(files["two"].read_bytes())
    assert run("rehearsed", copy=copy).milliseconds == {f"rehearsed:{copy}": first.milliseconds[f"rehearsed:{files['two']}"]}
    run("rehearsed_around", copy=copy)
    assert list(kept(file)) == [*keys, f"rehearsed_around:{keys[1].partition(':')[2]}"]
    exported(copy, settings, seed=7, rig="irregular", normalisation="metres", frame="camera")  # one that has decided nothing yet
    third = run("rehearsed", copy=copy).choices[f"rehearsed:{copy}"]
    assert len(kept(file)) == 4
    assert third == run_boxes(SETTINGS, 1, [f"network:{copy}"])[0].choices[f"network:{copy}"]


def test_a_network_that_was_replaced_meanwhile_keeps_nothing(tmp_path: Path) -> None:
    (tmp_path / "a.onnx").write_bytes(b"one")
    name, made = f"rehearsed:{tmp_path / 'a.onnx'}", MADE["rehearsed"]
    decisions = Decisions.begun(tmp_path, SETTINGS, ("rehearsed", name))
    decisions.keep(0, {"rehearsed": made, name: made})
    assert decisions.known(0) == {"rehearsed": made, name: made}
    (tmp_path / "a.onnx").write_bytes(b"two")
    decisions.keep(1, {"rehearsed": made, name: made})
    assert decisions.known(1) == {"rehearsed": made}


def test_quick_decisions_are_not_kept(errors: Path) -> None:
    assert not decisions_file(errors, 0).parent.exists()


def test_a_program_that_was_changed_meanwhile_keeps_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody could say by which of the two the decision was made."""
    found = iter(["before", "after"])
    monkeypatch.setattr("viewgain.evaluation._volume_decided.fingerprint_of", lambda settings: next(found))
    (run,) = run_boxes(SETTINGS, 1, ("rehearsed",), folder=folder)
    assert "rehearsed" in run.choices
    assert not decisions_file(folder, 0).exists()


def test_two_runs_on_one_folder_keep_both_their_decisions(folder: Path) -> None:
    """While the first is at work the second writes its own."""
    file = decisions_file(folder, 0)

    def meanwhile(done: int, total: int) -> None:
        if done == 0:
            write(file, decided_text({"rehearsed_around": MADE["rehearsed_around"]}, NOW))

    run_boxes(SETTINGS, 1, ("rehearsed",), folder=folder, watch=meanwhile)
    assert set(kept(file)) == {"rehearsed", "rehearsed_around"}
    assert kept(file)["rehearsed_around"] == MADE["rehearsed_around"]


def test_whatever_a_decision_depends_on_makes_another_fingerprint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "plan").mkdir()
    for name in ("__init__.py", "plan/error_model.json"):
        (tmp_path / name).write_text("1")
    monkeypatch.setattr("viewgain.__file__", str(tmp_path / "__init__.py"))
    found = {fingerprint_of(SETTINGS)}
    for name in ("__init__.py", "plan/error_model.json", "plan/camera.toml"):
        (tmp_path / name).write_text("2")
        found.add(fingerprint_of(SETTINGS))
    found |= {fingerprint_of(replace(SETTINGS, **other)) for other in ({"seed": 6}, {"camera": "xtion"}, {"rig": "ring8"})}
    assert len(found) == 7
    (tmp_path / "plan" / "notes.txt").write_text("2")
    assert fingerprint_of(SETTINGS) in found

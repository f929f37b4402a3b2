"""Folders of kept results: one question each, and files in them that make no sense."""

import json
from pathlib import Path

import pytest

from viewgain.errors import DataError, StorageError
from viewgain.evaluation import claim, kept_text

QUESTION = {"seed": 3, "side": (0.1, 0.5)}


def test_the_same_question_goes_on_and_another_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "results"
    claim(folder, QUESTION)
    settings = json.loads((folder / "settings.json").read_text())
    assert settings.pop("viewgain")
    assert settings == {"seed": 3, "side": [0.1, 0.5]}
    (folder / "one.json").write_text("{}")
    before = (folder / "settings.json").read_bytes()
    claim(folder, dict(reversed(QUESTION.items())))
    assert (folder / "settings.json").read_bytes() == before
    for other in ({"seed": 4, "side": (0.1, 0.5)}, {"seed": 3}, {**QUESTION, "more": 1}):
        with pytest.raises(DataError, match="holds results of other settings"):
            claim(folder, other)
    assert (folder / "settings.json").read_bytes() == before


def test_results_of_a_question_that_nobody_knows_are_refused(tmp_path: Path) -> None:
    (tmp_path / "boxes").mkdir()
    (tmp_path / "boxes" / ".one.json.ab.tmp").write_text("cut short")
    (tmp_path / "notes.txt").write_text("no result")
    claim(tmp_path, QUESTION, results=tmp_path / "boxes")
    (tmp_path / "settings.json").unlink()
    (tmp_path / "boxes" / "one.json").write_text("{}")
    with pytest.raises(DataError, match="settings that nobody knows"):
        claim(tmp_path, QUESTION, results=tmp_path / "boxes")
    assert not (tmp_path / "settings.json").exists()


def test_settings_that_cannot_be_read_or_written_are_one_line(tmp_path: Path) -> None:
    (tmp_path / "settings.json").mkdir()
    with pytest.raises(DataError, match="cannot be read"):
        claim(tmp_path, QUESTION)
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match="cannot be made"):
        claim(tmp_path / "file" / "under", QUESTION)
    (tmp_path / "binary").mkdir()
    (tmp_path / "binary" / "settings.json").write_bytes(b"\xff\xfe")
    with pytest.raises(DataError, match="other settings"):
        claim(tmp_path / "binary", QUESTION)


def test_a_kept_file_is_text_or_damaged_and_none_where_there_is_none(tmp_path: Path) -> None:
    assert kept_text(tmp_path / "none.json") is None
    (tmp_path / "right.json").write_text("{}")
    assert kept_text(tmp_path / "right.json") == "{}"
    (tmp_path / "wrong.json").write_bytes(b'{"errors": "\xff"}')
    (tmp_path / "folder.json").mkdir()
    for name in ("wrong.json", "folder.json"):
        with pytest.raises(DataError, match=rf"{name}: is damaged; remove it"):
            kept_text(tmp_path / name)

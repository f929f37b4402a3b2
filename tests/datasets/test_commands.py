"""The commands on data sets that are there: the same bytes for any number of workers, looking, exporting."""

import json
from pathlib import Path

import pytest

from viewgain.cli import main
from viewgain.datasets import Dataset


def files(folder: Path) -> dict[str, bytes]:
    """Return every file but the volume errors of estimators that were not asked for."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["boxes", "coverage"])
def test_two_processes_write_what_none_writes(kind: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    alone: Dataset = request.getfixturevalue(kind)
    command = ["dataset", "build", alone.manifest.recipe["name"], "--out", str(tmp_path), "--workers", "2"]
    assert main([*command, *(["--errors", "lines_mended"] if kind == "boxes" else [])]) == 0
    assert files(tmp_path) == files(alone.folder)
    assert any("errors" in name for name in files(tmp_path)) == (kind == "boxes")


def test_info_says_what_is_there(boxes: Dataset, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dataset", "info", str(boxes.folder), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["samples"], facts["objects"], facts["frame"]) == (24, 2, "camera")
    assert facts["volume_errors"] == {"lines_mended": "16 of 16 shards"}
    assert main(["dataset", "info", str(boxes.folder)]) == 0
    printed = capsys.readouterr().out
    assert "lines_mended: 16 of 16 shards" in printed
    assert "present view first" in printed


def test_export_says_what_it_wrote(coverage: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dataset", "export-hf", str(coverage.folder), "--out", str(tmp_path / "hf")]) == 0
    assert "README.md" in capsys.readouterr().out
    assert main(["dataset", "export-hf", str(coverage.folder), "--out", str(tmp_path / "hf")]) == 2
    (tmp_path / "file").write_text("in the way")
    assert main(["dataset", "export-hf", str(coverage.folder), "--out", str(tmp_path / "file" / "below")]) == 4

"""The exported folder holds what the data set holds."""

import json
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from viewgain.datasets import Dataset, export_hf
from viewgain.datasets import _export as module
from viewgain.errors import DataError, StorageError


def rows_of(folder: Path, part: str) -> list[dict]:
    return [json.loads(line) for line in (folder / "data" / f"{part}.jsonl").read_text().splitlines()]


@pytest.fixture
def without_pyarrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "find_spec", lambda name: None)


@pytest.mark.usefixtures("without_pyarrow")
@pytest.mark.parametrize("kind", ["boxes", "coverage"])
def test_lines_and_points_are_the_samples(kind: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    data: Dataset = request.getfixturevalue(kind)
    assert export_hf(data.folder, tmp_path) == "jsonl"
    seen = []
    for part in ("train", "test"):
        for row in rows_of(tmp_path, part):
            sample = data[row["index"]]
            seen.append(row["index"])
            points = np.load(tmp_path / "data" / row["points_file"], mmap_mode="r")[row["points_start"] : row["points_end"]]
            np.testing.assert_array_equal(points, sample.points)
            np.testing.assert_array_equal(np.float32(row["candidates"]).reshape(-1, 4, 4), sample.candidates)
            assert (row["view"], row["frame"], row["category"]) == (sample.view, sample.frame, sample.category)
            assert row[f"split_{data.manifest.tables.splits[-1]}"] == part
            for name, scores in sample.targets.items():
                np.testing.assert_array_equal(np.float32(row[f"target_{name}"]), scores)
            assert (row["coverage"] is None) == bool(np.isnan(sample.coverage))
    assert sorted(seen) == list(range(len(data)))
    card = (tmp_path / "README.md").read_text()
    assert f"frame **{data.manifest.frame}**" in card
    assert "data/train.jsonl" in card


@pytest.mark.skipif(find_spec("pyarrow") is None, reason="pyarrow is not installed; parquet is written only with it")
def test_parquet_holds_the_samples(tmp_path: Path, coverage: Dataset) -> None:
    import pyarrow.parquet as pq

    assert export_hf(coverage.folder, tmp_path) == "parquet"
    rows = [row for path in sorted((tmp_path / "data").glob("*.parquet")) for row in pq.read_table(path).to_pylist()]
    assert sorted(row["index"] for row in rows) == list(range(len(coverage)))
    for row in rows:
        np.testing.assert_allclose(row["points"], coverage[row["index"]].points)


@pytest.mark.usefixtures("without_pyarrow")
def test_a_folder_that_is_not_empty_or_cannot_be_made_is_refused(tmp_path: Path, boxes: Dataset) -> None:
    (tmp_path / "mine").write_text("mine")
    with pytest.raises(DataError, match="not empty"):
        export_hf(boxes.folder, tmp_path)
    with pytest.raises(DataError, match="not empty"):
        export_hf(boxes.folder, tmp_path / "mine")
    with pytest.raises(StorageError):
        export_hf(boxes.folder, tmp_path / "mine" / "below")
    with pytest.raises(DataError, match="no data set"):
        export_hf(tmp_path, tmp_path / "new")

"""A folder that the Hugging Face tools load: parquet where pyarrow is installed, else JSON lines with the points as .npy files.

Nothing is uploaded, and nothing is read from the network.
"""

import json
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from viewgain.datasets._dataset import Dataset
from viewgain.datasets._files import make_folder, write_whole
from viewgain.datasets._sample import Sample
from viewgain.errors import DataError, StorageError

_ROWS_PER_FILE = 5000
"""Rows of one parquet file."""


def export_hf(folder: Path, out: Path) -> str:
    """Write a data set for others to load; rows are divided into train and test by its last division (the stricter one).

    Args:
        folder: The data set.
        out: Where to; missing or empty.

    Returns:
        ``parquet`` or ``jsonl``: what the rows are written as.

    Raises:
        DataError: If there is no finished data set, or ``out`` is not empty.
        StorageError: If something cannot be written.
    """
    data = Dataset(folder)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise DataError(f"{out}: is not empty; name another folder")
    make_folder(out / "data")
    kind = "parquet" if find_spec("pyarrow") else "jsonl"
    division = data.manifest.tables.splits[-1]
    try:
        for part in data.manifest.tables.parts:
            indices = data.part(division, part).tolist()
            if kind == "parquet":
                _write_parquet(data, indices, out / "data", part)
            else:
                _write_lines(data, indices, out / "data", part)
    except OSError as error:
        if isinstance(error, StorageError):
            raise
        raise StorageError(f"{out}: cannot be written ({error.strerror}); check the folder and its free space") from error
    write_whole(out / "README.md", _card(data, kind, division).encode())
    return kind


def row_of(index: int, sample: Sample) -> dict[str, Any]:
    """Return everything of a sample but its points, as plain values; NaN becomes None."""
    row: dict[str, Any] = {
        "index": index,
        "frame": sample.frame,
        "view": sample.view,
        "step": sample.step,
        "capture": sample.capture,
        "object": sample.object,
        "category": sample.category,
        "camera": sample.camera,
        "noise": sample.noise,
        "coverage": sample.coverage,
        "dims": sample.dims.tolist(),
        "object_to_camera": sample.object_to_camera.reshape(-1).tolist(),
        "candidates": sample.candidates.reshape(-1, 16).tolist(),
        "reachable": sample.reachable.tolist(),
        "state": sample.state.tolist(),
        "seed": list(sample.seed),
    }
    row |= {f"split_{name}": part for name, part in sample.splits.items()}
    row |= {f"target_{name}": scores.tolist() for name, scores in sample.targets.items()}
    return {key: _plain(value) for key, value in row.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, list):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _write_lines(data: Dataset, indices: list[int], folder: Path, part: str) -> None:
    """Write one line per sample; its points are rows [start, end) of the part's .npy file."""
    points = np.concatenate([np.zeros((0, 3), np.float32), *(data[index].points for index in indices)])
    np.save(folder / f"{part}_points.npy", points.astype(np.float32))
    with (folder / f"{part}.jsonl").open("w", encoding="utf-8") as file:
        start = 0
        for index in indices:
            sample = data[index]
            end = start + len(sample.points)
            place = {"points_file": f"{part}_points.npy", "points_start": start, "points_end": end}
            file.write(json.dumps(row_of(index, sample) | place, allow_nan=False) + "\n")
            start = end


def _write_parquet(data: Dataset, indices: list[int], folder: Path, part: str) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    for number, rows in enumerate(_chunks(indices, _ROWS_PER_FILE)):
        samples = [data[index] for index in rows]
        table = [row_of(i, sample) | {"points": sample.points.tolist()} for i, sample in zip(rows, samples, strict=True)]
        pq.write_table(pa.Table.from_pylist(table), folder / f"{part}-{number:05d}.parquet")


def _chunks(indices: list[int], size: int) -> Iterator[list[int]]:
    return (indices[start : start + size] for start in range(0, len(indices), size))


def _card(data: Dataset, kind: str, division: str) -> str:
    manifest = data.manifest
    name = manifest.recipe["name"]
    files = "data/{part}-*.parquet" if kind == "parquet" else "data/{part}.jsonl"
    paths = [f"  - split: {part}\n    path: {files.format(part=part)}" for part in manifest.tables.parts]
    points = "the column `points`" if kind == "parquet" else "rows `points_start` to `points_end` of `points_file`"
    return "\n".join(
        [
            "---",
            f"pretty_name: viewgain {name}",
            "task_categories:\n- robotics",
            "configs:\n- config_name: default\n  data_files:",
            *("  " + path.replace("\n", "\n  ") for path in paths),
            "---",
            f"# {name}",
            "",
            f"{manifest.recipe['makes'][:1].upper()}{manifest.recipe['makes'][1:]}. Built by viewgain {manifest.viewgain}, seed"
            f" {manifest.recipe['seed']}.",
            "",
            f"- {manifest.samples:,} samples of {len(manifest.objects):,} objects, cameras {', '.join(manifest.tables.cameras)}.",
            f"- Points: {points}, metres, frame **{manifest.frame}**.",
            f"- Candidates, state, reachability and targets: {manifest.order}. Poses are (4, 4) row by row, candidate to camera.",
            f"- Targets: {', '.join(manifest.targets) or 'none stored'}.",
            f"- train and test are the division `{division}`; others are columns `split_*`.",
            "- Licence: set one; that of meshes and recordings which went in binds what came out.",
            "",
        ]
    )

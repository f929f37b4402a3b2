"""Samples as columns: one row per sample, with what varies in length (points, candidates) end to end and offsets beside it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Points
from viewgain.datasets._sample import Frame, Sample
from viewgain.datasets._settings import PointStorage
from viewgain.datasets._tensors import Columns

_LEVELS = 65535
"""Steps of a quantised coordinate."""
TARGET = "target."
"""What the name of a column of scores begins with."""
_SCALARS: dict[str, tuple[str, Callable[[Sample], object]]] = {
    "object": ("<i4", lambda s: s.object),
    "view": ("<i2", lambda s: s.view),
    "step": ("<i2", lambda s: s.step),
    "capture": ("<i4", lambda s: s.capture),
    "noise": ("<f4", lambda s: s.noise),
    "coverage": ("<f4", lambda s: s.coverage),
    "seed": ("<u4", lambda s: s.seed),
    "dims": ("<f4", lambda s: s.dims),
    "object_to_camera": ("<f4", lambda s: s.object_to_camera),
}
_SHAPES = {"seed": (4,), "dims": (3,), "object_to_camera": (4, 4)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Tables:
    """The words that the columns count: a column holds the place of its word in these."""

    categories: tuple[str, ...]
    """Of the objects."""
    cameras: tuple[str, ...]
    """That took the scans."""
    splits: tuple[str, ...]
    """Divisions into parts."""
    parts: tuple[str, ...] = ("train", "test")
    """Their parts."""


def packed(samples: Sequence[Sample], tables: Tables, storage: PointStorage) -> Columns:
    """Return the columns of some samples, of none too; all samples have the same targets."""
    columns = {
        name: np.array([read(s) for s in samples], dtype=kind).reshape(len(samples), *_SHAPES.get(name, ()))
        for name, (kind, read) in _SCALARS.items()
    }
    columns["category"] = np.array([tables.categories.index(s.category) for s in samples], dtype="<i2")
    columns["camera"] = np.array([tables.cameras.index(s.camera) for s in samples], dtype="<i2")
    parts = [[tables.parts.index(s.splits[name]) for name in tables.splits] for s in samples]
    columns["split"] = np.array(parts, dtype=np.uint8).reshape(len(samples), len(tables.splits))
    coded = [encoded_points(s.points, storage) for s in samples]
    kind = {"quantised": "<u2", "float16": "<f2", "float32": "<f4"}[storage]
    columns["points"] = np.concatenate([np.zeros((0, 3), kind), *(points for points, _, _ in coded)])
    columns["point_origin"] = np.array([origin for _, origin, _ in coded], dtype="<f4").reshape(len(samples), 3)
    columns["point_step"] = np.array([step for _, _, step in coded], dtype="<f4")
    columns["point_offsets"] = _offsets([len(s.points) for s in samples])
    columns["candidates"] = np.concatenate([np.zeros((0, 4, 4)), *(s.candidates for s in samples)]).astype("<f4")
    columns["state"] = np.concatenate([np.zeros(0, dtype=bool), *(s.state for s in samples)])
    columns["reachable"] = np.concatenate([np.zeros(0, dtype=bool), *(s.reachable for s in samples)])
    columns["candidate_offsets"] = _offsets([len(s.candidates) for s in samples])
    for name in samples[0].targets if samples else ():
        columns[TARGET + name] = np.concatenate([s.targets[name] for s in samples]).astype("<f4")
    return columns


def unpacked(columns: Columns, row: int, tables: Tables, frame: Frame, targets: Sequence[str]) -> Sample:
    """Return one sample; arrays are views of the columns but for the points, which are float32."""
    low, high = columns["candidate_offsets"][row : row + 2].tolist()
    start, end = columns["point_offsets"][row : row + 2].tolist()
    parts = columns["split"][row].tolist()
    a, b, c, d = columns["seed"][row].tolist()
    return Sample(
        points=decoded_points(columns["points"][start:end], columns["point_origin"][row], columns["point_step"][row]),
        frame=frame,
        view=int(columns["view"][row]),
        state=columns["state"][low:high],
        candidates=columns["candidates"][low:high],
        reachable=columns["reachable"][low:high],
        camera=tables.cameras[columns["camera"][row]],
        noise=float(columns["noise"][row]),
        object=int(columns["object"][row]),
        category=tables.categories[columns["category"][row]],
        dims=columns["dims"][row],
        object_to_camera=columns["object_to_camera"][row],
        coverage=float(columns["coverage"][row]),
        step=int(columns["step"][row]),
        capture=int(columns["capture"][row]),
        seed=(a, b, c, d),
        splits={name: tables.parts[part] for name, part in zip(tables.splits, parts, strict=True)},
        targets={name: columns[TARGET + name][low:high] for name in targets},
    )  # fmt: skip


def encoded_points(points: Points, storage: PointStorage) -> tuple[NDArray[np.generic], Points, np.float32]:
    """Return stored numbers, origin (3,) and step: a point is origin + step * number, in float32."""
    if storage != "quantised" or len(points) == 0:
        kind = {"quantised": "<u2", "float16": "<f2", "float32": "<f4"}[storage]
        return points.astype(kind), np.zeros(3), np.float32(1)
    origin = points.min(axis=0).astype(np.float32)
    span = float((points - origin).max())
    step = np.float32(span / _LEVELS) if span > 0 else np.float32(1)
    return np.clip(np.rint((points - origin) / step), 0, _LEVELS).astype("<u2"), origin.astype(float), step


def decoded_points(stored: NDArray[np.generic], origin: NDArray[np.float32], step: np.float32) -> NDArray[np.float32]:
    """Return (n, 3) float32 points."""
    points = stored.astype(np.float32)
    points *= step
    for axis in range(3):  # a sum along rows of three would take three times as long
        points[:, axis] += origin[axis]
    return points


def _offsets(lengths: Sequence[int]) -> NDArray[np.int64]:
    return np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(np.array(lengths, dtype=np.int64))])

"""Boxes measured by the default estimator from positions of several rigs, alone and fused in pairs.

The expected error is fitted to them. No other benchmark and no evaluation draws these boxes.
"""

import json
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from viewgain.arrays import Poses
from viewgain.box import Box
from viewgain.camera import Sensor, sensor
from viewgain.datasets import write_whole
from viewgain.errors import ViewgainError
from viewgain.gain import BoxScans, measured_scan, measured_volume
from viewgain.measure import POSE_SIGMA, Measurement, fuse_measurements
from viewgain.rigs import Rig, Target, irregular_rig, poses, refusals, rig
from viewgain.scenes import SceneRanges, random_box
from viewgain.simulate import draw_range_error, single_threads

CAMERAS = {"pico_flexx": 0.5, "flexx2": 0.25, "kinect_v2": 0.15, "azure_kinect_nfov": 0.1}
"""How often each camera is drawn; large images cost more."""
PAIRS = 3
"""Pairs of positions that are fused, per box."""
STAYING = 3
"""Of every so many boxes one is also measured twice from the same position."""
_STREAM = (0x5A5A, 2)
_RANDOM_STATIONS = 6
_ELEVATION, _DISTANCE = np.deg2rad(35.0), 1.2
_SIDES = (0.05, 1.2)


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredBox:
    """One box and what came of measuring it."""

    number: int
    """Which box."""
    camera: str
    """Which."""
    box: Box
    """World frame."""
    stations: Poses
    """(V, 4, 4) positions without jitter, ``camera_to_world``."""
    alone: dict[int, float]
    """Relative volume error of one scan from each position that can be reached; NaN for a miss."""
    pairs: tuple[tuple[int, int, float], ...]
    """The present position, the next, and the error of both fused."""


def measured_boxes(count: int, folder: Path | None, workers: int) -> Iterator[MeasuredBox]:
    """Yield those of boxes 0 to ``count`` - 1 that leave a camera two positions; kept in the folder, and taken from there."""
    numbers = range(count)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    with single_threads(), ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        for found in pool.map(_kept, numbers, [folder] * count, chunksize=8):
            if found is not None:
                yield found


def _kept(number: int, folder: Path | None) -> MeasuredBox | None:
    file = None if folder is None else folder / f"box{number:05d}.json"
    if file is not None and file.exists():
        return _from_dict(number, json.loads(file.read_text(encoding="utf-8")))
    found = measured_box(number)
    if file is not None:
        write_whole(file, json.dumps(_to_dict(found)).encode())
    return found


@dataclass(frozen=True, slots=True, eq=False)
class DrawnBox:
    """One box before it is measured."""

    box: Box
    """World frame."""
    camera: Sensor
    """As its data sheet has it."""
    stations: Poses
    """(V, 4, 4) positions without jitter, ``camera_to_world``."""
    reachable: tuple[int, ...]
    """Positions where a camera can stand; two or more."""
    rig: str
    """What the positions are of."""
    scans: BoxScans
    """All its scans."""


def drawn_box(rng: np.random.Generator) -> DrawnBox | None:
    """Draw a box, a camera and positions; None where fewer than two positions can be reached."""
    camera = sensor(str(rng.choice(list(CAMERAS), p=list(CAMERAS.values()))))
    box = random_box(rng, SceneRanges(extent=_SIDES, yaw_deg=(0.0, 360.0)))
    stations = _rig(rng)
    target = Target(box.box_to_camera, box.extents)
    cameras = poses(stations, target, elevation=float(_ELEVATION), distance=_DISTANCE)
    limits = replace(stations, min_distance=max(stations.min_distance, camera.range_min))
    reachable = tuple(view for view, reason in enumerate(refusals(limits, cameras, target)) if reason is None)
    if len(reachable) < 2:
        return None
    seed = int(rng.integers(2**31))
    error = draw_range_error(camera, rng=rng)
    scans = BoxScans(
        box=box, rig=stations, sensor=camera, seed=seed, elevation=float(_ELEVATION), distance=_DISTANCE, error=error
    )
    return DrawnBox(box, camera, cameras, reachable, stations.name, scans)


def stream_of(number: int) -> np.random.Generator:
    """Return what everything about a box is drawn from, :func:`drawn_box` first."""
    return np.random.default_rng([*_STREAM, number])


def measured_box(number: int) -> MeasuredBox | None:
    """Measure a box; None where fewer than two positions can be reached."""
    rng = stream_of(number)
    drawn = drawn_box(rng)
    if drawn is None:
        return None
    box, scans = drawn.box, drawn.scans
    measured = {view: _measured(scans, view) for view in drawn.reachable}
    alone = {view: _error([found], box) for view, found in measured.items()}
    pairs = []
    for _ in range(PAIRS):
        present, following = rng.choice(list(measured), 2, replace=False).tolist()
        pairs.append((present, following, _error([measured[present], measured[following]], box)))
    if number % STAYING == 0:
        present = pairs[0][0]
        pairs.append((present, present, _error([measured[present], _measured(scans, present, 1)], box)))
    return MeasuredBox(number, drawn.camera.name, box, drawn.stations, alone, tuple(pairs))


def _rig(rng: np.random.Generator) -> Rig:
    """Return irregular4 twice in five, ring8 once, random positions else."""
    kind = int(rng.integers(5))
    if kind < 2:
        return rig("irregular4")
    return rig("ring8") if kind == 2 else irregular_rig(_RANDOM_STATIONS, rng=rng)


def _measured(scans: BoxScans, view: int, number: int = 0) -> Measurement | None:
    try:
        return measured_scan(scans, view, number, POSE_SIGMA)
    except (ViewgainError, np.linalg.LinAlgError):
        return None


def _error(found: list[Measurement | None], box: Box) -> float:
    known = [each for each in found if each is not None]
    if not known:
        return float("nan")
    try:
        whole = known[0] if len(found) == 1 else fuse_measurements(known)
        return measured_volume(whole) / box.volume - 1
    except (ViewgainError, np.linalg.LinAlgError):
        return float("nan")


def _to_dict(found: MeasuredBox | None) -> dict[str, object]:
    if found is None:
        return {}
    return {
        "camera": found.camera,
        "box_to_world": found.box.box_to_camera.tolist(),
        "extents": found.box.extents.tolist(),
        "stations": found.stations.tolist(),
        "alone": {str(view): _or_null(error) for view, error in found.alone.items()},
        "pairs": [[one, two, _or_null(error)] for one, two, error in found.pairs],
    }


def _from_dict(number: int, content: dict[str, object]) -> MeasuredBox | None:
    if not content:
        return None
    read = {name: np.array(content[name], dtype=float) for name in ("box_to_world", "extents", "stations", "pairs")}
    alone, pairs = content["alone"], content["pairs"]
    assert isinstance(alone, dict)
    assert isinstance(pairs, list)
    box = Box(read["box_to_world"], read["extents"])
    errors = {int(view): _or_nan(error) for view, error in alone.items()}
    return MeasuredBox(
        number,
        str(content["camera"]),
        box,
        read["stations"],
        errors,
        tuple((one, two, _or_nan(error)) for one, two, error in pairs),
    )


def _or_null(error: float) -> float | None:
    return float(error) if np.isfinite(error) else None


def _or_nan(error: float | None) -> float:
    return float("nan") if error is None else error

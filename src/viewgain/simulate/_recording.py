"""A recording: the scans of one scene from all stations of a rig, on disk, with the truth beside them.

Scan k of station s draws from the seeds (seed, 1, s, k), so the files are the same bits however many processes write them.
"""

import json
import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from importlib.metadata import version
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from viewgain.arrays import Poses, Vector3
from viewgain.camera import Sensor
from viewgain.errors import ConfigError, ScanError
from viewgain.geometry import inverse, transform
from viewgain.rays import SceneCaster
from viewgain.rigs import Rig, Target, poses, refusals
from viewgain.scans import MIN_POINTS, write_files, write_scan
from viewgain.scenes import Scene
from viewgain.simulate._capture import capture
from viewgain.simulate._effects import ALL_EFFECTS, NO_EFFECTS, Effects
from viewgain.simulate._receive import NO_ERROR, RangeError

FORMATS = ("png", "npz", "ply")
"""What a scan can be written as."""
FARTHEST = 1000.0
"""Farther from its target than this no station is placed, metres."""
SCHEMA = 1
"""Version of the layout of truth.json."""
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording:
    """What to record."""

    scene: Scene
    """What is seen."""
    target: Target
    """What the rig stands around."""
    sensor: Sensor
    """The camera."""
    rig: Rig
    """Where it stands."""
    seed: int = 0
    """Source of all randomness."""
    captures: int = 1
    """Scans per station, each with the rig's jitter drawn anew."""
    elevation: float = float(np.deg2rad(35.0))
    """For the stations that leave it open, radians."""
    distance: float = 1.2
    """For the stations that leave it open, metres."""
    effects: Effects = ALL_EFFECTS
    """What the camera does to the truth."""
    error: RangeError = NO_ERROR
    """Systematic error of this camera."""
    frames: int = 1
    """Frames averaged per scan."""
    perfect: bool = False
    """No noise, no jitter, no effects at all."""
    formats: tuple[str, ...] = ("png", "npz")
    """What to write of each scan."""
    by_station: bool = False
    """A folder for each station, by its name, as recordings are read (docs/recording.md)."""

    def __post_init__(self) -> None:
        if self.captures < 1 or self.frames < 1:
            raise ConfigError(f"got {self.captures} captures of {self.frames} frames, wanted at least one of each")
        if self.seed < 0:
            raise ConfigError(f"got seed {self.seed}, wanted a whole number from 0 on")
        if not (np.isfinite(self.elevation) and 0 < self.distance <= FARTHEST):
            place = f"elevation {np.rad2deg(self.elevation):g} degrees, distance {self.distance:g} m"
            raise ConfigError(f"got {place}; wanted a finite angle and a distance over 0 and up to {FARTHEST:g} m")
        if self.perfect and self.error != NO_ERROR:
            raise ConfigError("got a perfect camera with a systematic error; leave one of the two out")
        if self.perfect:
            object.__setattr__(self, "effects", NO_EFFECTS)
        unknown = set(self.formats) - set(FORMATS)
        if unknown or not self.formats:
            raise ConfigError(f"got formats {list(self.formats)}, wanted some of {', '.join(FORMATS)}")
        if self.by_station:
            self._check_folders()

    def _check_folders(self) -> None:
        """Refuse what would be read back otherwise: every file is a scan there, and folders come in alphabetical order."""
        if len(self.formats) > 1:
            raise ConfigError(f"got formats {list(self.formats)} by station, wanted one: a scan in two files would count twice")
        names = [folder_of(self.rig, station) for station in range(len(self.rig.stations))]
        if names != sorted(names):
            raise ConfigError(f"rig {self.rig.name}: got stations {names}, wanted alphabetical order, as folders are read")


@dataclass(frozen=True, slots=True)
class Shot:
    """One scan of a recording, taken or not."""

    station: int
    """Index of the station in the rig."""
    capture: int
    """Which of its scans."""
    name: str | None
    """File name without ending, with its folder if it has one; None if the camera cannot stand there or saw nothing."""
    camera_to_world: list[list[float]]
    """(4, 4) pose."""
    reason: str | None
    """Why there is no scan."""


def record(recording: Recording, folder: Path, *, workers: int = 1) -> list[Shot]:
    """Write all scans and ``truth.json``; return one entry per station and capture, in rig order.

    Args:
        recording: What to record.
        folder: Where to; made if it is missing.
        workers: Processes to share the stations, at least 1.

    Raises:
        ScanError: If the folder cannot be written; what was written whole stays, and truth.json comes last.
        ConfigError: If the folder holds a recording already, or there is no worker.
    """
    if workers < 1:
        raise ConfigError(f"got {workers} workers, wanted at least 1")
    stations = range(len(recording.rig.stations))
    own = [folder / folder_of(recording.rig, station) for station in stations] if recording.by_station else []
    if (folder / "truth.json").exists() or any(any(each.glob("view[0-9]*_*")) for each in (folder, *own)):
        raise ConfigError(f"{folder}: holds a recording already; name another folder, or empty this one")
    for each in (folder, *own):
        _make_folder(each)
    if workers == 1:
        caster = SceneCaster(recording.scene)
        shots = [shot for station in stations for shot in _record_station(recording, folder, station, caster)]
    else:
        with single_threads(), ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            parts = pool.map(_record_in_process, [recording] * len(stations), [folder] * len(stations), stations)
            shots = [shot for part in parts for shot in part]
    write_files({folder / "truth.json": json.dumps(truth(recording, shots), indent=1, allow_nan=False).encode()})
    return shots


def truth(recording: Recording, shots: list[Shot]) -> dict[str, Any]:
    """Return what is true of a recording, as it stands in truth.json (metres, radians, world frame, poses as rows)."""
    scene = recording.scene
    return {
        "schema": SCHEMA,
        "viewgain": version("viewgain"),
        "camera": recording.sensor.name,
        "rig": recording.rig.name,
        "seed": recording.seed,
        "frames": recording.frames,
        "perfect": recording.perfect,
        "effects": asdict(recording.effects),
        "range_error": asdict(recording.error),
        "boxes": [
            {"extents": box.extents.tolist(), "box_to_world": box.box_to_camera.tolist(), "volume": box.volume}
            for box in scene.boxes
        ],
        "meshes": [
            {"name": mesh.name, "extents": mesh.extents.tolist(), "low": mesh.bounds[0].tolist()} for mesh in scene.meshes
        ],
        "planes": [{"normal": plane.normal.tolist(), "offset": plane.offset} for plane in scene.planes],
        "reflectivity": scene.body_reflectivity.tolist(),
        "scans": [asdict(shot) for shot in shots],
    }


def folder_of(rig: Rig, station: int) -> str:
    """Return the name of a station's folder: its own, or ``view00``."""
    return rig.stations[station].name or f"view{station:02d}"


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ScanError(f"{folder}: cannot be made ({error.strerror}); name a folder that can be written") from error


@contextmanager
def single_threads() -> Iterator[None]:
    """Give every process started inside one thread: pools of threads on the same cores made them six times slower."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def station_poses(recording: Recording, station: int, number: int) -> tuple[Poses, np.random.Generator]:
    """Return the rig's (v, 4, 4) poses for one capture of one station, and the generator for its scan."""
    rng = np.random.default_rng([recording.seed, 1, station, number])
    jitter = None if recording.perfect else rng
    cameras = poses(recording.rig, recording.target, elevation=recording.elevation, distance=recording.distance, rng=jitter)
    return cameras, rng


def _record_in_process(recording: Recording, folder: Path, station: int) -> list[Shot]:
    return _record_station(recording, folder, station, SceneCaster(recording.scene))


def _record_station(recording: Recording, folder: Path, station: int, caster: SceneCaster) -> list[Shot]:
    shots = []
    inside = f"{folder_of(recording.rig, station)}/" if recording.by_station else ""
    for number in range(recording.captures):
        cameras, rng = station_poses(recording, station, number)
        name = f"{inside}view{station:02d}_{number:03d}"
        reason = refusals(recording.rig, cameras, recording.target)[station] or blocked(recording.scene, cameras[station, :3, 3])
        if reason is None:
            reason = _shoot(recording, folder / name, caster, cameras[station], rng)
        shots.append(Shot(station, number, None if reason else name, cameras[station].tolist(), reason))
    return shots


def blocked(scene: Scene, eye: Vector3) -> str | None:
    """Return why no camera can be at a point of the world: within a box, or behind a plane, through which it would see."""
    if any(plane.height(eye) <= 0 for plane in scene.planes):
        return "behind a wall"
    for box in scene.boxes:
        local = transform(inverse(box.box_to_camera), eye) - [0.0, 0.0, box.extents[2] / 2]
        if np.all(np.abs(local) <= box.extents / 2):
            return "inside a box"
    return None


def _shoot(recording: Recording, path: Path, caster: SceneCaster, camera_to_world: Poses, rng: np.random.Generator) -> str | None:
    """Take and write one scan; return why there is none."""
    try:
        scan = capture(
            caster, camera_to_world, recording.sensor, rng=None if recording.perfect else rng, effects=recording.effects,
            error=recording.error, frames=recording.frames, source=path.name,
        )  # fmt: skip
    except ScanError:
        return f"fewer than {MIN_POINTS} returns"
    for ending in recording.formats:
        # Fine enough to add nothing to the camera's own noise, coarse enough for 16 bits to hold its farthest depth.
        scale = float(np.clip(recording.sensor.range_max / 65_000, 1e-4, 1e-2))
        write_scan(scan, path.with_suffix(f".{ending}"), depth_scale=scale)
    return None

"""Objects of any shape from a seed, and what a second view from every position of a rig makes of their volumes."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from viewgain.arrays import Array, Mask, Points, Poses
from viewgain.camera import Sensor, sensor
from viewgain.datasets import CoverageSettings, recipe
from viewgain.errors import ConfigError
from viewgain.evaluation._objects import RECIPE
from viewgain.evaluation._volume_case import LEAST_CAPTURES
from viewgain.gain import MeshScans, believed_scan
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.measure import POSE_SIGMA
from viewgain.meshes import MeshFolder, TriangleMesh
from viewgain.parcels import Standing, hull_volume, standing, standing_points, upright_box
from viewgain.rigs import Rig, poses, refusals, rig
from viewgain.scans import Scan
from viewgain.shapes import CATEGORIES, procedural
from viewgain.simulate import ALL_EFFECTS, draw_range_error

VOLUMES = ("hull", "standing box")
"""What is measured of an object: the volume of its convex hull, and of the smallest box that stands on the floor around it."""
MODELLED = ALL_EFFECTS.without("multipath")
"""As objects of any shape are judged everywhere (docs/accuracy.md): nothing here has a model of multipath."""
_CASE = 0x7368
"""Stream of objects."""
_TRIES = 100


def held_out() -> tuple[str, ...]:
    """Return the procedural categories that no shipped coverage network was trained on."""
    content = recipe(RECIPE).content
    assert isinstance(content, CoverageSettings)
    return content.held_out


@dataclass(frozen=True, slots=True, kw_only=True)
class ShapeSettings:
    """What is asked: objects, rig, camera. Two of equal settings are about the same objects and the same scans."""

    seed: int = 0
    """Source of all objects and scans, >= 0."""
    categories: tuple[str, ...] = ()
    """Kinds of objects, taken in turn; none for those of :func:`held_out`, or all of a folder of meshes."""
    meshes: Path | None = None
    """A folder of meshes (docs/meshes.md) with z up; None for procedural objects."""
    size: tuple[float, float] = (0.2, 0.8)
    """Shortest and longest diagonal of the box around an object along the axes of its mesh, uniform, metres."""
    rig: str = "ring8"
    """Positions: a preset or a rig file."""
    camera: str = "pico_flexx"
    """Camera: a preset or a file; each object has one of its own, with a systematic error drawn from what calibration leaves."""
    captures: int = 2
    """Scans of each position that score it; as many others are the oracle's."""
    distance: float = 1.2
    """For stations that leave it open, metres from the object's centre."""
    elevation_deg: float = 35.0
    """For stations that leave it open, degrees."""

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise ConfigError(f"evaluate shapes: got seed {self.seed}, wanted 0 or more")
        if self.captures < LEAST_CAPTURES:
            raise ConfigError(f"evaluate shapes: got {self.captures} captures, wanted {LEAST_CAPTURES} or more")
        if not 0 < self.size[0] <= self.size[1] < np.inf or not 0 < self.distance < np.inf:
            raise ConfigError(
                f"evaluate shapes: got sizes {self.size} and distance {self.distance}, wanted [low, high], positive and finite"
            )
        if not np.isfinite(self.elevation_deg):
            raise ConfigError(f"evaluate shapes: got elevation {self.elevation_deg}, wanted a finite number of degrees")
        self.stations()
        self.kinds()
        sensor(self.camera)

    def to_dict(self) -> dict[str, Any]:
        """Return the settings as plain values for JSON."""
        return {**dataclasses.asdict(self), "meshes": None if self.meshes is None else str(self.meshes)}

    @property
    def fused(self) -> bool:
        """A position is worth what its scan and the present one say together."""
        return True

    def stations(self) -> Rig:
        """Return the rig."""
        return rig(self.rig)

    def kinds(self) -> tuple[str, ...]:
        """Return the kinds of objects, in turn; raises ConfigError if one is not known, MeshError if there is no mesh."""
        if self.meshes is not None:
            return _folder(self.meshes).only(self.categories).categories if self.categories else _folder(self.meshes).categories
        unknown = sorted(set(self.categories) - set(CATEGORIES))
        if unknown:
            raise ConfigError(f"categories: got {', '.join(unknown)}, wanted some of {', '.join(sorted(CATEGORIES))}")
        return self.categories or held_out()


@dataclass(frozen=True, slots=True, eq=False)
class ShapeCase:
    """One object: where it stands, where the camera stands, and where it could go."""

    number: int
    """Which object."""
    category: str
    """Its kind."""
    settings: ShapeSettings
    """What it was drawn for."""
    scans: MeshScans
    """The object and all its scans."""
    stations: Poses
    """(V, 4, 4) ``camera_to_world`` of the positions, without jitter."""
    reachable: Mask
    """(V,) where the camera can go for a second view; at least two positions, the present one is none."""
    present: int
    """Where the camera stands when it decides."""

    @property
    def camera(self) -> Sensor:
        """The camera as its data sheet has it."""
        return self.scans.sensor

    @property
    def seen(self) -> Scan | None:
        """The first scan, with the pose that the camera believes in; None where it shows next to nothing."""
        return believed_scan(self.scans, self.present, 2 * self.settings.captures, POSE_SIGMA)


def shape_case(settings: ShapeSettings, number: int) -> ShapeCase:
    """Return object ``number`` of a seed. One that leaves a camera fewer than two positions to go to is drawn anew.

    Raises:
        ConfigError: If none of 100 leaves two.
        MeshError: If a mesh cannot be read.
    """
    rng = np.random.default_rng([settings.seed, _CASE, number])
    kinds, camera = settings.kinds(), sensor(settings.camera)
    category, rig_ = kinds[number % len(kinds)], settings.stations()
    limits = replace(rig_, min_distance=max(rig_.min_distance, camera.range_min))
    for _ in range(_TRIES):
        scans = MeshScans(
            mesh=_standing(_drawn(settings, category, rng), settings.size, rng),
            rig=rig_,
            sensor=camera,
            seed=int(rng.integers(2**31)),
            elevation=float(np.deg2rad(settings.elevation_deg)),
            distance=settings.distance,
            effects=MODELLED,
            error=draw_range_error(camera, rng=rng),
        )
        cameras = poses(rig_, scans.target, elevation=scans.elevation, distance=scans.distance)
        reachable = np.array([reason is None for reason in refusals(limits, cameras, scans.target)])
        if reachable.sum() > 2:
            present = int(rng.choice(np.flatnonzero(reachable)))
            reachable[present] = False
            return ShapeCase(number, category, settings, scans, cameras, reachable, present)
    raise ConfigError(
        f"evaluate shapes: got no {category} of {_TRIES} with two positions of rig {rig_.name} to go to; take smaller objects or"
        " a greater --distance"
    )


def true_volumes(mesh: TriangleMesh) -> Array:
    """Return the (2,) :data:`VOLUMES` of a mesh that stands on z = 0, cubic metres."""
    return volumes_of(mesh.vertices[np.unique(mesh.faces)])


def volumes_of(points: Points) -> Array:
    """Return the (2,) :data:`VOLUMES` of (n, 3) points, n >= 1, cubic metres."""
    return np.array([hull_volume(points), upright_box(points).volume])


def shape_errors(case: ShapeCase) -> Array:
    """Return (2, V, 2n) relative errors of the :data:`VOLUMES`: n scans of each position that score it, then n for the oracle.

    Each is joined with the first scan, always the same. NaN where neither shows an object, and for positions out of reach.
    """
    count = 2 * case.settings.captures
    errors = np.full((len(VOLUMES), case.scans.views, count), np.nan)
    truth, first = true_volumes(case.scans.mesh), _shown(case, case.present, count)
    for view in np.flatnonzero(case.reachable).tolist():
        for number in range(count):
            errors[:, view, number] = _relative([first, _shown(case, view, number)], truth)
    return errors


def first_errors(case: ShapeCase) -> Array:
    """Return (2,) relative errors of the :data:`VOLUMES` by the first scan alone; NaN where it shows no object."""
    return _relative([_shown(case, case.present, 2 * case.settings.captures)], true_volumes(case.scans.mesh))


def _relative(parts: Sequence[Standing | None], truth: Array) -> Array:
    points = standing_points([part for part in parts if part is not None])
    return volumes_of(points) / truth - 1 if len(points) else np.full(len(VOLUMES), np.nan)


def _shown(case: ShapeCase, view: int, number: int) -> Standing | None:
    scan = believed_scan(case.scans, view, number, POSE_SIGMA)
    return None if scan is None else standing(scan, camera=case.camera)


def _drawn(settings: ShapeSettings, category: str, rng: np.random.Generator) -> TriangleMesh:
    if settings.meshes is None:
        return procedural(category, rng=rng)
    entries = _folder(settings.meshes).only([category])
    return entries[int(rng.integers(len(entries)))].load()


def _standing(mesh: TriangleMesh, size: tuple[float, float], rng: np.random.Generator) -> TriangleMesh:
    """Return a mesh as large as drawn, turned about the vertical, on the floor."""
    turn = pose(rotation_from_rotvec(np.array([0.0, 0.0, rng.uniform(0, 2 * np.pi)])), np.zeros(3))
    return mesh.normalised(rng.uniform(*size)).moved(turn).standing()


@lru_cache(maxsize=4)
def _folder(root: Path) -> MeshFolder:
    return MeshFolder.open(root)

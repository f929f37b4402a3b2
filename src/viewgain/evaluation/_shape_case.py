"""Objects of any shape from a seed, and what a second view from every position of a rig makes of their volumes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from viewgain.arrays import Array, Mask, Points, Poses
from viewgain.camera import Sensor, sensor
from viewgain.errors import ConfigError
from viewgain.evaluation._shape_settings import ShapeSettings, mesh_folder
from viewgain.gain import MeshScans, believed_scan
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.measure import POSE_SIGMA
from viewgain.meshes import TriangleMesh
from viewgain.parcels import Standing, hull_volume, standing, standing_points, upright_box
from viewgain.rigs import poses, refusals
from viewgain.scans import Scan
from viewgain.shapes import procedural
from viewgain.simulate import ALL_EFFECTS, draw_range_error

VOLUMES = ("hull", "standing box")
"""What is measured of an object: the volume of its convex hull, and of the smallest box that stands on the floor around it."""
MODELLED = ALL_EFFECTS.without("multipath")
"""As objects of any shape are judged everywhere (docs/accuracy.md): nothing here has a model of multipath."""
_CASE = 0x7368
"""Stream of objects."""
_TRIES = 100


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
    entries = mesh_folder(settings.meshes).only([category])
    return entries[int(rng.integers(len(entries)))].load()


def _standing(mesh: TriangleMesh, size: tuple[float, float], rng: np.random.Generator) -> TriangleMesh:
    """Return a mesh as large as drawn, turned about the vertical, on the floor."""
    turn = pose(rotation_from_rotvec(np.array([0.0, 0.0, rng.uniform(0, 2 * np.pi)])), np.zeros(3))
    return mesh.normalised(rng.uniform(*size)).moved(turn).standing()

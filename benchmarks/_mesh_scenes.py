"""One object on a floor, of many kinds, with the truth of its enclosing boxes and volumes: scenes from seeds."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchmarks._not_boxes import turned
from viewgain.arrays import Pose
from viewgain.camera import Intrinsics, Sensor, sensor
from viewgain.meshes import MeshFolder, TriangleMesh
from viewgain.parcels import hull_volume, smallest_box, upright_box
from viewgain.scans import Scan
from viewgain.scenes import Scene, orbit_pose
from viewgain.shapes import CATEGORIES, procedural
from viewgain.simulate import Effects, capture, draw_range_error, true_hits

Array = NDArray[np.float64]

CAMERAS = ("pico_flexx", "xtion")
DIAGONAL = (0.2, 0.8)
"""Diagonal of the objects' bounding boxes, uniform, metres."""
ELEVATION = (20.0, 60.0)
"""Height of the camera over the horizon as seen from the object, uniform, degrees."""
MAX_FACES = 60_000
"""Real meshes with more triangles are left out: they take long and look no different."""
_CELLS = 160
_HEIGHT = 200.0
EFFECTS = Effects().without("multipath")


@dataclass(frozen=True, slots=True, eq=False)
class MeshScene:
    """A scan of one object, and the truth."""

    category: str
    """Category, ``procedural/chair`` or ``real/vehicle``."""
    camera: Sensor
    """The camera, as the measurement knows it."""
    scan: Scan
    """What it saw, its systematic error drawn."""
    truth: Array
    """(10,) in the order of viewgain.parcels.QUANTITIES."""


def split(names: tuple[str, ...]) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Return the categories to fit on (half of the sorted names), for the conformal step (a quarter), and unseen (a quarter)."""
    names = tuple(sorted(names))
    fit = tuple(name for k, name in enumerate(names) if k % 4 in (0, 2))
    return fit, names[1::4], names[3::4]


def all_categories(folder: MeshFolder) -> tuple[str, ...]:
    """Return the names of all procedural and real categories."""
    return (*(f"procedural/{name}" for name in CATEGORIES), *(f"real/{name}" for name in folder.categories))


def mesh_scene(category: str, folder: MeshFolder, *, rng: np.random.Generator, half: int | None = None) -> MeshScene:
    """Return a random scene with one object of a category.

    Args:
        category: One of :func:`all_categories`.
        folder: The real meshes.
        rng: Source of all randomness.
        half: 0 or 1: only every second mesh of a real category, so that no mesh is in both halves; None for all.
    """
    mesh = _object(category, folder, rng, half)
    camera = sensor(CAMERAS[rng.integers(2)])
    low, high = mesh.bounds
    diagonal = float(np.linalg.norm(high - low))
    azimuth, elevation = rng.uniform(0, 2 * np.pi), np.deg2rad(rng.uniform(*ELEVATION))
    distance = rng.uniform(max(0.6, 1.2 * diagonal), max(1.6, 2.0 * diagonal))
    target = (low + high) / 2 + rng.normal(0, 0.03, 3)
    view = orbit_pose(target, azimuth, elevation, distance, float(np.deg2rad(rng.normal(0, 3))))
    error = draw_range_error(camera, rng=rng)
    scan = capture(Scene(meshes=(mesh,)), view, camera, rng=rng, effects=EFFECTS, error=error, source=category)
    return MeshScene(category, camera, scan, truth_of(mesh))


def truth_of(mesh: TriangleMesh) -> Array:
    """Return the (10,) true quantities of a mesh that stands on z = 0; the heap from a view from 200 m above."""
    corners = mesh.vertices[np.unique(mesh.faces)]
    upright, free = upright_box(corners), smallest_box(corners)
    return np.array([
        *upright.extents, upright.volume, *free.extents, free.volume, hull_volume(corners), true_heap(mesh),
    ])  # fmt: skip


def true_heap(mesh: TriangleMesh) -> float:
    """Return the volume between floor and topmost surface, by the midpoint rule on a grid of about 160 x 160 cells."""
    low, high = mesh.bounds
    cell = float((high - low)[:2].max()) * 1.02 / _CELLS
    above = Intrinsics(
        width=_CELLS, height=_CELLS, fx=_HEIGHT / cell, fy=_HEIGHT / cell, cx=(_CELLS - 1) / 2, cy=(_CELLS - 1) / 2
    )
    middle = (low + high) / 2
    view = np.diag([1.0, -1.0, -1.0, 1.0])
    view[:3, 3] = middle[0], middle[1], _HEIGHT
    hits = true_hits(Scene(meshes=(mesh,), planes=()), view, replace(sensor("pico_flexx"), intrinsics=above))
    heights = _HEIGHT - hits.ranges * above.directions().reshape(-1, 3)[:, 2]
    return float(cell**2 * heights[np.isfinite(heights)].sum())


def _object(category: str, folder: MeshFolder, rng: np.random.Generator, half: int | None) -> TriangleMesh:
    """Return a mesh of the category, as large as drawn, turned about the vertical, standing at the origin."""
    source, name = category.split("/")
    around: Pose = np.array([0, 0, rng.uniform(0, 2 * np.pi)])
    size = rng.uniform(*DIAGONAL)
    if source == "procedural":
        mesh = procedural(name, rng=rng)
    else:
        entries = list(folder.only([name]))
        entries = entries if half is None or len(entries) < 2 else entries[half::2]
        mesh = entries[rng.integers(len(entries))].load()
        if not name.startswith("capod"):  # these have y up
            mesh = turned(mesh, np.array([np.pi / 2, 0, 0]))
    return turned(mesh.normalised(size), around).standing()

"""How fast the simulator is: rays against boxes and meshes, whole scans, and the paper's synthetic set, beside the obvious ways.

Everything runs on one thread; the paper's set on two processes of one thread each.
"""

import argparse
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
from numpy.typing import NDArray

from benchmarks._tables import markdown
from viewgain.box import Box
from viewgain.camera import Intrinsics, sensor
from viewgain.geometry import inverse
from viewgain.meshes import TriangleMesh
from viewgain.rays import EmbreeMesh, SceneCaster, as_rows, bodies_in_camera, cast_slabs, pixel_rays, zbuffer
from viewgain.rigs import Target, poses, rig
from viewgain.scenes import FLOOR, Scene, orbit_pose, standing_box
from viewgain.simulate import Effects, capture, single_threads

Array = NDArray[np.float64]

VGA = Intrinsics.from_field_of_view(640, 480, *np.deg2rad([58.0, 45.0]))
BLOCK = 16384
REPEATS = 7
PAPER_BOXES, PAPER_CAPTURES = 11, 1000
"""The paper's synthetic set: 11 boxes, 4 positions, 700 scans to train on and 300 to test on."""


def run(options: argparse.Namespace) -> None:
    """Print the tables."""
    print("## Simulator, one thread\n")
    print(markdown(("what", "median", "best", "goal"), [*_box_rays(), *_mesh_rays(), *_scans()]))
    print("\nM rays/s: million primary rays per second, 640x480; beside the median the best run, since machines are shared.\n")
    _paper_set(options.captures, options.workers)


def _box_rays() -> list[tuple[str, str, str, str]]:
    box = standing_box(np.array([0.4, 0.3, 0.2]), yaw=0.4)
    view = orbit_pose(box.centre, 0.7, 0.7, 1.2)
    boxes, planes = bodies_in_camera([box], [FLOOR], view)
    rows = []
    for name, kind in (("float32", np.float32), ("float64", np.float64)):
        directions = tuple(component.astype(kind) for component in pixel_rays(VGA))

        def cast(directions: tuple[Array, ...] = directions) -> None:
            for start in range(0, len(directions[0]), BLOCK):
                cast_slabs(boxes, planes, tuple(d[start : start + BLOCK] for d in directions))

        goal = "40 M rays/s" if name == "float32" else ""
        rows.append((f"box on a floor, slabs on separate x, y, z, {name}", *_rate(cast, VGA), goal))
    seen, rows_of_rays = box.in_frame(inverse(view)), VGA.directions().reshape(-1, 3)
    floor_normal, height = view[:3, :3].T @ FLOOR.normal, float(view[2, 3])
    rows.append(
        ("the same, naive numpy on (n, 3) rows", *_rate(lambda: naive_box(seen, floor_normal, height, rows_of_rays), VGA), "")
    )
    return rows


def naive_box(box: Box, floor_normal: Array, height: float, directions: Array) -> Array:
    """Return the ranges of (n, 3) rays against a box on a floor as one would first write it."""
    rotation = box.box_to_camera[:3, :3]
    origin, along = -rotation.T @ box.centre, directions @ rotation
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (-box.extents / 2 - origin) / along, (box.extents / 2 - origin) / along
        near, far = np.minimum(first, second).max(axis=1), np.maximum(first, second).min(axis=1)
        floor = -height / (directions @ floor_normal)
    return np.minimum(np.where((near < far) & (near > 0), near, np.inf), np.where(floor > 0, floor, np.inf))


def bumpy_sphere(rings: int = 160) -> TriangleMesh:
    """Return a sphere with bumps of about 50,000 triangles, one metre across."""
    polar, around = np.meshgrid(np.linspace(0, np.pi, rings), np.linspace(0, 2 * np.pi, rings, endpoint=False), indexing="ij")
    radius = 0.5 + 0.03 * np.sin(9 * polar) * np.cos(7 * around)
    points = np.stack(
        [radius * np.sin(polar) * np.cos(around), radius * np.sin(polar) * np.sin(around), radius * np.cos(polar)], -1
    )
    i, j = np.mgrid[: rings - 1, :rings]
    corner = [(i + a) * rings + (j + b) % rings for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    faces = np.concatenate([np.stack([corner[0], corner[1], corner[2]], -1), np.stack([corner[0], corner[2], corner[3]], -1)])
    return TriangleMesh(points.reshape(-1, 3), faces.reshape(-1, 3), "bumpy sphere")


def _mesh_rays() -> list[tuple[str, str, str, str]]:
    mesh = bumpy_sphere().normalised()  # PC-NBV's set-up: a diagonal of one, seen from one metre
    view = orbit_pose(np.zeros(3), 0.7, 0.5, 1.0)
    seen = mesh.moved(inverse(view))
    rays = as_rows(pixel_rays(VGA))
    world = rays @ view[:3, :3].T
    embree = EmbreeMesh(mesh)
    count = f"{len(mesh.faces):,} triangles"
    rows = [
        (
            f"{count}, depth image by z-buffer (numba)",
            *_rate(lambda: zbuffer(seen.vertices, seen.faces, VGA), VGA),
            "15 M rays/s",
        ),
        (f"{count}, any rays by Embree (embreex)", *_rate(lambda: embree.cast(view[:3, 3], world), VGA), "6 M rays/s"),
    ]
    import trimesh
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    caster = RayMeshIntersector(trimesh.Trimesh(mesh.vertices, mesh.faces, process=False))
    origins = np.broadcast_to(view[:3, 3], world.shape)
    rows.append(
        (f"{count}, trimesh's ray caster (on Embree)", *_rate(lambda: caster.intersects_first(origins, world), VGA, 3), "")
    )
    return rows


def _scans() -> list[tuple[str, str, str, str]]:
    box = standing_box(np.array([0.4, 0.3, 0.2]), yaw=0.4)
    view, camera, scene = orbit_pose(box.centre, 0.7, 0.7, 1.2), sensor("pico_flexx"), Scene((box,))
    rng = np.random.default_rng(0)
    rows = []
    for name, effects, goal in (
        ("all effects", Effects(), "100 scans/s"),
        ("without multipath", Effects().without("multipath"), ""),
        ("noise and losses only", Effects.only("noise", "loss"), ""),
    ):
        seconds = _time(lambda effects=effects: capture(scene, view, camera, rng=rng, effects=effects), 40)
        rows.append(
            (f"224x171 scan of a box, {name}", f"{1 / np.median(seconds):.0f} scans/s", f"{1 / min(seconds):.0f} scans/s", goal)
        )
    mesh = SceneCaster(Scene(meshes=(bumpy_sphere().standing(),)))
    seconds = _time(lambda: capture(mesh, view, camera, rng=rng), 10)
    rows.append(
        (
            "224x171 scan of the 50,000-triangle mesh, all effects",
            f"{1 / np.median(seconds):.0f} scans/s",
            f"{1 / min(seconds):.0f} scans/s",
            "",
        )
    )
    return rows


def _paper_set(captures: int, workers: int) -> None:
    """Print the time of the paper's synthetic set, or of a share of its captures."""
    start = time.perf_counter()
    jobs = [(box, captures) for box in range(PAPER_BOXES)]
    with single_threads(), ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        done = sum(pool.map(_paper_box, *zip(*jobs, strict=True)))
    seconds = time.perf_counter() - start
    whole = PAPER_BOXES * 4 * PAPER_CAPTURES
    what = f"{PAPER_BOXES} boxes x 4 positions x {captures} scans (pico_flexx, all effects, jitter of paper4)"
    print(f"The paper's synthetic set, {what}, on {workers} processes:")
    print(f"{seconds:.0f} s for {done:,} scans, {done / seconds:.0f} scans/s, the start of the processes included;", end=" ")
    reach = "that is" if done == whole else f"at that rate the whole set of {whole:,} takes"
    print(f"{reach} {whole / done * seconds / 60:.1f} min (goal 6 min).\n")


def _paper_box(number: int, captures: int) -> int:
    """Simulate all scans of one box of a set drawn like the paper's: sides of 0.1 to 0.6 m."""
    box = standing_box(np.random.default_rng([number, 0]).uniform(0.1, 0.6, 3))
    caster, camera, target = SceneCaster(Scene((box,))), sensor("pico_flexx"), Target(box.box_to_camera, box.extents)
    for number_of_scan in range(captures):
        rng = np.random.default_rng([number, 1, number_of_scan])
        for camera_to_world in poses(rig("paper4"), target, rng=rng):
            capture(caster, camera_to_world, camera, rng=rng)
    return 4 * captures


def _rate(work: Callable[[], object], camera: Intrinsics, repeats: int = REPEATS) -> tuple[str, str]:
    seconds = _time(work, repeats)
    rays = camera.width * camera.height / 1e6
    return f"{rays / np.median(seconds):.1f} M rays/s", f"{rays / min(seconds):.1f} M rays/s"


def _time(work: Callable[[], object], repeats: int) -> list[float]:
    work()  # compiles, and fills the caches
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return seconds

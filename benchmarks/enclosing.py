"""Enclosing boxes and volumes of objects of any shape: do the 90 % intervals hold the truth, also for kinds never seen?"""

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from benchmarks._data import data_folder
from benchmarks._mesh_scenes import MeshScene, all_categories, mesh_scene, split
from benchmarks._tables import markdown, wilson
from viewgain.measure import find_floors, range_image
from viewgain.meshes import MeshFolder
from viewgain.parcels import QUANTITIES, Enclosure, calibrated, enclose, features, find_objects, seen_and_possible
from viewgain.simulate import single_threads

DEVELOPMENT_SEEDS = range(20_000, 20_900)
"""What the calibration was made on, from the first half of the meshes of its categories."""
FIRST_SEED = 40_000
"""First seed of what is reported, from the second half of the meshes, and of unseen categories."""
SCENES = 500


def run(options: argparse.Namespace) -> None:
    """Print coverage, error and width per quantity, then coverage by kind of object."""
    if data_folder() is None:
        print("The meshes are not there (set VIEWGAIN_DATA to their folder); nothing measured.\n")
        return
    scenes = options.scenes or SCENES
    with single_threads(), ProcessPoolExecutor(options.workers, mp_context=get_context("spawn")) as pool:
        found = [row for row in pool.map(scored, range(FIRST_SEED, FIRST_SEED + scenes), chunksize=5) if row is not None]
    measured, seen_kind = np.array([row[1] for row in found]), np.array([row[2] for row in found])
    print(f"## Enclosing boxes of {scenes} mesh scenes, {len(found)} measured (seeds {FIRST_SEED} on)\n")
    print("Share of 90 % intervals that hold the truth (95 % Wilson interval), by kinds the calibration saw and did not see.\n")
    header = (
        "quantity",
        "all",
        "kinds seen",
        "kinds unseen",
        "too low",
        "too high",
        "median |error|",
        "of the seen part",
        "high / low",
    )
    print(markdown(header, [_row(k, measured, seen_kind) for k in range(len(QUANTITIES))]))
    print("\nToo low, too high: the truth lies below, above the interval. A bounded interval's high / low: median.\n")
    groups = {"procedural": "procedural/", "real meshes": "real/", "of these CAPOD": "real/capod"}
    rows = []
    for name, prefix in groups.items():
        mine = np.array([row[0].startswith(prefix) for row in found])
        rows.append((name, int(mine.sum()), *[_share(measured[mine, k, 2] == 0) for k in (0, 1, 2, 3, 7, 8, 9)]))
    print(markdown(("objects", "scenes", *[QUANTITIES[k] for k in (0, 1, 2, 3, 7, 8, 9)]), rows))
    print()


def scored(seed: int) -> tuple[str, list[tuple[float, float, int, float]], bool] | None:
    """Return category, per quantity error, seen part's error, side missed (-1, 0, 1), width; whether the kind was seen."""
    folder = _folder()
    names = all_categories(folder)
    rng = np.random.default_rng([seed, 21])
    category = names[rng.integers(len(names))]
    scene = mesh_scene(category, folder, rng=rng, half=1)
    result = enclose(scene.scan, camera=scene.camera)
    if not result.objects:
        return None
    return category, _scores(result.objects[0], scene), category not in split(names)[2]


def _scores(found: Enclosure, scene: MeshScene) -> list[tuple[float, float, int, float]]:
    estimates = [*found.upright.dimensions, found.upright.volume, *found.free.dimensions, found.free.volume]
    rows = []
    for estimate, truth in zip([*estimates, found.hull_volume, found.heap_volume], scene.truth, strict=True):
        high = np.inf if estimate.high is None else estimate.high
        missed = -1 if truth < estimate.low else 1 if truth > high else 0
        rows.append((abs(estimate.value / truth - 1), abs(estimate.seen / truth - 1), missed, high / estimate.low))
    return rows


def _row(quantity: int, measured: np.ndarray, seen_kind: np.ndarray) -> tuple[str, ...]:
    error, of_seen, missed, width = measured[:, quantity].T
    bounded = np.isfinite(width)
    return (
        QUANTITIES[quantity].replace("_", " "),
        *[_share(missed[part] == 0) for part in (np.ones(len(missed), bool), seen_kind, ~seen_kind)],
        f"{np.mean(missed < 0):.3f}",
        f"{np.mean(missed > 0):.3f}",
        f"{100 * np.median(error):.1f} %",
        f"{100 * np.median(of_seen):.1f} %",
        f"{np.median(width[bounded]):.2f}",
    )


def _share(hits: np.ndarray) -> str:
    low, high = wilson(int(hits.sum()), len(hits))
    return f"{hits.mean():.3f} ({low:.2f} to {high:.2f})"


@cache
def _folder() -> MeshFolder:
    folder = data_folder()
    assert folder is not None
    return MeshFolder.open(folder / "meshes")


def calibrate(path: Path) -> None:
    """Make the calibration anew from the development seeds and write it to ``path``."""
    folder = _folder()
    fit, conformal, _ = split(all_categories(folder))
    pool = fit + conformal
    rows = []
    for seed in DEVELOPMENT_SEEDS:
        rng = np.random.default_rng([seed, 21])
        category = pool[rng.integers(len(pool))]
        scene = mesh_scene(category, folder, rng=rng, half=0)
        image = range_image(scene.scan)
        floors = find_floors(image, scene.camera)
        objects = find_objects(image, floors[0], scene.camera) if floors else []
        if not objects or objects[0].border >= 0.02 or objects[0].hidden >= 0.1:
            continue
        near, far = seen_and_possible(objects[0])
        rows.append((features(objects[0], near, far), np.log(scene.truth / near.values), category in conformal))
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    about = f"{len(rows)} simulated scans, seeds {DEVELOPMENT_SEEDS.start} on; python -m benchmarks.enclosing FILE"
    path.write_text(calibrated(columns[0], columns[1], columns[2]).to_json(about), encoding="utf-8")


if __name__ == "__main__":
    calibrate(Path(sys.argv[1]))

"""Several boxes in one scan, touching or stacked: real cartons with labels, a real pallet, simulated stacks and rows."""

import argparse
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks._data import data_folder
from benchmarks._tables import markdown, percent, wilson
from viewgain.box import Box, box_hits, entry_mask
from viewgain.camera import Intrinsics, sensor
from viewgain.geometry import inverse
from viewgain.measure import BoxEstimate, Measurement, measure
from viewgain.scans import Scan, read_scan
from viewgain.scenes import Scene, orbit_pose, standing_box
from viewgain.simulate import Effects, capture

Array = NDArray[np.float64]
Labels = NDArray[np.int64]

KNOWN = {
    "0.245 x 0.146 x 0.062": (0.245, 0.146, 0.062),
    "0.266 x 0.194 x 0.053": (0.266, 0.194, 0.053),
    "0.254 x 0.204 x 0.055": (0.254, 0.204, 0.055),
}
"""Sizes of three of the cartons of mOSD (the data come without sizes: these were read off the scans), metres."""
IDENTITY = 0.025
"""A measured box is the known carton whose dimensions all lie within this, metres."""
MIN_LABEL = 1500
AGREES = 0.015
SMALL = np.array([0.255, 0.155])
MEDIUM = np.array([0.340, 0.250])
KINDS = ("row", "stack of two", "pyramid of three", "near-touching")
PER_KIND, SEED = 15, 71
CAMERA = sensor("pico_flexx").without_systematic()


@dataclass(frozen=True)
class Found:
    """One labelled carton and the box that was found on it."""

    scene: str
    area: int
    iou: float
    box: BoxEstimate | None


def run(options: argparse.Namespace) -> None:
    """Print the tables."""
    folder = data_folder()
    if folder is None:
        print("The real scans are not there (set VIEWGAIN_DATA to their folder).\n")
    else:
        _print_cartons(folder / "real_boxes" / "mosd_boxes")
        _print_pallet(folder / "real_boxes" / "smart_palletizer")
    _print_simulated(PER_KIND if options.scenes is None else max(options.scenes // len(KINDS), 1))


def carton_scene(path: Path) -> tuple[Scan, Labels]:
    """Return a scene of mOSD and its (h, w) object labels, 0 where there is none; parts of one object share a label."""
    with np.load(path) as content:
        depth, label, (fx, fy, cx, cy) = content["z"].astype(float), content["label"].astype(int), content["K"].astype(float)
    height, width = depth.shape
    camera = Intrinsics(width=width, height=height, fx=fx, fy=fy, cx=cx, cy=cy)
    rays = np.concatenate([camera.rays(), np.ones((height, width, 1))], axis=-1)
    scan = Scan.from_array(rays * depth[..., None], intrinsics=camera, source=path.stem)
    return scan, np.where((label >= 20) & (depth > 0), label // 10, 0)


def owners(boxes: tuple[BoxEstimate, ...], scan: Scan) -> Labels:
    """Return (h, w): which box each pixel's range lies on, within 15 mm, the nearest fit; -1 for none."""
    assert scan.intrinsics is not None
    ranges = np.linalg.norm(scan.organised(), axis=-1).ravel()
    directions = scan.intrinsics.directions().reshape(-1, 3)
    best, owner = np.full(len(ranges), AGREES), np.full(len(ranges), -1)
    for k, estimate in enumerate(boxes):
        hit = np.flatnonzero(entry_mask(estimate.box, directions))
        apart = np.abs(box_hits(estimate.box, directions[hit]).ranges - ranges[hit])
        better = apart < best[hit]
        best[hit[better]], owner[hit[better]] = apart[better], k
    return owner.reshape(scan.shape)


def matched(result: Measurement, scan: Scan, labels: Labels) -> tuple[list[Found], int]:
    """Return each labelled carton with the box that overlaps it most, and how many boxes overlap no label by half."""
    owner, found, right = owners(result.boxes, scan), [], set()
    for label in np.unique(labels[labels > 0]):
        mine = labels == label
        shares = [np.sum(mine & (owner == k)) / np.sum(mine | (owner == k)) for k in range(len(result.boxes))]
        best = int(np.argmax(shares)) if shares else None
        hit = best is not None and shares[best] >= 0.5
        found.append(Found(scan.source, int(mine.sum()), max(shares, default=0.0), result.boxes[best] if hit else None))
        right |= {best} if hit else set()
    return found, len(result.boxes) - len(right)


def _print_cartons(folder: Path) -> None:
    groups: dict[str, list[tuple[list[Found], int]]] = {"learn": [], "test": []}
    for path in sorted(folder.glob("*.npz")):
        scan, labels = carton_scene(path)
        groups["learn" if path.stem.startswith("learn") else "test"].append(matched(measure(scan), scan, labels))
    groups["all"] = groups["learn"] + groups["test"]
    rows = []
    for name, scenes in groups.items():
        large = [one for found, _ in scenes for one in found if one.area > MIN_LABEL]
        false, hits = sum(wrong for _, wrong in scenes), sum(one.box is not None for one in large)
        reported = false + sum(one.box is not None for found, _ in scenes for one in found)
        rows.append((name, len(scenes), _share(hits, len(large)), _share(reported - false, reported)))
    print("## Real cartons, touching and stacked (mOSD, 44 scenes)\n")
    print(f"A carton counts from {MIN_LABEL} labelled pixels; it is found if a box's pixels overlap its label by half. Settings")
    print("were chosen on the learn scenes.\n")
    print(markdown(("scenes", "n", "recall (95 % Wilson)", "precision"), rows))
    print(f"\nRepeated dimensions: identity is the known size within {1e3 * IDENTITY:.0f} mm in all dimensions.\n")
    print(markdown(("scenes", "carton [m]", "n", "mean [mm]", "sd [mm]", "median |deviation| [mm]"), _repeats(groups)))
    print()


def _repeats(groups: dict[str, list[tuple[list[Found], int]]]) -> list[tuple[object, ...]]:
    rows: list[tuple[object, ...]] = []
    for name, scenes in groups.items():
        pooled = []
        boxes = [one.box.dimensions for found, _ in scenes for one in found if one.box is not None]
        for carton in KNOWN:
            mine = np.array([d for d in boxes if _identity(d) == carton])
            if len(mine) < 2:
                continue
            deviation = np.abs(mine - np.median(mine, axis=0))
            pooled.append(deviation)
            mean, spread = (" x ".join(f"{1e3 * v:.1f}" for v in stat) for stat in (mine.mean(axis=0), mine.std(axis=0, ddof=1)))
            rows.append((name, carton, len(mine), mean, spread, f"{1e3 * np.median(deviation):.1f}"))
        if pooled:
            every = np.concatenate(pooled)
            rows.append((name, "together", len(every), "", "", f"{1e3 * np.median(every):.1f}"))
        rows.append((name, "no known size", sum(_identity(d) is None for d in boxes), "", "", ""))
    return rows


def _identity(dimensions: Array) -> str | None:
    name, size = min(KNOWN.items(), key=lambda item: float(np.abs(dimensions - item[1]).max()))
    return name if np.abs(dimensions - size).max() < IDENTITY else None


def _print_pallet(folder: Path) -> None:
    rows = []
    for kind, known in (("small_box", SMALL), ("medium_box", MEDIUM)):
        camera = Intrinsics(**json.loads((folder / kind / "intrinsics.json").read_text()))
        result = measure(read_scan(folder / kind / "raw_depth.png", intrinsics=camera))
        for box in result.boxes:
            x, y = np.sort(box.box.extents[:2])[::-1]
            off = np.abs(np.array([x, y]) - known).max()
            flags = ", ".join(box.flags) or "-"
            rows.append((kind, f"{x:.3f} x {y:.3f}", f"{1e3 * off:.0f}", "yes" if off <= 0.008 else "no", flags))
        rejected = ", ".join(f"{one.reason} ({one.returns})" for one in result.rejected) or "-"
        rows.append((kind, "not boxes", "", "", rejected))
    print("## A real pallet: the tops (smart_palletizer; small 0.255 x 0.155 m, medium 0.340 x 0.250 m)\n")
    print(markdown(("scene", "top [m]", "off [mm]", "within 8 mm", "flags"), rows))
    print()


def simulated(seed: int, per_kind: int) -> Iterator[tuple[str, tuple[Box, ...], Scan]]:
    """Yield scenes of several boxes: their kind, the true boxes and the scan."""
    rng = np.random.default_rng(seed)
    for kind in KINDS:
        for number in range(per_kind):
            boxes = arranged(kind, rng)
            middle = np.mean([box.centre for box in boxes], axis=0)
            pose = orbit_pose(middle, rng.uniform(0, 2 * np.pi), np.deg2rad(rng.uniform(28, 50)), rng.uniform(1.0, 1.4))
            effects = Effects().without("multipath")
            yield kind, boxes, capture(Scene(boxes), pose, CAMERA, rng=rng, effects=effects, source=f"{kind} {number}")


def arranged(kind: str, rng: np.random.Generator) -> tuple[Box, ...]:
    """Return the boxes of one scene: sides 0.12 to 0.3 m; rows differ by 3 cm or more in height or in where their fronts lie."""
    first, second, third = rng.uniform([0.15, 0.15, 0.12], [0.3, 0.3, 0.3], (3, 3))
    if kind in ("row", "near-touching"):
        gap = 0.0 if kind == "row" else rng.uniform(0.01, 0.03)
        second[2] = first[2] + rng.choice([-1, 1]) * rng.uniform(0.03, 0.09)
        shift = rng.uniform(-0.05, 0.05)
        return standing_box(first, at=(-first[0] / 2, 0.0)), standing_box(second, at=(gap + second[0] / 2, shift))
    if kind == "stack of two":
        second[:2] = first[:2] * rng.uniform(0.5, 0.9, 2)
        room = (first[:2] - second[:2]) / 2
        return standing_box(first), _raised(
            standing_box(second, yaw=rng.normal(0, 0.1), at=tuple(rng.uniform(-room, room))), first[2]
        )
    second[2] = first[2]
    third[0] = max(third[0], 0.2)
    at = (rng.uniform(-0.04, 0.04), 0.0)
    low = standing_box(first, at=(-first[0] / 2 - 0.02, 0.0)), standing_box(second, at=(second[0] / 2 + 0.02, 0.0))
    third[1] = 0.8 * min(first[1], second[1])
    return *low, _raised(standing_box(third, at=at), first[2])


def _raised(box: Box, height: float) -> Box:
    pose = box.box_to_camera.copy()
    pose[2, 3] = height
    return Box(pose, box.extents)


def _print_simulated(per_kind: int) -> None:
    rows = []
    outcomes: dict[str, list[tuple[bool, float, int, int, int]]] = {kind: [] for kind in KINDS}
    for kind, boxes, scan in simulated(SEED, per_kind):
        outcomes[kind] += compared(boxes, scan, measure(scan, camera=CAMERA))
    outcomes["all"] = [one for kind in KINDS for one in outcomes[kind]]
    for kind, group in outcomes.items():
        errors = [error for seen, error, *_ in group if seen]
        hits, total = sum(one[2] for one in group), sum(one[3] for one in group)
        false = sum(one[4] for one in group)
        recall = _share(len(errors), sum(one[3] > -1 for one in group) - sum(one[4] for one in group))
        rows.append((kind, recall, percent(float(np.median(errors))) if errors else "-", _share(hits, total), false))
    print(f"## Simulated rows and stacks (seed {SEED}, {per_kind} scenes of each kind)\n")
    print(
        "A true box is found if a measured one's centre lies within 5 cm of its own and its volume within 30 %; error is of the"
    )
    print("volume; coverage is of the 90 % intervals of the three dimensions of found boxes; false boxes match no true one.\n")
    print(markdown(("kind", "recall (95 % Wilson)", "median |error|", "coverage", "false boxes"), rows))
    print()


def compared(boxes: tuple[Box, ...], scan: Scan, result: Measurement) -> list[tuple[bool, float, int, int, int]]:
    """Return a row per true box, then one per false box.

    A row: found, relative volume error, in how many dimensions the interval holds the truth, of how many, 1 if it is a false box.
    """
    assert scan.camera_to_world is not None
    rows, used = [], set()
    for true in (box.in_frame(inverse(scan.camera_to_world)) for box in boxes):
        fits = [(abs(one.volume / true.volume - 1), k) for k, one in enumerate(result.boxes)
                if k not in used and np.linalg.norm(one.box.centre - true.centre) < 0.05
                and abs(one.volume / true.volume - 1) < 0.3]  # fmt: skip
        if not fits:
            rows.append((False, np.nan, 0, 0, 0))
            continue
        error, k = min(fits)
        used.add(k)
        along = np.abs(result.boxes[k].box.box_to_camera[:3, :3].T @ true.box_to_camera[:3, :3])
        extents = true.extents[np.argmax(along, axis=1)]
        held = sum(i.low <= x <= i.high for i, x in zip(result.boxes[k].intervals, extents, strict=True))
        rows.append((True, error, held, 3, 0))
    return rows + [(False, np.nan, 0, 0, 1)] * (len(result.boxes) - len(used))


def _share(hits: int, total: int) -> str:
    low, high = wilson(hits, total)
    return f"{hits} of {total}: {hits / max(total, 1):.3f} ({low:.2f} to {high:.2f})"

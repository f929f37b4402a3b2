"""Scans of real boxes: a folder of ``box/position/scan`` files, with sizes in ``boxes.toml``, made into the same samples."""

import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from viewgain.arrays import Pose, Poses
from viewgain.camera import sensor
from viewgain.datasets._points import kept
from viewgain.datasets._sample import UNKNOWN_DIMS, Sample
from viewgain.datasets._seeds import SCAN, SPLIT, generator
from viewgain.datasets._settings import Recipe, RecordedSettings
from viewgain.datasets._station import only_first, seen_from
from viewgain.datasets._unit import Made, Skipped, Unit
from viewgain.errors import ConfigError, ViewgainError
from viewgain.scans import Scan, read_scan

SCAN_FILES = (".ply", ".pcd", ".npz", ".npy", ".xyz", ".txt", ".csv", ".png")
"""What counts as a scan in a position's folder; hidden files and JSON beside depth images do not."""
UNNAMED = "recorded"
"""The camera of scans whose camera is not named."""
LONGEST = 10.0
"""A side of a box is shorter, metres; in millimetres it would not be."""


class RecordedMaker:
    """Reads recordings."""

    def __init__(self, recipe: Recipe, content: RecordedSettings, folder: Path | None) -> None:
        """Read nothing yet.

        Args:
            recipe: The recipe.
            content: Its table.
            folder: Where the recordings are.

        Raises:
            ConfigError: If no folder is named.
        """
        if folder is None:
            raise ConfigError(f"recipe {recipe.name} reads your own recordings; name their folder with --recordings FOLDER")
        if recipe.points.frame != "camera":
            raise ConfigError(
                f"recipe {recipe.name}: got frame {recipe.points.frame!r}, wanted 'camera': nobody knows the object's"
            )
        self._recipe, self._content, self._folder = recipe, content, folder
        self.camera = sensor(content.camera).name if content.camera else UNNAMED

    def units(self) -> Iterator[Unit]:
        """Yield one unit per position of a box, in alphabetical order.

        Raises:
            ConfigError: If there is no scan in a folder of a folder, ``boxes.toml`` is wrong or names a box without a folder, or
                the positions of two boxes are as many but called otherwise.
        """
        boxes = _folders(self._folder)
        _require_same_names(boxes)
        sizes = read_sizes(self._folder)
        unknown = sorted(set(sizes) - {box.name for box in boxes})
        if unknown:
            file = self._folder / "boxes.toml"
            raise ConfigError(f"{file}: got sizes of {', '.join(unknown)}, wanted names of folders with scans")
        apart = _kept_apart([box.name for box in boxes], sizes, self._content.test_boxes)
        number = 0
        for index, box in enumerate(boxes):
            part = "test" if box.name in apart else "train"
            for view, files in enumerate(_positions(box)):
                name = f"{box.name}/{files[0].parent.name}"
                source = (view, [str(file) for file in files], [str(each[0]) for each in _positions(box)], sizes.get(box.name))
                yield Unit(number=number, object=index, name=name, category="box", splits={"other_box": part}, source=source)
                number += 1

    def make(self, unit: Unit) -> Made:
        """Return one sample per scan file; one that cannot be read is skipped."""
        results = [result for result, _ in self.scans(unit)]
        skipped = tuple(result for result in results if isinstance(result, Skipped))
        return Made(samples=tuple(result for result in results if isinstance(result, Sample)), skipped=skipped)

    def scans(self, unit: Unit) -> Iterator[tuple[Sample | Skipped, Scan | None]]:
        """Yield each sample with its whole scan."""
        view, files, firsts, dims = unit.source
        stations = [_pose(file) for file in firsts]
        order = generator(self._recipe.seed, (unit.object, SPLIT, view, 0)).permutation(len(files))
        for number, file in enumerate(files):
            try:
                scan = read_scan(file)
            except ViewgainError as error:
                yield Skipped(unit=unit.number, name=f"{unit.name}/{Path(file).name}", reason=str(error)), None
                continue
            key = (unit.object, SCAN, view, number)
            part = "train" if order[number] < round(self._content.train_share * len(files)) else "test"
            yield self._sample(unit, scan, key, _candidates(view, scan, stations), dims, part), scan

    def _sample(
        self, unit: Unit, scan: Scan, key: tuple[int, int, int, int], candidates: Poses, dims: list[float] | None, part: str
    ) -> Sample:
        return Sample(
            points=kept(scan.points, self._recipe.points, rng=generator(self._recipe.seed, key)),
            frame="camera",
            view=key[2],
            state=only_first(len(candidates)),
            candidates=candidates,
            reachable=np.ones(len(candidates), dtype=bool),
            camera=self.camera,
            noise=np.nan,
            object=unit.object,
            category=unit.category,
            dims=UNKNOWN_DIMS if dims is None else np.array(dims),
            object_to_camera=np.full((4, 4), np.nan),
            coverage=np.nan,
            step=0,
            capture=key[3],
            seed=key,
            splits={"same_box": part, **unit.splits},
        )


def read_sizes(folder: Path) -> dict[str, list[float]]:
    """Return the three sides of each box, metres, from ``boxes.toml``: ``small = [0.306, 0.218, 0.262]``; empty without the file.

    Raises:
        ConfigError: If it cannot be read, or a value is not three lengths in metres.
    """
    path = folder / "boxes.toml"
    if not path.exists():
        return {}
    try:
        content: Mapping[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
        sizes = {name: [float(side) for side in sides] for name, sides in content.items()}
    except (OSError, ValueError, TypeError) as error:
        raise ConfigError(f"{path}: cannot be read ({error}); wanted lines like small = [0.306, 0.218, 0.262]") from error
    for name, sides in sizes.items():
        if len(sides) != 3 or not all(0 < side < LONGEST for side in sides):
            raise ConfigError(f"{path}: got {sides} for {name}, wanted three lengths over 0 and under {LONGEST:g}, in metres")
    return sizes


def _folders(folder: Path) -> list[Path]:
    try:
        boxes = sorted(each for each in folder.iterdir() if each.is_dir() and not each.name.startswith(".") and _positions(each))
    except OSError as error:
        raise ConfigError(f"{folder}: cannot be read ({error.strerror}); wanted a folder of box/position/scan files") from error
    if not boxes:
        raise ConfigError(f"{folder}: got no box/position/scan files, wanted scans two folders down ({' '.join(SCAN_FILES)})")
    return boxes


def _require_same_names(boxes: list[Path]) -> None:
    """Refuse positions with other names from box to box: their order, which is the rig's, would not be the same."""
    seen: dict[int, tuple[Path, list[str]]] = {}
    for box in boxes:
        names = [files[0].parent.name for files in _positions(box)]
        first, wanted = seen.setdefault(len(names), (box, names))
        if names != wanted:
            raise ConfigError(f"{box}: got the positions {', '.join(names)}, wanted those of {first.name}: {', '.join(wanted)}")


def _kept_apart(names: list[str], sizes: Mapping[str, list[float]], count: int) -> set[str]:
    """Return the folders of the last so many boxes. Folders of one size are one box, which two cameras have recorded."""
    alike: dict[object, list[str]] = {}
    for name in names:
        size = sizes.get(name)
        alike.setdefault(name if size is None else tuple(size), []).append(name)
    boxes = list(alike.values())
    return {name for box in boxes[max(0, len(boxes) - count) :] for name in box}


def _positions(box: Path) -> list[list[Path]]:
    """Return the scan files of each position of a box that has any."""
    positions = []
    for folder in sorted(each for each in box.iterdir() if each.is_dir() and not each.name.startswith(".")):
        files = sorted(each for each in folder.iterdir() if each.suffix.lower() in SCAN_FILES and not each.name.startswith("."))
        if files:
            positions.append(files)
    return positions


def _pose(file: str) -> Pose | None:
    """Return the pose of one scan file; None without one, or if it cannot be read."""
    try:
        return read_scan(file).camera_to_world
    except ViewgainError:
        return None


def _candidates(view: int, scan: Scan, stations: list[Pose | None]) -> Poses:
    """Return the positions, each where its first scan stood, in the present camera; NaN if any pose is not known."""
    known = [pose for pose in stations if pose is not None]
    if scan.camera_to_world is None or len(known) < len(stations):
        return np.full((len(stations), 4, 4), np.nan)
    return seen_from(view, scan.camera_to_world, np.stack(known))

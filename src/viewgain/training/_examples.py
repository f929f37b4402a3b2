"""A data set held in memory whole: clouds as half floats, scores and visited views in the order of the rig.

Thousands of small clouds fit; reading them anew for each step would cost more than the step of a small network.
"""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from viewgain.arrays import Poses
from viewgain.datasets import Dataset, Sample, rig_of
from viewgain.errors import DataError
from viewgain.geometry import inverse
from viewgain.training._settings import DataSettings

_RESIDENT = 0x7261
"""Stream of the draw of the points that are held."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Examples:
    """N samples of a rig with V views, as tensors."""

    points: Tensor
    """(N, R, 3) float16, in random order; rows after a cloud's last point are zero."""
    counts: Tensor
    """(N,) int64: points of each cloud, at most R."""
    views: Tensor
    """(N,) int64: the present view."""
    states: Tensor
    """(N, V) bool, rig order: views that were visited."""
    targets: Tensor
    """(N, V) float32, rig order: what each view is worth."""
    objects: NDArray[np.int64]
    """(N,) number of the object."""
    poses: Poses
    """(V, 4, 4) camera to object, of the first sample; NaN where the data set does not know them."""

    def __len__(self) -> int:
        return len(self.objects)

    def to(self, device: str) -> "Examples":
        """Return the same samples on a device."""
        tensors = {name: getattr(self, name).to(device) for name in ("points", "counts", "views", "states", "targets")}
        return Examples(**tensors, objects=self.objects, poses=self.poses)


def load_examples(data: Dataset, settings: DataSettings, *, views: int, seed: int) -> Examples:
    """Return the samples that a recipe learns from: those that train in each of its divisions.

    Args:
        data: The data set.
        settings: The recipe's table.
        views: V, as the network has it.
        seed: Of the draw of the points that are held.

    Raises:
        DataError: If the data is of another rig or target, has no sample that trains, or a sample without points.
        ConfigError: If there is no such division, or points are wanted in another frame and the object's pose is not known.
    """
    check_data(data, settings, views=views)
    chosen = np.arange(len(data))
    for division in settings.divisions:
        chosen = np.intersect1d(chosen, data.part(division, "train"))
    if len(chosen) == 0:
        raise DataError(f"{data.folder}: got no sample that trains in {' and '.join(settings.divisions)}; change the divisions")
    return _stacked(data, chosen, settings, views=views, seed=seed)


def check_data(data: Dataset, settings: DataSettings, *, views: int) -> None:
    """Make sure that a data set is what a recipe is for.

    Raises:
        DataError: If it is of another rig or target.
    """
    manifest = data.manifest
    rig = rig_of(manifest)
    if settings.rig and rig != settings.rig:
        raise DataError(f"{data.folder}: got data of rig {rig}, wanted {settings.rig}; name other data or another recipe")
    if settings.target not in manifest.targets:
        raise DataError(
            f"{data.folder}: got the scores {', '.join(manifest.targets) or 'none'}, wanted {settings.target}; name other data"
        )
    count = len(data[0].candidates) if len(data) else 0
    if count != views:
        raise DataError(f"{data.folder}: got data with {count} views, wanted {views}, as the network has; name other data")


def _stacked(data: Dataset, chosen: NDArray[np.intp], settings: DataSettings, *, views: int, seed: int) -> Examples:

    count, held = len(chosen), settings.resident
    points = np.zeros((count, held, 3), dtype=np.float16)
    counts, present, objects = (np.zeros(count, dtype=np.int64) for _ in range(3))
    states, targets = np.zeros((count, views), dtype=bool), np.zeros((count, views), dtype=np.float32)
    for row, index in enumerate(chosen.tolist()):
        sample = data[index].in_frame(settings.frame)
        _check_sample(data, index, sample, views)
        drawn = np.random.default_rng([seed, _RESIDENT, index]).permutation(len(sample.points))[:held]
        counts[row], present[row], objects[row] = len(drawn), sample.view, sample.object
        points[row, : len(drawn)] = sample.points[drawn]
        states[row] = np.roll(sample.state, sample.view)
        targets[row] = np.roll(sample.targets[settings.target], sample.view)
    most = int(counts.max())
    tensors = {"points": points[:, :most], "counts": counts, "views": present, "states": states, "targets": targets}
    return Examples(
        **{name: torch.from_numpy(np.ascontiguousarray(array)) for name, array in tensors.items()},
        objects=objects,
        poses=_poses(data[int(chosen[0])]),
    )


def _check_sample(data: Dataset, index: int, sample: Sample, views: int) -> None:
    if len(sample.candidates) != views:
        raise DataError(
            f"{data.folder}: sample {index} has {len(sample.candidates)} views, wanted {views} in each; name other data"
        )
    if len(sample.points) == 0 or not np.all(np.isfinite(sample.points)):
        raise DataError(f"{data.folder}: sample {index} has no points, or some that are not finite; wanted a cloud in each")


def _poses(sample: Sample) -> Poses:
    """Return (V, 4, 4) poses of the cameras in the object, rig order."""
    if not np.all(np.isfinite(sample.object_to_camera)):
        return np.full((len(sample.candidates), 4, 4), np.nan)
    camera_to_object = inverse(np.asarray(sample.object_to_camera, dtype=float))
    return np.roll(camera_to_object @ np.asarray(sample.candidates, dtype=float), sample.view, axis=0)

"""A data set held in memory whole: clouds as half floats, scores and visited views in the order of the rig.

Thousands of small clouds fit; reading them anew for each step would cost more than the step of a small network.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from viewgain.arrays import Poses
from viewgain.datasets import Dataset, Sample, rig_of, with_target
from viewgain.errors import DataError
from viewgain.geometry import inverse
from viewgain.inference import around_middle
from viewgain.training._settings import DataSettings

NEVER = -2.0
"""What a candidate is worth that is not there or cannot be reached: less than any error can cost. No loss looks at it."""
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
    candidates: Tensor | None = None
    """(N, V, 4, 4) float32 candidates in the present camera, for networks that are told; then all that belongs to views stands in
    their order, the present one first, :attr:`views` is 0, and a sample of fewer views has identities after its own."""
    valid: Tensor | None = None
    """(N, V) bool: candidates that there are and that can be reached; None for all."""

    def __len__(self) -> int:
        return len(self.objects)

    def to(self, device: str) -> "Examples":
        """Return the same samples on a device."""
        names = ("points", "counts", "views", "states", "targets", "candidates", "valid")
        held = {name: getattr(self, name) for name in names}
        tensors: dict[str, Any] = {name: None if each is None else each.to(device) for name, each in held.items()}
        return replace(self, **tensors)


def load_examples(data: Dataset, settings: DataSettings, *, views: int, seed: int, with_poses: bool = False) -> Examples:
    """Return the samples that a recipe learns from: those that train in each of its divisions.

    Args:
        data: The data set.
        settings: The recipe's table.
        views: V, as the network has it; with poses the most that a sample may have.
        seed: Of the draw of the points that are held.
        with_poses: Whether the network is told the candidates' poses.

    Raises:
        DataError: If the data is of another rig or target, has no sample that trains, or a sample without points.
        ConfigError: If there is no such division, or points are wanted in another frame and the object's pose is not known.
    """
    check_data(data, settings, views=None if with_poses else views)
    data = with_target(data, settings.target)
    chosen = np.arange(len(data))
    for division in settings.divisions:
        chosen = np.intersect1d(chosen, data.part(division, "train"))
    chosen = chosen[~np.isin(data.column("object")[chosen], settings.without)]
    if len(chosen) == 0:
        raise DataError(f"{data.folder}: got no sample that trains in {' and '.join(settings.divisions)}; change the divisions")
    return _stacked(data, chosen, settings, views=views, seed=seed, with_poses=with_poses)


def check_data(data: Dataset, settings: DataSettings, *, views: int | None) -> None:
    """Make sure that a data set is what a recipe is for.

    Raises:
        DataError: If it is of another rig or target.
    """
    manifest = data.manifest
    rig = rig_of(manifest)
    if settings.rig and rig != settings.rig:
        raise DataError(f"{data.folder}: got data of rig {rig}, wanted {settings.rig}; name other data or another recipe")
    count = len(data[0].candidates) if len(data) else 0
    if views is not None and count != views:
        raise DataError(f"{data.folder}: got data with {count} views, wanted {views}, as the network has; name other data")


def _stacked(
    data: Dataset, chosen: NDArray[np.intp], settings: DataSettings, *, views: int, seed: int, with_poses: bool
) -> Examples:
    count, held = len(chosen), settings.resident
    points = np.zeros((count, held, 3), dtype=np.float16)
    counts, present, objects = (np.zeros(count, dtype=np.int64) for _ in range(3))
    states, targets = np.zeros((count, views), dtype=bool), np.zeros((count, views), dtype=np.float32)
    valid = np.zeros((count, views), dtype=bool)
    candidates = np.tile(np.eye(4, dtype=np.float32), (count if with_poses else 0, views, 1, 1))
    for row, index in enumerate(chosen.tolist()):
        sample = data[index].in_frame(settings.frame)
        _check_sample(data, index, sample, views, at_most=with_poses)
        cloud = around_middle(sample.points, settings.within) if settings.within else sample.points
        drawn = np.random.default_rng([seed, _RESIDENT, index]).permutation(len(cloud))[:held]
        counts[row], objects[row] = len(drawn), sample.object
        points[row, : len(drawn)] = cloud[drawn]
        # A network that is told poses needs no order of the rig: candidates stay as they lie, the present one first.
        own, view = slice(len(sample.candidates)), 0 if with_poses else sample.view
        present[row] = view
        # What a box measures from here a second scan may measure better: of whole scans the present view is not used up.
        states[row, own] = np.roll(sample.state, view) & (with_poses or not settings.whole_scan)
        targets[row, own] = np.roll(sample.targets[settings.target], view)
        if with_poses:
            candidates[row, own], valid[row, own] = sample.candidates, sample.reachable
    most = int(counts.max())
    tensors = {"points": points[:, :most], "counts": counts, "views": present, "states": states, "targets": targets}
    if with_poses:
        if not np.all(np.isfinite(candidates)) or not valid.any(axis=1).all():
            raise DataError(f"{data.folder}: got a sample without poses, or without a view that can be reached; name other data")
        targets[~valid] = NEVER
        tensors |= {"candidates": candidates, "valid": valid}
    return Examples(
        **{name: torch.from_numpy(np.ascontiguousarray(array)) for name, array in tensors.items()},
        objects=objects,
        poses=_poses(data[int(chosen[0])]),
    )


def _check_sample(data: Dataset, index: int, sample: Sample, views: int, *, at_most: bool) -> None:
    count = len(sample.candidates)
    if count > views or (count < views and not at_most):
        wanted = f"at most {views}" if at_most else f"{views}"
        raise DataError(f"{data.folder}: sample {index} has {count} views, wanted {wanted} in each; name other data")
    if len(sample.points) == 0 or not np.all(np.isfinite(sample.points)):
        raise DataError(f"{data.folder}: sample {index} has no points, or some that are not finite; wanted a cloud in each")


def _poses(sample: Sample) -> Poses:
    """Return (V, 4, 4) poses of the cameras in the object, rig order."""
    if not np.all(np.isfinite(sample.object_to_camera)):
        return np.full((len(sample.candidates), 4, 4), np.nan)
    camera_to_object = inverse(np.asarray(sample.object_to_camera, dtype=float))
    return np.roll(camera_to_object @ np.asarray(sample.candidates, dtype=float), sample.view, axis=0)

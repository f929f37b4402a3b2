"""One training sample as a value. What belongs to candidates is listed with the present view first (:attr:`Sample.view`)."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array, Mask, Pose, Poses, Vector3
from viewgain.datasets._seeds import SeedKey
from viewgain.errors import ConfigError
from viewgain.geometry import inverse, transform

Frame: TypeAlias = Literal["camera", "object"]
"""Where points are given: in the present camera, as it measures them, or in the object's own frame, which it cannot know."""
UNKNOWN_DIMS = np.full(3, np.nan)
"""The side lengths of what is no box, or was never measured."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sample:
    """What a planner sees, what it is to answer, and where the sample came from."""

    points: NDArray[Any]
    """(n, 3) metres, in :attr:`frame`; of a later step, the points of all views so far. float32 once read from a data set."""
    frame: Frame
    """Where the points are given."""
    view: int
    """The present view's index in rig order. Arrays over candidates are rolled by it: entry k is candidate (view + k) mod V."""
    state: Mask
    """(V,) which candidates have been visited, the present one included."""
    candidates: Poses
    """(V, 4, 4) poses of the candidate cameras in the present camera; NaN where a recording came without poses."""
    reachable: Mask
    """(V,) whether a camera can stand there."""
    camera: str
    """Name of the camera."""
    noise: float
    """Factor on the camera's published noise; 0 for exact depth, NaN for real scans."""
    object: int
    """Number of the box or mesh in its data set."""
    category: str
    """Its category; ``box`` for boxes."""
    dims: Vector3
    """(3,) true side lengths along the object's x, y and z, metres; NaN where not known or no box."""
    object_to_camera: Pose
    """(4, 4) pose of the object's frame in the present camera; NaN where not known."""
    coverage: float
    """Share of the surface covered so far (plain union); NaN where not known."""
    step: int
    """How many views were taken before the present one."""
    capture: int
    """Which of the scans from this view, or which of the starts."""
    seed: SeedKey
    """Spawn key of the stream that drew it, under the recipe's seed; of a real scan, of what thinned its points."""
    splits: Mapping[str, str] = field(default_factory=dict)
    """The part it belongs to in each of the data set's divisions, for instance ``{"same_box": "train", "other_box": "test"}``."""
    targets: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    """(V,) scores by name."""

    def in_frame(self, frame: Frame) -> "Sample":
        """Return the same sample with its points in another frame.

        Raises:
            ConfigError: If the object's pose is not known.
        """
        if frame == self.frame:
            return self
        if not np.all(np.isfinite(self.object_to_camera)):
            raise ConfigError(f"got no pose of object {self.object}, wanted one to go from frame {self.frame} to {frame}")
        motion = self.object_to_camera if frame == "camera" else inverse(np.asarray(self.object_to_camera, dtype=float))
        points = transform(motion, np.asarray(self.points, dtype=float)).astype(self.points.dtype)
        return replace(self, points=points, frame=frame)

    def resampled(self, count: int, *, rng: np.random.Generator) -> "Sample":
        """Return the same sample with exactly ``count`` points: drawn without repetition where there are enough."""
        return replace(self, points=self.points[drawn(len(self.points), count, rng=rng)])

    def in_rig_order(self, scores: Array) -> Array:
        """Return (V,) scores of this sample in the order of the rig: ``np.roll(scores, view)``."""
        return np.roll(scores, self.view)


def drawn(total: int, count: int, *, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return (count,) sorted indices of ``total`` points, each at most once where there are enough; none of none."""
    if total == 0:
        return np.zeros(0, dtype=np.intp)
    return np.sort(rng.choice(total, count, replace=count > total))

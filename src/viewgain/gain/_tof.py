"""What a time-of-flight camera asks of a view, as terms of their own: incidence on the box's faces, and the image border.

Angle and border are those of :func:`viewgain.box.constraints`. Every term runs from 0 (bad) to 1 (good), so that it can be added
to any score with a weight (:class:`viewgain.gain.Weighted`, :class:`viewgain.gain.WithTerms`). The source paper names both
constraints and gives no formula; these are ours.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from viewgain.arrays import Array, Points2, Poses, Vector
from viewgain.box import BORDER_PX, FLOOR, Box, Constraints, box_hits, constraints, entry_mask
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError
from viewgain.gain._bits import Counts
from viewgain.geometry import inverse

IncidenceFunction: TypeAlias = Literal["cosine", "linear"]
"""What an angle of incidence is worth: its cosine, or 1 - angle / 90 degrees."""


@dataclass(frozen=True, slots=True, eq=False)
class BoxViews:
    """A box, and the candidate views of it."""

    box: Box
    """The box, in the frame that the poses lead to: the world, or the present camera."""
    cameras: Poses
    """(V, 4, 4) poses of the candidates in that frame, ``camera_to_...``."""
    camera: Intrinsics
    """What they look through."""

    def seen(self, margin: float = BORDER_PX) -> list[Constraints]:
        """Return how each view sees the box; ``margin`` is how near the border counts as on it, pixels."""
        return [
            constraints(self.box.in_frame(inverse(pose)), self._to_pixels, (self.camera.width, self.camera.height), margin)
            for pose in self.cameras
        ]

    def face_pixels(self) -> Counts:
        """Return the (V, 5) number of pixels whose centre sees each face (the order of ``viewgain.box.FACES``)."""
        rays = self.camera.directions().reshape(-1, 3)
        return np.stack([_face_pixels(self.box.in_frame(inverse(pose)), rays) for pose in self.cameras])

    def _to_pixels(self, image: Points2) -> Points2:
        return self.camera.project(np.column_stack([image, np.ones(len(image))]))


@dataclass(frozen=True, slots=True)
class IncidenceTerm:
    """How squarely the faces are seen: sum over faces of pixels x g(angle) / sum over faces of pixels."""

    function: IncidenceFunction = "cosine"
    """g, of the angle at the face's centre."""

    def __post_init__(self) -> None:
        if self.function not in ("cosine", "linear"):
            raise ConfigError(f"incidence term: got the function {self.function!r}, wanted 'cosine' or 'linear'")

    @property
    def name(self) -> str:
        """Says the function."""
        return f"incidence_{self.function}"

    def gains(self, known: BoxViews) -> Vector:
        """Return the (V,) terms; 0 where no pixel sees the box."""
        pixels = known.face_pixels()
        angles = np.stack([seen.incidence for seen in known.seen()])
        worth = np.where(pixels > 0, self._of(angles), 0.0)  # a face without a pixel may be turned away: NaN
        return np.asarray((pixels * worth).sum(axis=1) / np.maximum(pixels.sum(axis=1), 1))

    def _of(self, angles: Array) -> Array:
        return np.cos(angles) if self.function == "cosine" else 1 - angles / (np.pi / 2)


@dataclass(frozen=True, slots=True)
class BorderTerm:
    """How well the box lies in the image: 1 - share of its silhouette's length within ``margin`` of the border, or beyond it."""

    margin: float = BORDER_PX
    """k, pixels."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.margin) and self.margin >= 0):
            raise ConfigError(f"border term: got a margin of {self.margin} pixels, wanted 0 or more")

    @property
    def name(self) -> str:
        """Says the margin."""
        return f"border_{self.margin:g}px"

    def gains(self, known: BoxViews) -> Vector:
        """Return the (V,) terms; 0 where the box reaches behind the camera."""
        return np.array([1 - seen.border for seen in known.seen(self.margin)])


def _face_pixels(box: Box, rays: Array) -> Counts:
    """Return the (5,) number of (n, 3) unit rays that meet each face of a box in the camera's frame."""
    hits = box_hits(box, rays)
    met = entry_mask(box, rays) & np.isfinite(hits.ranges)
    return np.bincount(hits.planes[met], minlength=FLOOR)[:FLOOR]

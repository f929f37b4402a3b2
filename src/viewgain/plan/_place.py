"""Where the box stands, as far as the rig says: whoever put up a rig put it up around something (ours).

The stations of most rigs look at one point. If they were put up around the box, that point is the box's centre, about; half of a
side that no scan shows lies between it and the face that is seen.
"""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Points, Pose, Poses, Vector, Vector3
from viewgain.errors import ConfigError
from viewgain.geometry import transform

AROUND = 0.1
"""How exactly a box stands in the middle of a rig that is put up around it, standard deviation per axis, metres."""
LEAST_SIGMA, FARTHEST = 1e-4, 1e4
"""No place is known better, and none is farther from the origin, metres."""
MOST_APART = 0.05
"""Optical axes that pass the point farther than this on the average, metres, do not look at it."""
_ACROSS = np.sin(np.deg2rad(5.0)) ** 2
"""Axes that are more nearly parallel than this (mean square of the sine) meet nowhere that could be told."""


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """Where the centre of a box is, before anything is measured; ConfigError if that makes no sense."""

    centre: Vector3
    """(3,) metres."""
    sigma: float
    """Standard deviation per axis, metres, ``LEAST_SIGMA`` or more."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", np.asarray(self.centre, dtype=float))
        if self.centre.shape != (3,) or not (np.abs(self.centre) <= FARTHEST).all():
            raise ConfigError(f"place: got a centre of {self.centre.tolist()}, wanted three numbers of {FARTHEST:g} m at most")
        if not LEAST_SIGMA <= self.sigma < np.inf:
            raise ConfigError(f"place: got a standard deviation of {self.sigma} m, wanted {LEAST_SIGMA:g} m or more")

    def in_frame(self, frame_to_other: Pose) -> "Place":
        """Return the same place in another frame."""
        return Place(transform(frame_to_other, self.centre), self.sigma)

    def log_odds(self, centres: Points) -> Vector:
        """Return (n,) log densities of (n, 3) centres, up to a constant."""
        return np.asarray(-0.5 * np.sum(((centres - self.centre) / self.sigma) ** 2, axis=1))


def place_amid(cameras: Poses, sigma: float) -> Place | None:
    """Return the place of a box that (v, 4, 4) cameras were put up around, to so much; None where they look at no one point."""
    centre = looked_at(cameras)
    return None if centre is None else Place(centre, sigma)


def looked_at(cameras: Poses) -> Vector3 | None:
    """Return the (3,) point that lies nearest to the optical axes of (v, 4, 4) cameras, least squares; in their common frame.

    None where there is no such point: of fewer than two cameras, of parallel axes, of axes that pass each other, and where it
    lies behind a camera.
    """
    origins, axes = cameras[:, :3, 3], cameras[:, :3, 2]
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]  # (v, 3, 3) what is left of a vector beside each axis
    if len(cameras) < 2 or np.linalg.eigvalsh(across.mean(axis=0))[0] < _ACROSS:
        return None
    point = np.linalg.solve(across.sum(axis=0), np.einsum("vij,vj->i", across, origins))
    apart = np.linalg.norm(np.einsum("vij,vj->vi", across, point - origins), axis=1)
    ahead = np.einsum("vi,vi->v", axes, point - origins)
    return point if apart.mean() <= MOST_APART and (ahead > 0).all() else None

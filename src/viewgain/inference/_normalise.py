"""From a cloud of any place and size to the one that a network knows: by the rule on its card."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Points, Rotation, Vector3
from viewgain.errors import ConfigError, ScanError
from viewgain.geometry import rotation_from_rotvec
from viewgain.inference._card import ModelCard, Sampling

SLACK = 1.1
"""A cloud said to be normalised may reach this much beyond the sphere around its box."""
_AHEAD = 9
"""Points about the camera's axis, of which the middle one counts: one alone may fly between two surfaces."""


@dataclass(frozen=True, slots=True, eq=False)
class Bounds:
    """The bounding box that sets centre and scale."""

    centre: Vector3
    """(3,) its centre, in the frame of the points, in their unit."""
    diagonal: float
    """Its diagonal, in the unit of the points."""

    def __post_init__(self) -> None:
        if np.shape(self.centre) != (3,) or not np.all(np.isfinite(self.centre)) or not 0 < self.diagonal < np.inf:
            raise ConfigError(
                f"bounds: got centre {self.centre} and diagonal {self.diagonal}, wanted three numbers and a positive one"
            )


def bounds_of(points: Points) -> Bounds:
    """Return the axis-aligned bounding box of (n, 3) points; of a single place, diagonal 1.

    Raises:
        ScanError: If there are no points.
    """
    if len(points) == 0:
        raise ScanError("network: got no points, wanted a cloud of the object")
    low, high = points.min(axis=0), points.max(axis=0)
    return Bounds((low + high) / 2, float(np.linalg.norm(high - low)) or 1.0)


def normalised(points: Points, card: ModelCard, bounds: Bounds | None = None) -> Points:
    """Return (n, 3) points as the network knows them.

    Args:
        points: (n, 3) the object without its floor, in the card's frame, in any unit.
        card: The rule.
        bounds: Box of the whole object, for the rule ``whole_box``; None says that the points are normalised already. The rule
            ``seen_box`` makes its own.

    Raises:
        ScanError: If there are no points.
        ConfigError: If the points are said to be normalised and reach too far.
    """
    if card.normalisation == "metres":
        if len(points) == 0:
            raise ScanError("network: got no points, wanted a scan")
        return around_middle(points, card.within) if card.within else points
    if card.normalisation == "seen_box":
        bounds = bounds_of(points)
    if bounds is None:
        return _as_given(points, card)
    centred = (points - bounds.centre) / bounds.diagonal
    if card.frame == "object":
        return centred
    return np.asarray(centred @ _onto_axis(bounds.centre).T + [0.0, 0.0, card.distance])


def around_middle(points: Points, within: float) -> Points:
    """Return those of (n, 3) points of a whole scan that lie near what the camera looks at; one at least where there are any.

    It looks at the middle one of the nine points nearest to its axis (ours). The published estimator of volumes, too, takes only
    what lies about the middle of the image (docs/lines.md). Of a box that fills little of it, that leaves more points on the box.

    Args:
        points: (n, 3) metres, camera frame, in any order; of none, none are returned.
        within: Greatest distance from there, metres, over 0.
    """
    if len(points) == 0:
        return points
    cosine = points[:, 2] / np.maximum(np.linalg.norm(points, axis=1), 1e-12)
    ahead = points[np.argsort(-cosine, kind="stable")[:_AHEAD]]
    middle = ahead[np.argmin(np.linalg.norm(ahead - np.median(ahead, axis=0), axis=1))]
    return np.asarray(points[np.linalg.norm(points - middle, axis=1) <= within])


def _as_given(points: Points, card: ModelCard) -> Points:
    middle = np.array([0.0, 0.0, card.distance if card.frame == "camera" else 0.0])
    reach = float(np.linalg.norm(points - middle, axis=1).max(initial=0.0))
    if reach > 0.5 * SLACK:
        raise ConfigError(
            f"network {card.name}: got points up to {reach:.3g} from {middle.tolist()}, wanted a normalised cloud (its box there,"
            " of diagonal 1); give the bounds of the whole object"
        )
    return points


def _onto_axis(centre: Vector3) -> Rotation:
    """Return the least turn of the camera that looks at a point: it takes the point's direction to the axis z."""
    direction = centre / max(float(np.linalg.norm(centre)), 1e-12)
    axis = np.cross(direction, [0.0, 0.0, 1.0])
    sine, cosine = float(np.linalg.norm(axis)), float(direction[2])
    return rotation_from_rotvec(axis / max(sine, 1e-12) * np.arctan2(sine, cosine))


def checked(points: Points, card: ModelCard) -> Points:
    """Return (n, 3) points as numbers.

    Raises:
        ScanError: If there are none, or some are not finite.
    """
    cloud = np.asarray(points, dtype=float)
    if cloud.ndim != 2 or cloud.shape[1] != 3 or len(cloud) == 0 or not np.all(np.isfinite(cloud)):
        raise ScanError(f"network {card.name}: got points {cloud.shape}, wanted (n, 3) finite ones, n of 1 or more")
    return cloud


def padded(points: NDArray[Any], card: ModelCard, *, rng: np.random.Generator) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Return (1, N, 3) points and (1, N) which are real, N as the card says: thinned where there are more, padded where fewer."""
    kept = points[thinned(points, card.points, card.sampling, rng=rng)]
    cloud = np.zeros((1, card.points, 3), dtype=np.float32)
    cloud[0, : len(kept)] = kept
    return cloud, np.arange(card.points)[None] < len(kept)


def thinned(points: NDArray[Any], count: int, sampling: Sampling, *, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return the sorted indices of at most ``count`` of (n, 3) points, no place twice.

    Args:
        points: (n, 3) points.
        count: Most points to keep.
        sampling: ``random``, as the networks are trained; or ``farthest``: from a random first point, always the one farthest
            from all taken so far.
        rng: Draws.
    """
    places = np.sort(np.unique(points, axis=0, return_index=True)[1])
    if len(places) <= count:
        return places
    if sampling == "random":
        return np.sort(rng.choice(places, count, replace=False))
    return np.sort(places[_farthest(points[places], count, int(rng.integers(len(places))))])


def _farthest(points: NDArray[Any], count: int, first: int) -> NDArray[np.intp]:
    taken = np.empty(count, dtype=np.intp)
    taken[0], apart = first, np.full(len(points), np.inf)
    for k in range(1, count):
        np.minimum(apart, np.square(points - points[taken[k - 1]]).sum(axis=1), out=apart)
        taken[k] = int(np.argmax(apart))
    return taken

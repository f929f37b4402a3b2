"""What stands on the floor, whatever its shape: returns above the floor, cleaned of mixed pixels, grouped by their footprint.

Boxes are split at range jumps; a chair would fall into legs, seat and back. Here an object is what hangs together as seen from
above: returns whose footprints on the floor lie within a few centimetres of each other (ours). Parcels that touch are one.
"""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from viewgain.arrays import Array, Image, Mask, Points, Pose
from viewgain.camera import Sensor
from viewgain.geometry import floor_to_camera, inverse, transform
from viewgain.measure import Floor, RangeImage

MIN_PIXELS = 60
"""An object with fewer returns is not measured."""
MAX_OBJECTS = 12
"""At most this many objects of a scan are measured, the largest."""
CELL = 0.02
"""Side of a cell of the floor grid in which footprints are joined, metres; at least twice the distance of neighbouring pixels."""
_LOWEST, _HIGHEST = 0.015, 0.04
_SUPPORT = 3
_HALF_WINDOW = 2
_EIGHT = np.ones((3, 3), dtype=bool)


@dataclass(frozen=True, slots=True, eq=False)
class SeenObject:
    """The returns of one object on the floor."""

    mask: Mask
    """(h, w) its pixels."""
    points: Points
    """(n, 3) its returns, smoothed, in the floor's frame: z up from the floor, the camera above the origin, metres."""
    shadow: Points
    """(n, 3) where the rays of these pixels would meet the floor, or end at the reach of the scan; floor frame."""
    pitch: float
    """Distance between neighbouring returns across the line of sight, metres."""
    sigma: float
    """Noise of one return, metres."""
    floor_frame: Pose
    """(4, 4) floor_to_camera."""
    border: float
    """Share of the object's outline that lies on the border of the image."""
    hidden: float
    """Share of its outline where something nearer stands in front of it."""


def find_objects(image: RangeImage, floor: Floor, sensor: Sensor) -> list[SeenObject]:
    """Return what stands on the floor, largest in the image first; empty if nothing does.

    Returns lower than four spreads of the floor, at least 1.5 and at most 4 cm, belong to the floor. A return counts if three of
    its eight neighbours have nearly its range; mixed pixels between an object and what lies behind rarely do.
    """
    frame = floor_to_camera(floor.plane)
    heights = floor.plane.height(image.points)
    sigma = floor.noise * _sigma(image, sensor)
    with np.errstate(invalid="ignore"):
        above = image.valid & (heights > max(_LOWEST, min(4 * floor.spread, _HIGHEST)))
    above &= _supported(image.ranges, above, sigma)
    if above.sum() < MIN_PIXELS:
        return []
    local = transform(inverse(frame), image.points[above])
    labels = np.zeros(above.shape, dtype=np.intp)
    labels[above] = _joined(local[:, :2], max(CELL, 2 * image.pitch * float(np.median(image.ranges[above]))))
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    chosen = [k for k in np.argsort(-sizes, kind="stable")[:MAX_OBJECTS] if sizes[k] >= MIN_PIXELS]
    return [_seen(image, labels == k, above, sigma, frame) for k in chosen]


def _seen(image: RangeImage, mask: Mask, above: Mask, sigma: Image, frame: Pose) -> SeenObject:
    smooth = smoothed(image, mask)
    rays, camera = image.directions[mask], inverse(frame)
    points = transform(camera, rays * smooth[:, None])
    distance = float(np.median(smooth))
    return SeenObject(
        mask=mask,
        points=points,
        shadow=_shadow(points, camera[:3, 3], float(np.nanquantile(image.ranges[::4, ::4], 0.995))),
        pitch=image.pitch * distance,
        sigma=float(np.median(sigma[mask])),
        floor_frame=frame,
        border=_on_border(mask, image),
        hidden=_behind(mask, above, image.ranges),
    )


def smoothed(image: RangeImage, mask: Mask) -> Array:
    """Return the (n,) ranges of the pixels in ``mask``, each from a plane through the object's pixels in a 5 x 5 window.

    A plane's inverse depth is linear in normalised image coordinates, so this is a linear fit; the noise of a pixel with all its
    neighbours falls to a fifth and its place in the outline stays. Pixels with too few neighbours keep their own range.
    """
    depth = np.where(mask, 1 / np.maximum(image.ranges * image.directions[..., 2], 1e-6), 0.0)
    weight, (v, u) = mask.astype(float), np.indices(mask.shape) - np.array(mask.shape)[:, None, None] / 2
    n, su, sv, suu, suv, svv, s, sus, svs = (
        _window(weight * term) for term in (1.0, u, v, u * u, u * v, v * v, depth, u * depth, v * depth)
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        mu, mv, mean = su / n, sv / n, s / n
        cuu, cuv, cvv = suu / n - mu * mu, suv / n - mu * mv, svv / n - mv * mv
        cus, cvs = sus / n - mu * mean, svs / n - mv * mean
        determinant = cuu * cvv - cuv**2
        fit = mean + ((u - mu) * (cvv * cus - cuv * cvs) + (v - mv) * (cuu * cvs - cuv * cus)) / determinant
    own = image.ranges[mask]
    ranges = 1 / (fit[mask] * image.directions[mask][:, 2])
    sound = (n[mask] > 5.5) & (determinant[mask] > 0.1) & (np.abs(ranges - own) < 0.1 * own)
    return np.where(sound, ranges, own)


def _window(values: Image) -> Image:
    size = 2 * _HALF_WINDOW + 1
    return np.asarray(ndimage.uniform_filter(values, size, mode="constant") * size**2)


def _sigma(image: RangeImage, sensor: Sensor) -> Image:
    """Return the (h, w) noise of a return at 45 degrees of incidence, metres; NaN where nothing came back."""
    return np.asarray(sensor.range_sigma(image.ranges, np.full(image.ranges.shape, np.sqrt(0.5))))


def _supported(ranges: Image, above: Mask, sigma: Image) -> Mask:
    """Return the (h, w) mask of returns with at least three neighbours within 1 cm and four sigma, all above the floor."""
    padded = np.pad(np.where(above, ranges, np.nan), 1, constant_values=np.nan)
    near = np.zeros(ranges.shape)
    height, width = ranges.shape
    for row, column in ((0, 0), (0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1), (2, 2)):
        with np.errstate(invalid="ignore"):
            near += np.abs(padded[row : row + height, column : column + width] - ranges) < 0.01 + 4 * sigma
    return np.asarray(near >= _SUPPORT)


def _joined(footprint: Array, cell: float) -> Array:
    """Return the (n,) labels, from 1, of (n, 2) floor points: cells with two of them or more, grown by one cell, that touch."""
    cells = np.floor((footprint - footprint.min(axis=0)) / cell).astype(int)
    cells = np.minimum(cells, 2000) + 2
    counts = np.zeros(tuple(cells.max(axis=0) + 3))
    np.add.at(counts, (cells[:, 0], cells[:, 1]), 1)
    grown = ndimage.binary_dilation(counts >= 2, _EIGHT)
    labels, _ = ndimage.label(grown, _EIGHT)
    return np.asarray(labels[cells[:, 0], cells[:, 1]])


def _shadow(points: Points, camera: Array, reach: float) -> Points:
    """Return where the rays from the camera through (n, 3) points meet the floor z = 0, or come to the reach of the scan."""
    rays = points - camera
    distance = np.linalg.norm(rays, axis=1)
    drop = np.maximum(-rays[:, 2], 1e-9)
    factor = np.minimum(camera[2] / drop, np.maximum(reach / distance, 1.0))
    return np.asarray(camera + rays * factor[:, None])


def _rim(mask: Mask) -> Mask:
    """Return the (h, w) pixels of the object that have a neighbour, or the image's border, beside them."""
    return np.asarray(mask & ~ndimage.binary_erosion(mask, _EIGHT))


def _on_border(mask: Mask, image: RangeImage) -> float:
    """Return the share of the object's rim within two pixels of the image's border (of an unorganised cloud's bounds)."""
    rim = _rim(mask)
    inner = np.zeros(mask.shape, dtype=bool)
    inner[2:-2, 2:-2] = True
    return float((rim & ~inner).sum() / max(rim.sum(), 1))


def _behind(mask: Mask, above: Mask, ranges: Image) -> float:
    """Return the share of the object's rim within three pixels of another object that is more than 3 cm nearer."""
    rim = _rim(mask)
    other = np.where(above & ~mask, ranges, np.inf)
    nearest = ndimage.minimum_filter(other, 7)
    return float((nearest[rim] < ranges[rim] - 0.03).sum() / max(rim.sum(), 1))

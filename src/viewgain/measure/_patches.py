"""The flat patches of what stands on the floor: which pixels see one plane, lying or upright.

A plane a X + b Y + c Z = 1 has the inverse depth a x + b y + c at the image point (x, y), so a plane through any window is three
numbers by linear least squares on box sums. Each pixel takes the best-fitting of nine windows around it, which keeps creases
and steps sharp; neighbours whose planes agree are linked (ours).
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from viewgain.arrays import Array, Image, Indices, Mask, Points, Vector3
from viewgain.camera import Sensor
from viewgain.measure._floor import Floor
from viewgain.measure._range_image import RangeImage

_UPRIGHT = np.sin(np.deg2rad(25.0))
_LYING = np.cos(np.deg2rad(25.0))
_SAME_NORMAL = np.cos(np.deg2rad(20.0))
_TILT_TARGET = np.deg2rad(7.0)
_MIN_PATCH = 30
_MIN_SHARE = 0.35
_PREFER_CENTRE = 0.7
_SURE = 3.0
_TURN = np.deg2rad(15.0)
_SAG = 0.003
_ALL = slice(None)
_NEIGHBOURS = (((_ALL, slice(None, -1)), (_ALL, slice(1, None))), ((slice(None, -1), _ALL), (slice(1, None), _ALL)))


class Facing(Enum):
    """How a patch lies to the floor."""

    LYING = 1
    """Parallel to the floor: a top."""
    UPRIGHT = 2
    """At a right angle to it: a side."""
    TILTED = 3
    """Neither."""


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """The pixels that see one plane."""

    pixels: Indices
    """(n,) row-major pixel indices into the image."""
    points: Points
    """(n, 3) points in the frame of the floor: z is the height."""
    normal: Vector3
    """(3,) unit normal towards the camera, frame of the floor."""
    offset: float
    """normal . x = offset on the plane, metres."""
    facing: Facing
    """Lying, upright or tilted."""

    def beyond(self, points: Points) -> Array:
        """Return the (n,) signed distance of points in the frame of the floor to the plane, positive on the camera's side."""
        return np.asarray(points @ self.normal - self.offset)

    def is_curved(self) -> bool:
        """Return whether its points surely bend like a ball, a can or a bag: its normal turns by over 15 degrees.

        The least-squares quadric over the plane, trimmed once; its stronger principal curvature must pass by three of its own
        standard deviations, and the bulge be 3 mm deep. Walls of real cartons bulge by up to 12 degrees (ours).
        """
        across = np.linalg.svd(self.normal[None])[2][1:]
        kept = self.points[:: max(1, len(self.points) // 3000)]
        flat = (kept - kept.mean(axis=0)) @ across.T
        scale = float(flat.std(axis=0).max())
        x, y = flat.T / scale
        terms = np.column_stack([x * x / 2, x * y, y * y / 2, x, y, np.ones(len(x))])
        bend, sigma = _trimmed_quadric(terms, self.beyond(kept))
        strength, directions = np.linalg.eigh([[bend[0], bend[1]], [bend[1], bend[2]]])
        strongest = int(np.argmax(np.abs(strength)))
        surely = (abs(strength[strongest]) - _SURE * sigma) / scale**2
        length = float(np.ptp(np.quantile(flat @ directions[:, strongest], [0.03, 0.97])))
        return bool(surely * length > _TURN and surely * length**2 / 8 > _SAG)

    @property
    def height(self) -> float:
        """Median height of its points above the floor, metres."""
        return float(np.median(self.points[:, 2]))


@dataclass(frozen=True, slots=True, eq=False)
class _Planes:
    """A plane per pixel of a window of the image."""

    coefficients: Array
    """(h, w, 3): a, b, c."""
    variance: Image
    """(h, w) mean squared residual of the inverse depth; inf where too few pixels lie around."""


def patches(image: RangeImage, mask: Mask, floor: Floor, sensor: Sensor, placing: Array) -> list[Patch]:
    """Return the flat patches among the pixels of ``mask``, largest first; none where none has 30 pixels.

    Args:
        image: The scan.
        mask: (h, w) pixels of the objects.
        floor: The floor, for its noise and up direction.
        sensor: Its noise model.
        placing: (4, 4) pose of the floor's frame in the camera's.
    """
    if mask.sum() < _MIN_PATCH:
        return []
    window = ndimage.find_objects(mask.astype(np.int8))[0]
    inside = mask[window]
    sigma = floor.noise * sensor.range_sigma(image.ranges[window], np.full(inside.shape, 0.7))
    half = _half_window(image, mask, float(np.median(sigma[inside])))
    rays = image.directions[window]
    inverse = np.where(inside, 1 / (image.ranges[window] * rays[..., 2]), 0.0)
    at = np.concatenate([rays[..., :2] / rays[..., 2:], np.ones((*inside.shape, 1))], axis=-1)
    planes = _sharpest(_window_planes(inverse, at, inside, half), half)
    labels, facing = _linked(planes, at, inside, placing, sigma / half)
    labels, count = _solid(labels, facing, half)
    labels = _grown(labels, count, inverse, at, inside, sigma, half)
    rows, columns = np.nonzero(labels)
    pixels = (rows + window[0].start) * image.ranges.shape[1] + columns + window[1].start
    label = labels[rows, columns]
    points = (image.points.reshape(-1, 3)[pixels] - placing[:3, 3]) @ placing[:3, :3]
    large = [k for k in range(1, count + 1) if np.sum(label == k) >= _MIN_PATCH]
    found = [_patch(pixels[label == k], points[label == k], placing) for k in large]
    return sorted(found, key=lambda patch: -len(patch.pixels))


def _half_window(image: RangeImage, mask: Mask, sigma: float) -> int:
    """Return half the window at which noise tilts a local plane by 7 degrees: tilt = sigma / pixel * sqrt(12) / side^2."""
    pixel = image.pitch * float(np.median(image.ranges[mask]))
    return int(np.clip(np.sqrt(sigma / pixel * np.sqrt(12) / _TILT_TARGET) / 2, 2, 5))


def _window_planes(inverse: Image, at: Array, inside: Mask, half: int) -> _Planes:
    """Return the least-squares plane through the window around each pixel."""
    weight = inside.astype(float)
    middle = at[inside].mean(axis=0) * (1, 1, 0)
    scale = np.maximum(at[inside].std(axis=0), 1e-6) * (1, 1, 0) + (0, 0, 1)
    basis = (at - middle) / scale

    def total(values: Image) -> Image:
        return np.asarray(ndimage.uniform_filter(values * weight, 2 * half + 1, mode="constant"))

    gram = np.empty((*inside.shape, 3, 3))
    for i in range(3):
        for j in range(i, 3):
            gram[..., i, j] = gram[..., j, i] = total(basis[..., i] * basis[..., j])
    right = np.stack([total(basis[..., i] * inverse) for i in range(3)], axis=-1)
    count = gram[..., 2, 2]
    usable = inside & (count > _MIN_SHARE) & (np.linalg.det(gram) > 1e-12)
    gram[~usable] = np.eye(3)
    solved = np.linalg.solve(gram, right[..., None])[..., 0]
    residual = total(inverse**2) - np.sum(solved * right, axis=-1)
    variance = np.where(usable, np.maximum(residual, 1e-15) / np.maximum(count - 3 / (2 * half + 1) ** 2, 1e-3), np.inf)
    coefficients = solved / scale
    coefficients[..., 2] -= coefficients @ middle
    return _Planes(coefficients, variance)


def _sharpest(planes: _Planes, half: int) -> _Planes:
    """Return for each pixel the best-fitting plane of the nine windows around it, its own preferred by 30 %."""
    best, variance = planes.coefficients.copy(), planes.variance * _PREFER_CENTRE
    for down in (-half, 0, half):
        for across in (-half, 0, half):
            moved = _shifted(planes.variance, down, across, np.inf)
            better = moved < variance
            variance = np.where(better, moved, variance)
            best[better] = _shifted(planes.coefficients, down, across, 0.0)[better]
    return _Planes(best, variance)


def _shifted(values: Array, down: int, across: int, fill: float) -> Array:
    """Return ``values`` moved so that pixel (i, j) holds what was at (i + down, j + across)."""
    moved = np.full_like(values, fill)
    height, width = values.shape[:2]
    to_rows, to_columns = (slice(max(-s, 0), n - max(s, 0)) for s, n in ((down, height), (across, width)))
    from_rows, from_columns = (slice(max(s, 0), n - max(-s, 0)) for s, n in ((down, height), (across, width)))
    moved[to_rows, to_columns] = values[from_rows, from_columns]
    return moved


def _linked(planes: _Planes, at: Array, inside: Mask, placing: Array, sigma: Image) -> tuple[Indices, Indices]:
    """Return (h, w) labels of connected pixels whose planes agree in tilt and place, and the facing of each pixel."""
    length = np.linalg.norm(planes.coefficients, axis=-1)
    normal = -planes.coefficients / np.maximum(length, 1e-12)[..., None]
    facing = _sorted_by_yaw(normal, _facing(normal @ placing[:3, 2]), inside, placing)
    own = np.sum(planes.coefficients * at, axis=-1)
    usable = inside & np.isfinite(planes.variance) & (own > 0)
    index = np.arange(inside.size).reshape(inside.shape)
    pairs = []
    for first, second in _NEIGHBOURS:
        alike = np.sum(normal[first] * normal[second], axis=-1) > _SAME_NORMAL
        other = np.sum(planes.coefficients[second] * at[first], axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            near = np.abs(1 / own[first] - 1 / other) < 0.002 + sigma[first]
        joined = usable[first] & usable[second] & alike & near & (facing[first] == facing[second])
        pairs.append(np.stack([index[first][joined], index[second][joined]]))
    row, column = np.concatenate(pairs, axis=1)
    graph = coo_matrix((np.ones(len(row), dtype=bool), (row, column)), shape=(inside.size, inside.size))
    _, component = connected_components(graph, directed=False)
    return component.reshape(inside.shape), np.where(usable, facing, 0)


def _sorted_by_yaw(normal: Array, facing: Indices, inside: Mask, placing: Array) -> Indices:
    """Return the facings with upright pixels numbered from 10 by the peak of the histogram of yaws that they belong to.

    An upright pixel over 20 degrees from every peak is tilted: round a corner the windows turn from one side to the other.
    """
    level = normal @ placing[:3, :2]
    yaw = np.rad2deg(np.arctan2(level[..., 1], level[..., 0])) % 360
    upright = inside & (facing == Facing.UPRIGHT.value)
    counts = ndimage.uniform_filter1d(np.histogram(yaw[upright], 72, (0, 360))[0].astype(float), 3, mode="wrap")
    peaks = np.flatnonzero((counts == ndimage.maximum_filter1d(counts, 9, mode="wrap")) & (3 * counts > _MIN_PATCH))
    if len(peaks) == 0:
        return np.where(upright, Facing.TILTED.value, facing)
    apart = np.abs((yaw[..., None] - (peaks * 5 + 2.5) + 180) % 360 - 180)
    nearest = np.argmin(apart, axis=-1)
    named = np.where(apart.min(axis=-1) < 20, nearest + 10, Facing.TILTED.value)
    return np.where(facing == Facing.UPRIGHT.value, named, facing)


def _solid(component: Indices, facing: Indices, half: int) -> tuple[Indices, int]:
    """Return labels 1 to n of the patches that are large enough, and n.

    A tilted patch must be wider than the window: along creases and steps the windows themselves make narrow tilted strips.
    """
    rank = np.zeros(component.max() + 1, dtype=np.intp)
    sizes = np.bincount(component.ravel())
    count = 0
    for k in np.flatnonzero(sizes >= _MIN_PATCH):
        mine = component == k
        if facing[mine][0] == Facing.TILTED.value:
            wide = ndimage.binary_erosion(mine, np.ones((2 * half + 1,) * 2)).sum() >= _MIN_PATCH
            if not wide:
                continue
        count += 1
        rank[k] = count
    return rank[component], count


def _facing(upness: Array) -> Indices:
    """Return the facing of surfaces from the cosine between their normals and up."""
    steep = np.where(np.abs(upness) < _UPRIGHT, Facing.UPRIGHT.value, Facing.TILTED.value)
    return np.where(upness > _LYING, Facing.LYING.value, steep)


def _grown(labels: Indices, count: int, inverse: Image, at: Array, inside: Mask, sigma: Image, half: int) -> Indices:
    """Return the labels after each pixel near a patch has gone to the one whose plane fits it best, within three sigma."""
    best = np.full(labels.shape, np.inf)
    grown = np.zeros_like(labels)
    for k, window in enumerate(ndimage.find_objects(labels, count), start=1):
        near = tuple(slice(max(s.start - 2 * half - 1, 0), s.stop + 2 * half + 1) for s in window)
        mine = labels[near] == k
        fit = np.linalg.lstsq(at[near][mine], inverse[near][mine], rcond=None)[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            apart = np.abs(1 / (at[near] @ fit) - 1 / inverse[near]) / (0.002 + 3 * sigma[near])
        apart = np.where(mine, np.minimum(apart, 1.0) * 0.5, apart)
        reach = ndimage.binary_dilation(mine, iterations=2 * half + 1)
        take = reach & inside[near] & (apart <= 1) & (apart < best[near])
        grown[near][take] = k
        best[near][take] = apart[take]
    return grown


def _patch(pixels: Indices, points: Points, placing: Array) -> Patch:
    """Return the patch with the plane of least squares through its points, of 5 % trimmed once."""
    kept = points
    for _ in range(2):
        middle = kept.mean(axis=0)
        normal = np.linalg.svd(kept[:: max(1, len(kept) // 2000)] - middle, full_matrices=False)[2][2]
        distance = np.abs((points - middle) @ normal)
        kept = points[distance <= np.quantile(distance, 0.95)]
    camera = -placing[:3, :3].T @ placing[:3, 3]
    if (camera - middle) @ normal < 0:
        normal = -normal
    return Patch(pixels, points, normal, float(normal @ middle), Facing(int(_facing(normal[2]))))


def _trimmed_quadric(terms: Array, away: Array) -> tuple[Array, float]:
    """Return the (3,) second-order coefficients of least squares on (n, 6) terms, trimmed once, and their largest deviation."""
    for _ in range(2):
        fit = np.linalg.lstsq(terms, away, rcond=None)[0]
        off = np.abs(away - terms @ fit)
        inside = off <= max(3 * 1.4826 * float(np.median(off)), 1e-6)
        terms, away = terms[inside], away[inside]
    variance = np.diag(np.linalg.pinv(terms.T @ terms))[:3].max()
    return np.asarray(fit[:3]), float(np.std(away - terms @ fit) * np.sqrt(variance))

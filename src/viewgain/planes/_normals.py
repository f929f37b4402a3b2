"""Normals by principal component analysis of the ball around each point, oriented towards the camera.

The ball's zeroth, first and second moments are all that is needed: ten sums per point. In an image they are gathered by shifting
the whole image over itself, once per offset of the window, and adding where the shifted point lies in the ball; in an unorganised
cloud by a tree. The eigenvector of the least eigenvalue has a closed form.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from viewgain.arrays import Array, Points

MIN_NEIGHBOURS = 6
"""A ball with fewer points, the own one included, has no normal."""
_LARGEST_WINDOW = 4
"""A ball that spans more pixels than this is summed over blocks of them; it holds 50 blocks then."""

Moments = NDArray[np.float32]


def image_normals(image: Array, radius: float, *, blocks: bool = False) -> Array:
    """Return the (h, w, 3) unit normals of an (h, w, 3) image of points; NaN where there is no point or too few neighbours.

    Args:
        image: Points, metres, camera frame (the origin is the camera); NaN where nothing came back.
        radius: Of the ball, metres.
        blocks: Where the ball spans many pixels, let small square blocks of them take the place of single ones and share a
            normal: as the means of blocks are less noisy than points, the ball then cuts off less of a noisy surface.

    Source:
        Ours; the published program wants normals and estimates none.
    """
    valid = np.isfinite(image[..., 2])
    if not valid.any():
        return np.full(image.shape, np.nan)
    middle = np.median(image[valid], axis=0)
    points = np.where(valid[..., None], image - middle, 0.0).astype(np.float32)
    window = _window(image, radius)
    side = max(1, int(np.ceil(window / _LARGEST_WINDOW))) if blocks else 1
    own = _block_sums(np.where(valid, _moments(points.transpose(2, 0, 1)), 0), side)
    sums = _shifted_sums(own, radius, window / side)
    filled = own[0] > 0
    normals = np.full((*filled.shape, 3), np.nan)
    normals[filled] = _flattest(sums[:, filled], (own[1:4, filled] / own[0, filled]).T + middle)
    spread = normals.repeat(side, axis=0).repeat(side, axis=1)[: image.shape[0], : image.shape[1]]
    return np.where(valid[..., None], spread, np.nan)


def cloud_normals(points: Points, radius: float) -> Points:
    """Return the (n, 3) unit normals of an unorganised cloud; as :func:`image_normals`, by a tree."""
    if len(points) == 0:
        return points
    pairs = cKDTree(points).query_pairs(radius, output_type="ndarray")
    ends = np.concatenate([pairs, pairs[:, ::-1]])
    near = csr_array((np.ones(len(ends), np.float32), (ends[:, 0], ends[:, 1])), shape=(len(points),) * 2)
    own = _moments((points - np.median(points, axis=0)).astype(np.float32))
    return _flattest(own + (near @ own.T).T, points)


def _window(image: Array, radius: float) -> float:
    """Return how many pixels the ball spans at the nearest points."""
    distance = np.linalg.norm(image, axis=-1)
    directions = image / distance[..., None]
    pitch = np.nanmedian(np.linalg.norm(np.diff(directions, axis=1), axis=-1))
    return float(radius / max(pitch * np.nanquantile(distance, 0.1), 1e-6))


def _half_disc(window: float) -> list[tuple[int, int]]:
    """Return the (row, column) offsets of one half of a disc; the other half is their mirror image."""
    steps = range(-int(window), int(window) + 1)
    return [(v, u) for v in steps for u in steps if (v, u) > (0, 0) and v * v + u * u <= window * window]


def _block_sums(moments: Moments, side: int) -> Moments:
    """Return the sums of (10, h, w) moments over square blocks of pixels; the last ones may be partly outside."""
    if side == 1:
        return moments
    _, height, width = moments.shape
    padded = np.pad(moments, ((0, 0), (0, -height % side), (0, -width % side)))
    blocks = padded.reshape(10, padded.shape[1] // side, side, padded.shape[2] // side, side)
    return np.asarray(blocks.sum(axis=(2, 4)))


def _shifted_sums(own: Moments, radius: float, window: float) -> Moments:
    """Return the (10, h, w) moments of the ball around the mean of each pixel (or block), of those whose own mean lies in it."""
    with np.errstate(invalid="ignore", divide="ignore"):
        points = own[1:4] / own[0]
    sums = own.copy()
    height, width = points.shape[1:]
    for down, across in _half_disc(window):
        if down >= height or abs(across) >= width:
            continue
        here = (slice(0, height - down), slice(max(0, -across), width - max(0, across)))
        there = (slice(down, height), slice(max(0, across), width + min(0, across)))
        step = points[:, *there] - points[:, *here]
        near = np.einsum("kvu,kvu->vu", step, step) < radius * radius
        sums[:, *here] += near * own[:, *there]
        sums[:, *there] += near * own[:, *here]
    return sums


def _moments(xyz: NDArray[np.float32]) -> Moments:
    """Return the (10, ...) moments 1, x, y, z, xx, xy, xz, yy, yz, zz of (3, ...) or (n, 3) coordinates."""
    x, y, z = xyz if xyz.ndim == 3 else xyz.T
    return np.stack([np.ones_like(x), x, y, z, x * x, x * y, x * z, y * y, y * z, z * z])


def _flattest(sums: Moments, points: Points) -> Points:
    """Return the (n, 3) directions in which the balls with (10, n) moments are thinnest, towards the camera."""
    count = sums[0].astype(float)
    x, y, z, xx, xy, xz, yy, yz, zz = sums[1:] / count
    spread = xx - x * x, xy - x * y, xz - x * z, yy - y * y, yz - y * z, zz - z * z
    normals = least_eigenvector(*spread)
    normals *= np.where(np.einsum("nk,nk->n", normals, points) > 0, -1.0, 1.0)[:, None]
    return np.where((count >= MIN_NEIGHBOURS)[:, None], normals, np.nan)


def least_eigenvector(xx: Array, xy: Array, xz: Array, yy: Array, yz: Array, zz: Array) -> Points:
    """Return the (n, 3) unit eigenvectors of the least eigenvalues of n symmetric 3 x 3 matrices, given by their entries.

    The eigenvalue is the least root of the characteristic cubic (Cardano's cosine); its vector is orthogonal to the rows of
    A - value I, so it is the longest cross product of two of them. Any vector is returned for a multiple of the identity.
    """
    mean = (xx + yy + zz) / 3
    a, b, c = xx - mean, yy - mean, zz - mean
    size = np.sqrt((a * a + b * b + c * c + 2 * (xy * xy + xz * xz + yz * yz)) / 6) + 1e-30
    determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    angle = np.arccos(np.clip(determinant / (2 * size**3), -1.0, 1.0)) / 3
    value = 2 * size * np.cos(angle + 2 * np.pi / 3)
    a, b, c = a - value, b - value, c - value
    rows = np.stack([
        [xy * yz - xz * b, xz * xy - a * yz, a * b - xy * xy],
        [xy * c - xz * yz, xz * xz - a * c, a * yz - xy * xz],
        [b * c - yz * yz, yz * xz - xy * c, xy * yz - b * xz],
    ])  # [3 products, 3, n]  # fmt: skip
    squares = np.einsum("pkn,pkn->pn", rows, rows)
    longest = np.argmax(squares, axis=0)
    chosen = rows[longest, :, np.arange(len(longest))]
    length = np.sqrt(squares[longest, np.arange(len(longest))])
    return np.asarray(np.where(length[:, None] > 0, chosen / np.maximum(length, 1e-300)[:, None], [0.0, 0.0, 1.0]))

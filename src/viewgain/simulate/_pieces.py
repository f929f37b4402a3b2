"""The image as a coarse grid of pieces of surface, and back from values on the grid to every pixel."""

from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np

from viewgain.arrays import Array, Ids, Indices, Mask, Points, Pose, Vector
from viewgain.camera import Intrinsics, Sensor
from viewgain.rays import Hits, Surfaces

LEAST_COSINE = 0.03
"""A face seen flatter than this gets no direct light to speak of; ratios to it are capped there."""
LEAST_HEIGHT = 1e-6
"""A piece lies in front of another if it is at least this far over its plane, metres."""


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """A coarse grid of pixels as pieces of surface, camera frame."""

    rows: Indices
    columns: Indices
    points: Points
    normals: Points
    ranges: Vector
    cosine: Vector
    reflectivity: Vector
    patch: Ids
    solid_angle: Vector

    def take(self, chosen: Indices) -> "Pieces":
        """Return a subset."""
        return Pieces(*(getattr(self, field.name)[chosen] for field in fields(self)))


def pieces_of(hits: Hits, surfaces: Surfaces, camera_to_world: Pose, sensor: Sensor, count: int) -> Pieces:
    """Return about ``count`` pixels on a square grid that see something."""
    camera, stride = sensor.intrinsics, _stride(sensor, count)
    rows, columns, directions = _grid(camera, stride)
    pixels = rows * camera.width + columns
    seen = np.isfinite(hits.ranges[pixels])
    rows, columns, directions, pixels = rows[seen], columns[seen], directions[seen], pixels[seen]
    surface = hits.surfaces[pixels]
    normals = surfaces.normals[surface] @ camera_to_world[:3, :3]
    # A mesh has no outside; what is seen is turned to the camera.
    normals = -normals * np.sign(np.sum(normals * directions, axis=1, keepdims=True))
    return Pieces(
        rows, columns, hits.ranges[pixels, None] * directions, normals, hits.ranges[pixels], hits.cosine[pixels],
        surfaces.reflectivity[surface], surfaces.patches[surface], stride**2 * directions[:, 2] ** 3 / (camera.fx * camera.fy),
    )  # fmt: skip


@lru_cache(maxsize=16)
def _grid(camera: Intrinsics, stride: int) -> tuple[Indices, Indices, Points]:
    """Return rows, columns and unit directions of every ``stride``-th pixel both ways; not to be written to."""
    rows, columns = np.mgrid[stride // 2 : camera.height : stride, stride // 2 : camera.width : stride].reshape(2, -1)
    return rows, columns, camera.directions()[rows, columns]


def _stride(sensor: Sensor, count: int) -> int:
    pixels = sensor.intrinsics.width * sensor.intrinsics.height
    return max(1, round(float(np.sqrt(pixels / count))))


def interpolated(values: Array, receivers: Pieces, patch: Ids, sensor: Sensor, count: int) -> Array:
    """Return the (2, n) bilinear interpolation of (2, r) shifts and gains at all pixels, each from pieces on its own patch.

    ``receivers`` are the pieces that ``count`` of them were asked for.

    Where two surfaces touch at a concave edge the way by the other one becomes no way at all: across such an edge the shift goes
    to zero. A pixel of a patch too narrow for the grid around it gets the mean of the patch; of one without any receiver, zeros.
    """
    camera = sensor.intrinsics
    stride = _stride(sensor, count)
    rows, columns = (len(range(stride // 2, size, stride)) for size in (camera.height, camera.width))
    # One more grid point on each side: a border of "nothing" spares every test for the image's edge.
    grid = np.zeros((3, rows + 2, columns + 2), dtype=np.float32)
    at = receivers.rows // stride + 1, receivers.columns // stride + 1
    grid[:, at[0], at[1]] = *values, receivers.patch + 2
    touching = np.zeros((int(patch.max(initial=-1)) + 2, rows + 2, columns + 2), dtype=bool)
    lit = np.unique(receivers.patch[values[0] > 0])
    touching[:, at[0], at[1]] = _touching(receivers, lit, len(touching), stride / camera.fx)
    # A cell between four grid points is a block of stride x stride pixels: four blown-up copies of the grid hold all corners.
    first = stride - stride // 2
    window = slice(None), slice(first, first + camera.height), slice(first, first + camera.width)
    mine = patch.reshape(camera.height, camera.width).astype(np.float32) + 2
    cell = [(np.arange(size) + first) // stride for size in mine.shape]
    share = np.arange(stride, dtype=np.float32) / stride
    down, right = np.tile(share, rows + 1)[window[1], None], np.tile(share, columns + 1)[window[2]]
    total, weights, still = (np.zeros((*lead, *mine.shape), dtype=np.float32) for lead in ((2,), (), ()))
    for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
        corner = grid[:, i : i + rows + 1, j : j + columns + 1].repeat(stride, axis=2).repeat(stride, axis=1)[window]
        bilinear = (down if i else 1 - down) * (right if j else 1 - right)
        weight = bilinear * (corner[2] == mine)
        total += weight * corner[:2]
        weights += weight
        beside = np.flatnonzero(corner[2] != mine)
        row, column = cell[0][beside // camera.width] + i, cell[1][beside % camera.width] + j
        still.ravel()[beside] += bilinear.ravel()[beside] * touching[patch[beside], row, column]
    total[0] /= np.maximum(weights + still, 1e-6)
    total[1] /= np.maximum(weights, 1e-6)
    out = total.reshape(2, -1).astype(float)
    members = np.maximum(np.bincount(receivers.patch, minlength=int(patch.max(initial=0)) + 1), 1)
    for which, (value, weight) in enumerate(zip(values, (weights + still, weights), strict=True)):
        alone = np.flatnonzero((weight.ravel() == 0) & (patch >= 0))
        if len(alone):
            out[which, alone] = (np.bincount(receivers.patch, value, len(members)) / members)[patch[alone]]
    return out


def _touching(receivers: Pieces, lit: Ids, count: int, spacing: float) -> Mask:
    """Return the (count, r) mask of receivers that lie just in front of a flat patch: on what it stands on or touches.

    Asked for the patches in ``lit`` only; the rows of the others are empty.

    Just in front is within three times the grid's spacing (an angle, from the camera) at the receiver's range and slope.
    """
    near = 3 * spacing * receivers.ranges / np.maximum(receivers.cosine, LEAST_COSINE)
    out = np.zeros((count, len(receivers.ranges)), dtype=bool)
    for patch in lit:
        on = np.flatnonzero(receivers.patch == patch)
        if is_flat(receivers, on):
            height = heights_over(receivers.points, receivers, on[0])
            out[patch] = (height > LEAST_HEIGHT) & (height < near)
    return out


def is_flat(patches: Pieces, chosen: Indices) -> bool:
    """Return whether pieces of one smooth patch lie in one plane; those of a mesh may not."""
    return bool(np.all(patches.normals[chosen] == patches.normals[chosen[0]]))


def heights_over(points: Points, patches: Pieces, index: int) -> Vector:
    """Return the heights of points over the plane of one piece, metres."""
    return np.asarray((points - patches.points[index]) @ patches.normals[index])

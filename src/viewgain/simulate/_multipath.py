"""Light that reaches a surface by way of one other surface: the bend of a box's face towards a bright floor.

The lamp sits in the camera, so every lit patch is a pixel: the image itself is the list of emitters. Patch Q gives back
rho_Q dOmega_Q of the lamp's light, whatever its distance and slope (what it gains by size it loses by spreading), as a Lambertian
disc; patch P receives of it

    dE_P = rho_Q dOmega_Q cos(Q) cos(P) / (pi d^2 + A_Q)

against cos(theta_P) / r_P^2 of direct light, on a path (r_Q + d - r_P) / 2 longer in range. Summed as phasors (the model is ours,
from the form factor of a disc). What is outside the image, and what stands between P and Q, is left out: between the faces of one
box and the floor nothing can stand. Solid angles are those of a pinhole.
"""

from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array, Ids, Indices, Mask, Points, Pose, Vector
from viewgain.camera import Intrinsics, Sensor
from viewgain.rays import Hits, Surfaces
from viewgain.simulate._signal import Signal, mixing_wavelength

FEW, MANY = 200, 800
"""Patches of the image that light up others, about: few for a surface of many receivers, like a floor; many for a small face."""
RECEIVERS = 1500
"""Patches of the image for which the light is summed; between them it is interpolated on the same surface."""
_LEAST_COSINE = 0.03
"""A face seen flatter than this gets no direct light to speak of; the ratio is capped there."""
_LEAST_HEIGHT = 1e-6
"""Two patches see each other if each lies at least this far in front of the other, metres."""

Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True, eq=False)
class _Patches:
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

    def take(self, chosen: Indices) -> "_Patches":
        """Return a subset."""
        return _Patches(*(getattr(self, field.name)[chosen] for field in fields(self)))


@dataclass(frozen=True, slots=True, eq=False)
class Bounces:
    """What first bounces do to each of n pixels."""

    shift: Vector
    """(n,) added to the range, metres."""
    gain: Vector
    """(n,) factor on the amplitude."""

    def added_to(self, signal: Signal) -> Signal:
        """Return the signal with the light of the bounces in it."""
        return Signal(signal.ranges + self.shift, signal.amplitude * self.gain, signal.cosine, signal.reflectivity)


def bounces(hits: Hits, surfaces: Surfaces, camera_to_world: Pose, sensor: Sensor) -> Bounces:
    """Return what the light of first bounces does to each pixel.

    Args:
        hits: (n,) what the pixel centres see.
        surfaces: The scene's surfaces.
        camera_to_world: (4, 4) pose of the camera.
        sensor: The camera.
    """
    few, many, receivers = (_patches(hits, surfaces, camera_to_world, sensor, count) for count in (FEW, MANY, RECEIVERS))
    wavelength = mixing_wavelength(sensor)
    factor = 1 + bounced(receivers, few, many, wavelength)
    shift = np.angle(factor) * wavelength / (2 * np.pi)
    shift, gain = _interpolated(np.stack([shift, np.abs(factor) - 1]), receivers, surfaces.patches[hits.surfaces], sensor)
    return Bounces(shift, 1 + gain)


def bounced(receivers: _Patches, few: _Patches, many: _Patches, wavelength: float) -> Complex:
    """Return the (r,) light that each receiver gets by one bounce, as a phasor relative to its direct light.

    Args:
        receivers: Where the light is wanted.
        few: Emitters for the surfaces with many receivers.
        many: The same scene as more and smaller emitters, for the others: close to an edge small patches matter.
        wavelength: Metres of range per turn of phase.
    """
    ratio = np.zeros(len(receivers.ranges), dtype=complex)
    for patch in np.unique(receivers.patch):
        on = np.flatnonzero(receivers.patch == patch)
        emitters = many if len(on) < MANY / 2 else few
        if _flat(receivers, on):
            over = _heights(emitters.points, receivers, on[0])
            # What faces the same way as a plane, like the top of a box and its floor, never faces the plane.
            facing = np.flatnonzero((over > _LEAST_HEIGHT) & (emitters.normals @ receivers.normals[on[0]] < 1 - 1e-9))
            emitters, over = emitters.take(facing), over[facing, None]
        else:
            over = _over(emitters.points, receivers.take(on))
        ratio[on] = _bounced_between(emitters, receivers.take(on), over, wavelength)
    return ratio


def _flat(patches: _Patches, chosen: Indices) -> bool:
    """Return whether pieces of one smooth patch lie in one plane; those of a mesh may not."""
    return bool(np.all(patches.normals[chosen] == patches.normals[chosen[0]]))


def _heights(points: Points, patches: _Patches, index: int) -> Vector:
    """Return the heights of points over the plane of one piece, metres."""
    return np.asarray((points - patches.points[index]) @ patches.normals[index])


def _over(points: Points, patches: _Patches) -> Array:
    """Return the (n, m) heights of points over the planes of pieces, metres; the same sums whatever the number of threads."""
    x, y, z = patches.normals.T
    offset = np.sum(patches.points * patches.normals, axis=1)
    return np.asarray(points[:, :1] * x + points[:, 1:2] * y + points[:, 2:] * z - offset)


def _bounced_between(emitters: _Patches, receivers: _Patches, over: Array, wavelength: float) -> Complex:
    """Return the (r,) sum over all pairs of which each side lies in front of the other.

    ``over`` is the height of each emitter over each receiver's plane: (q, r), or (q, 1) for receivers in one plane.
    """
    back = _over(receivers.points, emitters).T
    facing = (over > _LEAST_HEIGHT) & (back > _LEAST_HEIGHT)
    q, p = np.nonzero(facing)
    square = sum(
        (there[q] - here[p]) ** 2 for there, here in zip(emitters.points.T.copy(), receivers.points.T.copy(), strict=True)
    )
    towards, back = np.broadcast_to(over, facing.shape)[facing], back[facing]
    area = emitters.solid_angle * emitters.ranges**2 / np.maximum(emitters.cosine, _LEAST_COSINE)
    light = (emitters.reflectivity * emitters.solid_angle)[q] * towards * back / (square * (np.pi * square + area[q]))
    light *= (receivers.ranges**2 / np.maximum(receivers.cosine, _LEAST_COSINE))[p]
    turn = (np.pi / wavelength * (emitters.ranges[q] + np.sqrt(square) - receivers.ranges[p])).astype(np.float32)
    count = len(receivers.ranges)
    return np.asarray(np.bincount(p, light * np.cos(turn), count) + 1j * np.bincount(p, light * np.sin(turn), count))


def _patches(hits: Hits, surfaces: Surfaces, camera_to_world: Pose, sensor: Sensor, count: int) -> _Patches:
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
    return _Patches(
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


def _interpolated(values: Array, receivers: _Patches, patch: Ids, sensor: Sensor) -> Array:
    """Return the (2, n) bilinear interpolation of (2, r) shifts and gains at all pixels, each from receivers on its own patch.

    Where two surfaces touch at a concave edge the way by the other one becomes no way at all: across such an edge the shift goes
    to zero. A pixel of a patch too narrow for the grid around it gets the mean of the patch; of one without any receiver, zeros.
    """
    camera = sensor.intrinsics
    stride = _stride(sensor, RECEIVERS)
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
    count = np.maximum(np.bincount(receivers.patch, minlength=int(patch.max(initial=0)) + 1), 1)
    for which, (value, weight) in enumerate(zip(values, (weights + still, weights), strict=True)):
        alone = np.flatnonzero((weight.ravel() == 0) & (patch >= 0))
        if len(alone):
            out[which, alone] = (np.bincount(receivers.patch, value, len(count)) / count)[patch[alone]]
    return out


def _touching(receivers: _Patches, lit: Ids, count: int, spacing: float) -> Mask:
    """Return the (count, r) mask of receivers that lie just in front of a flat patch: on what it stands on or touches.

    Asked for the patches in ``lit`` only; the rows of the others are empty.

    Just in front is within three times the grid's spacing (an angle, from the camera) at the receiver's range and slope.
    """
    near = 3 * spacing * receivers.ranges / np.maximum(receivers.cosine, _LEAST_COSINE)
    out = np.zeros((count, len(receivers.ranges)), dtype=bool)
    for patch in lit:
        on = np.flatnonzero(receivers.patch == patch)
        if _flat(receivers, on):
            height = _heights(receivers.points, receivers, on[0])
            out[patch] = (height > _LEAST_HEIGHT) & (height < near)
    return out

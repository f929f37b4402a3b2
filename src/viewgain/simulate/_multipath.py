"""Light that reaches a surface by way of one other surface: the bend of a box's face towards a bright floor.

The lamp sits in the camera, so every lit patch is a pixel: the image itself is the list of emitters. Patch Q gives back
rho_Q dOmega_Q of the lamp's light, whatever its distance and slope (what it gains by size it loses by spreading), as a Lambertian
disc; patch P receives of it

    dE_P = rho_Q dOmega_Q cos(Q) cos(P) / (pi d^2 + A_Q)

against cos(theta_P) / r_P^2 of direct light, on a path (r_Q + d - r_P) / 2 longer in range. Summed as phasors (the model is ours,
from the form factor of a disc). What is outside the image, and what stands between P and Q, is left out: between the faces of one
box and the floor nothing can stand. Solid angles are those of a pinhole.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array, Points, Pose, Vector
from viewgain.camera import Sensor
from viewgain.rays import Hits, Surfaces
from viewgain.simulate._pieces import LEAST_COSINE, LEAST_HEIGHT, Pieces, heights_over, interpolated, is_flat, pieces_of
from viewgain.simulate._signal import Signal, mixing_wavelength

FEW, MANY = 200, 800
"""Patches of the image that light up others, about: few for a surface of many receivers, like a floor; many for a small face."""
RECEIVERS = 1500
"""Patches of the image for which the light is summed; between them it is interpolated on the same surface."""

Complex = NDArray[np.complex128]


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
    few, many, receivers = (pieces_of(hits, surfaces, camera_to_world, sensor, count) for count in (FEW, MANY, RECEIVERS))
    wavelength = mixing_wavelength(sensor)
    factor = 1 + bounced(receivers, few, many, wavelength)
    shift = np.angle(factor) * wavelength / (2 * np.pi)
    shift, gain = interpolated(
        np.stack([shift, np.abs(factor) - 1]), receivers, surfaces.patches[hits.surfaces], sensor, RECEIVERS
    )
    return Bounces(shift, 1 + gain)


def bounced(receivers: Pieces, few: Pieces, many: Pieces, wavelength: float) -> Complex:
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
        if is_flat(receivers, on):
            over = heights_over(emitters.points, receivers, on[0])
            # What faces the same way as a plane, like the top of a box and its floor, never faces the plane.
            facing = np.flatnonzero((over > LEAST_HEIGHT) & (emitters.normals @ receivers.normals[on[0]] < 1 - 1e-9))
            emitters, over = emitters.take(facing), over[facing, None]
        else:
            over = _over(emitters.points, receivers.take(on))
        ratio[on] = _bounced_between(emitters, receivers.take(on), over, wavelength)
    return ratio


def _over(points: Points, patches: Pieces) -> Array:
    """Return the (n, m) heights of points over the planes of pieces, metres; the same sums whatever the number of threads."""
    x, y, z = patches.normals.T
    offset = np.sum(patches.points * patches.normals, axis=1)
    return np.asarray(points[:, :1] * x + points[:, 1:2] * y + points[:, 2:] * z - offset)


def _bounced_between(emitters: Pieces, receivers: Pieces, over: Array, wavelength: float) -> Complex:
    """Return the (r,) sum over all pairs of which each side lies in front of the other.

    ``over`` is the height of each emitter over each receiver's plane: (q, r), or (q, 1) for receivers in one plane.
    """
    back = _over(receivers.points, emitters).T
    facing = (over > LEAST_HEIGHT) & (back > LEAST_HEIGHT)
    q, p = np.nonzero(facing)
    square = sum(
        (there[q] - here[p]) ** 2 for there, here in zip(emitters.points.T.copy(), receivers.points.T.copy(), strict=True)
    )
    towards, back = np.broadcast_to(over, facing.shape)[facing], back[facing]
    area = emitters.solid_angle * emitters.ranges**2 / np.maximum(emitters.cosine, LEAST_COSINE)
    light = (emitters.reflectivity * emitters.solid_angle)[q] * towards * back / (square * (np.pi * square + area[q]))
    light *= (receivers.ranges**2 / np.maximum(receivers.cosine, LEAST_COSINE))[p]
    turn = (np.pi / wavelength * (emitters.ranges[q] + np.sqrt(square) - receivers.ranges[p])).astype(np.float32)
    count = len(receivers.ranges)
    return np.asarray(np.bincount(p, light * np.cos(turn), count) + 1j * np.bincount(p, light * np.sin(turn), count))

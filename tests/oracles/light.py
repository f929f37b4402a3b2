"""Light that reaches a point of an upright face by way of the floor: the double integral over the floor, done by brute force.

Nothing of the simulator is used, and none of its form (patches of solid angle, discs): Lambert's law twice, on a fine grid.
"""

import numpy as np
from numpy.typing import NDArray

from viewgain.camera import Sensor

Array = NDArray[np.float64]


def floor_light(
    point: Array,
    normal: Array,
    camera_to_world: Array,
    sensor: Sensor,
    *,
    reflectivity: float,
    wavelength: float,
    half_width: float,
) -> complex:
    """Return the light that a point of an upright face receives from the floor z = 0, relative to the lamp's own, as a phasor.

    The lamp is a point of unit intensity in the camera. Floor element Q receives cos(Q) / r_Q^2 of it, gives back that times
    rho / pi per solid angle, and P receives cos cos / d^2 of that per area. The turn is that of a path longer by
    r_Q + d - r_P, which counts half in range. Only what the camera sees of the floor takes part, as in the simulator.

    Args:
        point: (3,) P, world, metres; the face stands on the floor.
        normal: (3,) of the face, horizontal.
        camera_to_world: (4, 4) pose.
        sensor: Its image bounds the lit floor.
        reflectivity: Of the floor.
        wavelength: Metres of range per turn.
        half_width: Of the floor to either side of the point along the face, metres.
    """
    height, eye = float(point[2]), camera_to_world[:3, 3]
    along = np.cross(np.array([0.0, 0.0, 1.0]), normal)
    # y = h sinh(a), x = h sinh(b): fine near the foot, where the light comes from, coarse far away.
    a = _midpoints(0.0, float(np.arcsinh(6.0 / height)), 500)
    b = _midpoints(-float(np.arcsinh(half_width / height)), float(np.arcsinh(half_width / height)), 601)
    y, x = np.meshgrid(height * np.sinh(a), height * np.sinh(b), indexing="ij")
    area = height**2 * np.cosh(a)[:, None] * np.cosh(b) * (a[1] - a[0]) * (b[1] - b[0])
    floor = np.array([point[0], point[1], 0.0]) + y[..., None] * normal + x[..., None] * along
    lit = _in_image(floor, camera_to_world, sensor)
    to_eye, to_point = eye - floor, point - floor
    r, d = np.linalg.norm(to_eye, axis=-1), np.linalg.norm(to_point, axis=-1)
    emitted = reflectivity / np.pi * (to_eye[..., 2] / r) / r**2
    arriving = emitted * (to_point[..., 2] / d) * (-(to_point @ normal) / d) / d**2 * area * lit
    direct_range = float(np.linalg.norm(eye - point))
    direct = float((eye - point) @ normal) / direct_range**3
    phase = 2 * np.pi / wavelength * (r + d - direct_range) / 2
    return complex((arriving * np.exp(1j * phase)).sum() / direct)


def _midpoints(low: float, high: float, count: int) -> Array:
    return np.asarray(low + (high - low) * (np.arange(count) + 0.5) / count)


def _in_image(points: Array, camera_to_world: Array, sensor: Sensor) -> Array:
    """Return 1 for points inside the image of a pinhole camera, else 0."""
    camera = sensor.intrinsics
    local = (points - camera_to_world[:3, 3]) @ camera_to_world[:3, :3]
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v = local[..., 0] / local[..., 2] * camera.fx + camera.cx, local[..., 1] / local[..., 2] * camera.fy + camera.cy
    inside = (local[..., 2] > 0) & (np.abs(u - (camera.width - 1) / 2) <= camera.width / 2)
    return np.asarray(inside & (np.abs(v - (camera.height - 1) / 2) <= camera.height / 2), dtype=float)

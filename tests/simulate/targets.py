"""Flat targets, plates with one edge, and cameras to look at them; what the tests of the simulator share."""

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from viewgain.box import Box
from viewgain.camera import Intrinsics, Sensor, sensor
from viewgain.geometry import Plane, pose, rotation_from_rotvec
from viewgain.scans import Scan
from viewgain.scenes import Scene

Array = NDArray[np.float64]
EYE = np.eye(4)
"""A camera at the world's origin that looks along the world's z."""
PICO = replace(sensor("pico_flexx"), flying_filter=0.0)
"""A preset without quantum, and without its filter: what a filter takes depends on the noise."""
SMALL = replace(PICO, intrinsics=Intrinsics.from_field_of_view(28, 21, *np.deg2rad([62.0, 45.0])))
"""Few enough pixels to cast them one by one."""
FAR = replace(PICO, range_min=1e-3, range_max=1e3, weakest=0.0)
"""A camera that loses nothing to its limits."""
MOTIONS = st.builds(
    lambda turn, shift: pose(rotation_from_rotvec(np.array(turn)), np.array(shift)),
    st.tuples(*[st.floats(-2, 2)] * 3),
    st.tuples(*[st.floats(-3, 3)] * 3),
)
"""Any rigid motion, tilts included."""


def cropped(camera: Sensor, width: int, height: int) -> Sensor:
    """Return the middle of a camera's image, as a camera: the same pixels, fewer of them."""
    inner = replace(camera.intrinsics, width=width, height=height, cx=(width - 1) / 2, cy=(height - 1) / 2)
    return replace(camera, intrinsics=inner)


def flat_target(z: float, theta: float = 0.0) -> Plane:
    """Return the wall that the camera at EYE sees at depth z, turned by theta (radians) about its vertical."""
    normal = np.array([np.sin(theta), 0.0, -np.cos(theta)])
    return Plane(normal, z * float(np.cos(theta)))


def plate(z: float, theta: float = 0.0, roll: float = 0.01, width: float = 0.4) -> Box:
    """Return a thin upright plate left of the axis of the camera at EYE, whose right edge crosses the axis at depth z.

    The roll (radians) lets the edge cross columns, so that it lies at every place within a pixel.
    """
    size = np.array([width, 0.002, 2.0])
    turn = rotation_from_rotvec(np.array([0.0, theta, 0.0])) @ rotation_from_rotvec(np.array([np.pi / 2, 0.0, 0.0]))
    turn = rotation_from_rotvec(np.array([0.0, 0.0, roll])) @ turn
    front = size[1] / 2 * (1 if turn[2, 1] < 0 else -1)
    return Box(pose(turn, np.array([0.0, 0.0, z]) - turn @ np.array([size[0] / 2, front, size[2] / 2])), size)


def ranges_of(scan: Scan) -> Array:
    """Return the (h, w) ranges, NaN for no return."""
    return np.asarray(np.linalg.norm(scan.organised(), axis=-1))


def plane_ranges(plane: Plane, camera: Sensor) -> Array:
    """Return the (h, w) true ranges of a plane seen from EYE."""
    return np.asarray(-plane.offset / (camera.intrinsics.directions() @ plane.normal))


def only_plane(plane: Plane, reflectivity: float = 0.5) -> Scene:
    """Return a scene of one wall."""
    return Scene(planes=(plane,), reflectivity=(reflectivity,))


def grazing(theta: float) -> float:
    """Return t / (pi / 2 - t)."""
    return theta / (np.pi / 2 - theta)

"""The rays of a camera's pixels, made once per camera."""

from functools import lru_cache

import numpy as np

from viewgain.arrays import Points, Points2
from viewgain.camera import Intrinsics
from viewgain.rays._slabs import Triple


@lru_cache(maxsize=16)
def pixel_rays(camera: Intrinsics) -> Triple:
    """Return the three components of the (height * width,) unit directions of all pixels, camera frame; not to be written to."""
    x, y, z = (np.ascontiguousarray(component) for component in camera.directions().reshape(-1, 3).T)
    for component in (x, y, z):
        component.setflags(write=False)
    return x, y, z


def rays_through(camera: Intrinsics, pixels: Points2) -> Triple:
    """Return the components of the unit directions through (..., 2) image points (u, v) that need not be pixel centres."""
    plain = (pixels - (camera.cx, camera.cy)) / (camera.fx, camera.fy)
    undistorted = camera.undistort(plain)
    return _unit(undistorted[..., 0], undistorted[..., 1])


def as_rows(directions: Triple) -> Points:
    """Return the (n, 3) rows of three components of the same shape."""
    return np.stack([component.ravel() for component in directions], axis=-1)


def _unit(x: Points, y: Points) -> Triple:
    scale = 1 / np.sqrt(x * x + y * y + 1)
    return x * scale, y * scale, scale

"""A camera with fewer pixels: planning needs one ray per voxel or so, not every pixel."""

from dataclasses import replace

import numpy as np

from viewgain.arrays import Vector3
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError
from viewgain.voxels._lattice import Lattice


def coarser(camera: Intrinsics, step: int) -> Intrinsics:
    """Return the camera that sees the same with one pixel for every ``step`` by ``step`` of them.

    What is left over at the right and lower border is cut off. The middle of a new pixel is the middle of those it stands for.

    Args:
        camera: The camera.
        step: Pixels per new pixel, along each side; from 1 to the smaller side of the image.

    Raises:
        ConfigError: If the step is under 1, or no pixel is left.
    """
    if step < 1:
        raise ConfigError(f"coarser camera: got a step of {step}, wanted 1 or more")
    return replace(
        camera,
        width=camera.width // step,
        height=camera.height // step,
        fx=camera.fx / step,
        fy=camera.fy / step,
        cx=(camera.cx + 0.5) / step - 0.5,
        cy=(camera.cy + 0.5) / step - 0.5,
    )


def pixels_per_voxel(lattice: Lattice, camera: Intrinsics, centre: Vector3) -> int:
    """Return how many pixels, along a row, a voxel in the middle of a lattice fills: rounded, 1 to the smaller side of the image.

    Args:
        lattice: The voxels.
        camera: The camera's image.
        centre: (3,) the camera's centre, metres, world frame.
    """
    distance = max(float(np.linalg.norm((lattice.low + lattice.high) / 2 - centre)), lattice.size)
    return int(np.clip(round(camera.fx * lattice.size / distance), 1, min(camera.width, camera.height)))

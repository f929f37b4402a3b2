"""A camera with fewer pixels: planning needs one ray per voxel or so, not every pixel."""

from dataclasses import replace

from viewgain.camera import Intrinsics


def coarser(camera: Intrinsics, step: int) -> Intrinsics:
    """Return the camera that sees the same with one pixel for every ``step`` by ``step`` of them.

    What is left over at the right and lower border is cut off. The middle of a new pixel is the middle of those it stands for.

    Args:
        camera: The camera.
        step: Pixels per new pixel, along each side; from 1 to the smaller side of the image.

    Raises:
        ConfigError: If no pixel is left.
    """
    return replace(
        camera,
        width=camera.width // step,
        height=camera.height // step,
        fx=camera.fx / step,
        fy=camera.fy / step,
        cx=(camera.cx + 0.5) / step - 0.5,
        cy=(camera.cy + 0.5) / step - 0.5,
    )

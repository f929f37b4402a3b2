"""The constraints of a time-of-flight camera by the plain way: every pixel asked, the outline walked in small steps."""

import numpy as np
from scipy.spatial import ConvexHull

from viewgain.box import Box
from viewgain.camera import Intrinsics
from viewgain.geometry import inverse, transform
from viewgain.rays import SceneCaster
from viewgain.scenes import Scene

_STEPS = 2000


def plain_incidence(box: Box, camera_to_world: np.ndarray, camera: Intrinsics) -> float:
    """Return the mean cosine of incidence over the pixels that see a face, each face at its centre; 0 where none does."""
    surfaces = SceneCaster(Scene((box,), planes=())).pixels(camera, camera_to_world).surfaces
    sides, rotation = box.extents, box.box_to_camera[:3, :3]
    middle = box.centre
    total, pixels = 0.0, 0
    for face, (axis, sign) in enumerate(((0, 1), (0, -1), (1, 1), (1, -1), (2, 1))):
        normal = sign * rotation[:, axis]
        to_camera = camera_to_world[:3, 3] - (middle + normal * sides[axis] / 2)
        count = int(np.count_nonzero(surfaces == face))
        total += count * float(normal @ to_camera) / float(np.linalg.norm(to_camera)) if count else 0.0
        pixels += count
    return total / pixels if pixels else 0.0


def plain_border(box: Box, camera_to_world: np.ndarray, camera: Intrinsics, margin: float) -> float:
    """Return 1 - share of the outline, by its length in the image plane, within ``margin`` pixels of the border or beyond."""
    seen = transform(inverse(camera_to_world), box.corners())
    flat = seen[:, :2] / seen[:, 2:]
    ends = flat[ConvexHull(flat).vertices]
    near, length = 0.0, 0.0
    for start, end in zip(ends, np.roll(ends, -1, axis=0), strict=True):
        at = start + (np.arange(_STEPS)[:, None] + 0.5) / _STEPS * (end - start)
        u, v = camera.project(np.column_stack([at, np.ones(_STEPS)])).T
        outside = (u < margin - 0.5) | (v < margin - 0.5) | (u > camera.width - 0.5 - margin) | (v > camera.height - 0.5 - margin)
        near += float(np.mean(outside)) * float(np.linalg.norm(end - start))
        length += float(np.linalg.norm(end - start))
    return 1 - near / length

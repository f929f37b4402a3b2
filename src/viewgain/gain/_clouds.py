"""What coverage is counted between: samples of a mesh's surface, and the point cloud that every view sees of it."""

import numpy as np

from viewgain.arrays import Points, Pose
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError, MissingExtraError
from viewgain.gain._protocol import CoverageProtocol
from viewgain.geometry import inverse, transform
from viewgain.meshes import TriangleMesh
from viewgain.rays import SceneCaster, as_rows, pixel_rays, zbuffer
from viewgain.rigs import Target, poses, rig
from viewgain.scenes import Scene


def surface_samples(mesh: TriangleMesh, count: int, *, rng: np.random.Generator) -> Points:
    """Return (count, 3) points drawn uniformly from a mesh's surface, inner surfaces included, in the mesh's own frame.

    A triangle that is there twice is drawn twice as often.

    Raises:
        ConfigError: If ``count`` is negative.
    """
    if count < 0:
        raise ConfigError(f"surface samples: got a count of {count}, wanted 0 or more")
    cumulated = np.cumsum(mesh.face_areas)
    # The product may round up to the whole area, which lies behind the last triangle.
    chosen = np.searchsorted(cumulated[:-1], rng.random(count) * cumulated[-1], side="right")
    u, v = rng.random((2, count, 1))
    root = np.sqrt(u)
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces[chosen]], 1, 0)
    return np.asarray((1 - root) * a + root * (1 - v) * b + root * v * c)


def normalised(mesh: TriangleMesh, protocol: CoverageProtocol) -> TriangleMesh:
    """Return the mesh as a protocol sees it: its bounding box centred on the origin, with the protocol's diagonal."""
    return mesh.normalised(protocol.diagonal)


def model_clouds(mesh: TriangleMesh, protocol: CoverageProtocol) -> list[Points]:
    """Return what each view of a protocol sees of a mesh, without noise: one point per pixel that meets it.

    With the extra ``data`` the pixels are drawn (z-buffer), without it rays are cast, slowly; both are exact and agree to
    rounding, but a ray along an edge may take the other side.

    Args:
        mesh: Any mesh; it is normalised here (:func:`normalised`; a normalised mesh stays as it is but for rounding).
        protocol: Views, camera and scale.

    Returns:
        One (n, 3) cloud per view in rig order, row by row of its image, frame of the normalised mesh; (0, 3) where
        a view sees nothing.

    Source:
        Zeng et al. (2020), public rendering scripts. Differs: the principal point is the middle of the image; theirs lies half a
        pixel off, because their conversion from depth to points counts pixels from their corners.
    """
    still = normalised(mesh, protocol)
    views = poses(rig(protocol.rig), Target.at(np.zeros(3)), distance=protocol.distance)
    return [_cloud(still, protocol.camera, view) for view in views]


def _cloud(mesh: TriangleMesh, camera: Intrinsics, camera_to_world: Pose) -> Points:
    """Return the (n, 3) points that a camera sees of a mesh, world frame."""
    try:
        depth, _ = zbuffer(transform(inverse(camera_to_world), mesh.vertices), mesh.faces, camera)
    except MissingExtraError:
        hits = SceneCaster(Scene(meshes=(mesh,), planes=())).pixels(camera, camera_to_world)
        met = np.isfinite(hits.ranges)
        return transform(camera_to_world, as_rows(pixel_rays(camera))[met] * hits.ranges[met, None])
    rows, columns = np.nonzero(np.isfinite(depth))
    z = depth[rows, columns]
    seen = np.stack([(columns - camera.cx) / camera.fx * z, (rows - camera.cy) / camera.fy * z, z], axis=1)
    return transform(camera_to_world, seen)

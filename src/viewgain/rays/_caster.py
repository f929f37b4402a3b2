"""One interface to everything that can be seen: a scene, ready to be looked at from any pose.

Boxes and planes go through the slab test. Meshes go through the z-buffer for the pixels of a pinhole camera and through Embree
for any other rays; what is not installed is replaced by the plain caster, which needs nothing and is slow.
"""

from functools import cached_property
from importlib.util import find_spec
from typing import Literal, TypeAlias

import numpy as np

from viewgain.arrays import Array, Ids, Points, Pose
from viewgain.camera import Intrinsics
from viewgain.geometry import inverse, transform
from viewgain.meshes import TriangleMesh
from viewgain.rays._embree import EmbreeMesh
from viewgain.rays._hits import NOTHING, Hits, Surfaces
from viewgain.rays._pixels import as_rows, pixel_rays
from viewgain.rays._slabs import FACES_PER_BOX, Triple, bodies_in_camera, cast_slabs
from viewgain.rays._triangles import cast_plain
from viewgain.rays._zbuffer import zbuffer
from viewgain.scenes import Scene

Backend: TypeAlias = Literal["auto", "zbuffer", "embree", "plain"]
"""How meshes are hit; "auto" is the fastest that is installed for the rays at hand."""
_BLOCK = 16384
"""Rays at a time through the slab test: what becomes of them stays in the processor's cache, which is worth a factor of three."""
_BOX_NORMALS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)


class SceneCaster:
    """A scene with what its rays need, made once and used from many poses."""

    def __init__(self, scene: Scene, *, backend: Backend = "auto") -> None:
        """Prepare nothing yet: meshes are indexed at the first ray.

        Args:
            scene: What is seen.
            backend: How meshes are hit.
        """
        self.scene = scene
        self._backend = backend

    @cached_property
    def surfaces(self) -> Surfaces:
        """The flat pieces of the scene, world frame."""
        scene = self.scene
        reflectivity = scene.body_reflectivity
        boxes, meshes = len(scene.boxes), len(scene.meshes)
        normals = [box.box_to_camera[:3, :3] @ _BOX_NORMALS.T for box in scene.boxes]
        normals += [mesh.face_normals.T for mesh in scene.meshes]
        normals += [plane.normal[:, None] for plane in scene.planes]
        faces = [len(mesh.faces) for mesh in scene.meshes]
        each_patch = [1] * (FACES_PER_BOX * boxes) + faces + [1] * len(scene.planes)
        each_body = [FACES_PER_BOX] * boxes + faces + [1] * len(scene.planes)
        return Surfaces(
            np.concatenate([*[block.T for block in normals], np.zeros((1, 3))]),
            np.append(np.repeat(np.arange(len(each_patch)), each_patch), NOTHING).astype(np.int32),
            np.append(np.repeat(reflectivity[: boxes + meshes + len(scene.planes)], each_body), 0.0),
        )

    @cached_property
    def mesh(self) -> TriangleMesh | None:
        """All meshes as one, world frame; None without any."""
        if not self.scene.meshes:
            return None
        starts = np.cumsum([0, *[len(mesh.vertices) for mesh in self.scene.meshes]])
        faces = [mesh.faces + start for mesh, start in zip(self.scene.meshes, starts, strict=False)]
        return TriangleMesh(np.concatenate([mesh.vertices for mesh in self.scene.meshes]), np.concatenate(faces), "scene")

    @cached_property
    def _embree(self) -> EmbreeMesh:
        assert self.mesh is not None
        return EmbreeMesh(self.mesh)

    def pixels(self, camera: Intrinsics, camera_to_world: Pose) -> Hits:
        """Return what the centres of all pixels see, row by row: (height * width,) hits.

        Raises:
            MissingExtraError: If a backend was named that is not installed.
        """
        directions = pixel_rays(camera)
        hits = self._planar(camera_to_world, directions)
        if self.mesh is None:
            return hits
        if self._backend == "zbuffer" or (self._backend == "auto" and not camera.distortion and _installed("numba")):
            vertices = transform(inverse(camera_to_world), self.mesh.vertices)
            depth, triangles = zbuffer(vertices, self.mesh.faces, camera)
            ranges = depth.ravel() / directions[2]
            return self._with_mesh(hits, camera_to_world, directions, ranges, triangles.ravel())
        return self._with_mesh(hits, camera_to_world, directions, *self._mesh_rays(camera_to_world, directions))

    def rays(self, camera_to_world: Pose, directions: Triple) -> Hits:
        """Return what any unit rays from the camera see.

        Args:
            camera_to_world: (4, 4) pose of the camera.
            directions: Three (n,) components of the directions, camera frame.

        Raises:
            MissingExtraError: If a backend was named that is not installed.
        """
        hits = self._planar(camera_to_world, directions)
        if self.mesh is None:
            return hits
        return self._with_mesh(hits, camera_to_world, directions, *self._mesh_rays(camera_to_world, directions))

    def _planar(self, camera_to_world: Pose, directions: Triple) -> Hits:
        """Return the hits of boxes and planes."""
        scene, count = self.scene, len(directions[0])
        boxes, planes = bodies_in_camera(scene.boxes, scene.planes, camera_to_world)
        first_plane = FACES_PER_BOX * len(boxes) + (0 if self.mesh is None else len(self.mesh.faces))
        blocks = [
            cast_slabs(boxes, planes, tuple(d[start : start + _BLOCK] for d in directions), first_plane=first_plane)
            for start in range(0, count, _BLOCK)
        ]
        if len(blocks) == 1:
            return Hits(*blocks[0])
        return Hits(*(np.concatenate(parts) for parts in zip(*blocks, strict=True)))

    def _mesh_rays(self, camera_to_world: Pose, directions: Triple) -> tuple[Array, Ids]:
        assert self.mesh is not None
        rows = as_rows(directions) @ camera_to_world[:3, :3].T
        if self._backend in ("embree", "zbuffer") or (self._backend == "auto" and _installed("embreex")):
            return self._embree.cast(camera_to_world[:3, 3], rows)
        return cast_plain(self.mesh, camera_to_world[:3, 3], rows)

    def _with_mesh(self, hits: Hits, camera_to_world: Pose, directions: Triple, ranges: Array, triangles: Ids) -> Hits:
        """Return the nearer of planar hits and hits of triangles."""
        nearer = np.flatnonzero(ranges < hits.ranges)
        surfaces = triangles[nearer] + FACES_PER_BOX * len(self.scene.boxes)
        normals: Points = self.surfaces.normals_of(surfaces) @ camera_to_world[:3, :3]
        merged = Hits(hits.ranges.copy(), hits.surfaces.copy(), hits.cosine.copy())
        merged.ranges[nearer] = ranges[nearer]
        merged.surfaces[nearer] = surfaces
        merged.cosine[nearer] = np.abs(sum(normals[:, k] * directions[k][nearer] for k in range(3)))
        return merged


def _installed(package: str) -> bool:
    return find_spec(package) is not None

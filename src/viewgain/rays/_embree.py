"""Rays against triangles by Embree: millions of arbitrary rays a second. The optional extra ``data``; not on linux on aarch64.

Embree is called through embreex directly: trimesh's wrapper around the same library takes several times as long. Embree works
in float32 and only finds the triangle; the range is then taken from the triangle's plane in float64.
"""

from typing import Any

import numpy as np

from viewgain.arrays import Array, Ids, Points, Vector
from viewgain.errors import MissingExtraError
from viewgain.meshes import TriangleMesh
from viewgain.rays._triangles import START, face_planes, plane_ranges, ray_arrays

BLOCK = 1 << 14
"""Rays that are cast together, so that what lies between the steps stays in the cache."""
FLOAT32_STEPS = 4e-7
"""Resolution of float32 with its last few bits lost, relative to the mesh's size."""


class EmbreeMesh:
    """A mesh with Embree's tree over it. Casting is safe from several threads; the object does not travel between processes.

    Args:
        mesh: The triangles, world frame. They are held relative to the middle of their bounding box, so a mesh far from the
            world's origin loses nothing; a degenerate triangle is left out.

    Raises:
        MissingExtraError: If embreex is not installed.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        try:
            from embreex.mesh_construction import TriangleMesh as EmbreeTriangles
            from embreex.rtcore_scene import EmbreeScene
        except ImportError as error:
            raise MissingExtraError('fast rays into a mesh need embreex: pip install "viewgain[data]"') from error
        low, high = mesh.bounds
        self._mesh = mesh
        self._planes = face_planes(mesh)
        self._middle = (low + high) / 2
        self._step = max(START, FLOAT32_STEPS * float(np.linalg.norm(high - low)))
        self._solid = np.flatnonzero(self._planes[:, :3].any(axis=1)).astype(np.int32)
        faces = mesh.faces[self._solid]
        vertices = np.zeros(mesh.vertices.shape, dtype=np.float32)  # a vertex of no triangle may be anything: it stays zero
        vertices[faces] = mesh.vertices[faces] - self._middle
        self._scene: Any = EmbreeScene(robust=True)  # robust: no ray slips between neighbours
        self._triangles: Any = EmbreeTriangles(self._scene, vertices, faces)
        self._first(np.zeros(3), np.array([[0.0, 0.0, 1.0]]))  # the first call builds the tree

    @property
    def planes(self) -> Array:
        """(f, 4) planes of the triangles, see :func:`viewgain.rays._triangles.face_planes`."""
        return self._planes

    def cast(self, origins: Array, directions: Points) -> tuple[Vector, Ids]:
        """Return where rays first meet the mesh.

        Embree's float32 decides which triangle is hit: beside an edge, or between surfaces closer than about 1e-6 of the mesh's
        size, it may be the neighbour, and a ray aimed at a corner to the last bit may pass between all its triangles. A ray that
        starts on the mesh does not hit the place it starts from; another surface closer to that place than the same 1e-6 may be
        missed (more for a ray that grazes the surface it starts from).

        Args:
            origins: (3,) or (n, 3) where the rays start, metres, world frame.
            directions: (n, 3) unit rays, world frame.

        Returns:
            (n,) ranges along the rays, metres, inf for a miss; (n,) int32 indices of the triangles hit, -1 for a miss.

        Raises:
            ValueError: If the shapes of origins and directions do not fit.

        Source:
            Wald et al. (2014), Embree: a kernel framework for efficient CPU ray tracing. The range in float64 is ours.
        """
        origins, directions = ray_arrays(origins, directions)
        ranges = np.empty(len(directions))
        triangles = np.empty(len(directions), dtype=np.int32)
        for top in range(0, len(directions), BLOCK):
            rays = slice(top, top + BLOCK)
            starts = origins if origins.ndim == 1 else origins[rays]
            ranges[rays], triangles[rays] = self._cast_block(starts, directions[rays])
        return ranges, triangles

    def _cast_block(self, origins: Array, directions: Points) -> tuple[Vector, Ids]:
        triangles = self._first(origins, directions)
        ranges = plane_ranges(self._mesh, self._planes, triangles, origins, directions)
        step = self._step
        stuck = np.flatnonzero(ranges <= START)  # these start on the triangle they hit: on with them, ever farther
        while stuck.size:
            starts, along = origins if origins.ndim == 1 else origins[stuck], directions[stuck]
            triangles[stuck] = self._first(starts + step * along, along)
            ranges[stuck] = plane_ranges(self._mesh, self._planes, triangles[stuck], starts, along)
            stuck = stuck[ranges[stuck] <= START]
            step *= 2
        return ranges, triangles

    def _first(self, origins: Array, directions: Points) -> Ids:
        """Return the (n,) triangles that Embree says are hit first, -1 for a miss."""
        if len(self._solid) == 0:
            return np.full(len(directions), -1, dtype=np.int32)
        starts = np.broadcast_to((origins - self._middle).astype(np.float32), directions.shape)
        found = self._scene.run(starts, directions.astype(np.float32), query="INTERSECT")
        return found if len(self._solid) == len(self._planes) else np.where(found >= 0, self._solid[found], np.int32(-1))

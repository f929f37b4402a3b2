"""A triangle mesh as a value: checked once, never changed. Any triangles (non-manifold, open, nested, duplicated) are welcome."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Faces, Points, Pose, Vector, Vector3
from viewgain.errors import MeshError
from viewgain.geometry import transform

_CHUNK = 2**18
"""Triangles at a time, so that the area of ten million needs little memory."""


@dataclass(frozen=True, slots=True, eq=False)
class TriangleMesh:
    """Triangles in space. Their orientation carries no meaning here: both sides of a triangle are surface."""

    vertices: Points
    """(v, 3) corners, all finite; metres, or any unit before :meth:`normalised`."""
    faces: Faces
    """(f, 3) int32 indices into ``vertices``, f >= 1."""
    name: str = "mesh"
    """Where it came from, for messages."""

    def __post_init__(self) -> None:
        vertices = np.ascontiguousarray(self.vertices, dtype=float)
        faces = np.ascontiguousarray(self.faces)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
            raise MeshError(f"{self.name}: got vertices {vertices.shape} and faces {faces.shape}, wanted (v, 3) and (f, 3)")
        if len(vertices) == 0 or len(faces) == 0:
            raise MeshError(f"{self.name}: got {len(vertices)} vertices and {len(faces)} faces, wanted at least one triangle")
        if faces.dtype.kind not in "iu":
            raise MeshError(f"{self.name}: got faces of type {faces.dtype}, wanted integers")
        if faces.min() < 0 or faces.max() >= len(vertices):
            span = f"{faces.min()} to {faces.max()}"
            raise MeshError(f"{self.name}: faces name vertices {span}, and there are {len(vertices)}; the mesh is damaged")
        if not np.all(np.isfinite(vertices).all(axis=1)[faces]):
            raise MeshError(f"{self.name}: some vertices are not finite numbers; repair the mesh before using it")
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces.astype(np.int32, copy=False))
        with np.errstate(over="ignore", invalid="ignore"):
            area = self.area
        if area == 0:
            raise MeshError(f"{self.name}: all {len(faces)} triangles have no area; there is no surface to see")
        if not np.isfinite(area):
            raise MeshError(f"{self.name}: its coordinates are too large to compute with; scale it down")

    @property
    def triangles(self) -> Array:
        """(f, 3, 3) corners of each triangle."""
        return np.asarray(self.vertices[self.faces])

    @property
    def bounds(self) -> Array:
        """(2, 3) lowest and highest corner of the axis-aligned box around the used vertices."""
        used = np.zeros(len(self.vertices), dtype=bool)
        used[self.faces] = True
        corners = self.vertices[used]
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    @property
    def extents(self) -> Vector3:
        """(3,) side lengths of that box."""
        low, high = self.bounds
        return np.asarray(high - low)

    @property
    def face_areas(self) -> Vector:
        """(f,) area of each triangle; 0 for a degenerate one."""
        parts = (self.faces[start : start + _CHUNK] for start in range(0, len(self.faces), _CHUNK))
        return np.concatenate([np.linalg.norm(_doubled_normals(self.vertices[part]), axis=1) / 2 for part in parts])

    @property
    def area(self) -> float:
        """Total area, counting both sides once."""
        return float(self.face_areas.sum())

    @property
    def face_normals(self) -> Points:
        """(f, 3) unit normals by the right-hand rule; zero for a degenerate triangle."""
        doubled = _doubled_normals(self.triangles)
        length = np.linalg.norm(doubled, axis=1, keepdims=True)
        return np.asarray(np.divide(doubled, length, out=np.zeros_like(doubled), where=length > 0))

    def moved(self, mesh_to_world: Pose) -> "TriangleMesh":
        """Return the mesh in another frame, by a (4, 4) rigid motion."""
        return TriangleMesh(transform(mesh_to_world, self.vertices), self.faces, self.name)

    def scaled(self, factor: float) -> "TriangleMesh":
        """Return the mesh blown up about the origin by ``factor`` > 0."""
        if not (np.isfinite(factor) and factor > 0):
            raise MeshError(f"{self.name}: got a scale of {factor}, wanted a positive number")
        return TriangleMesh(self.vertices * factor, self.faces, self.name)

    def normalised(self, diagonal: float = 1.0) -> "TriangleMesh":
        """Return the mesh with its bounding box centred on the origin and that box's diagonal set.

        A diagonal of 1 is the scale of ShapeNetCore v1, in which PC-NBV's distances are given (Zeng et al. 2020).
        """
        low, high = self.bounds
        centred = TriangleMesh(self.vertices - (low + high) / 2, self.faces, self.name)
        return centred.scaled(diagonal / float(np.linalg.norm(high - low)))

    def standing(self, at: tuple[float, float] = (0.0, 0.0)) -> "TriangleMesh":
        """Return the mesh moved so that its lowest point lies on z = 0 and the middle of its footprint at ``at``, metres."""
        low, high = self.bounds
        middle = (low + high) / 2
        return TriangleMesh(self.vertices - [middle[0] - at[0], middle[1] - at[1], low[2]], self.faces, self.name)


def _doubled_normals(triangles: Array) -> Points:
    """Return (f, 3) normals whose length is twice the triangle's area."""
    return np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])

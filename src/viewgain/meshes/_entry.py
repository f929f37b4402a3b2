"""One mesh of a folder: what it is called, and where it lies until somebody wants it."""

from dataclasses import dataclass, replace
from pathlib import Path

from viewgain.meshes._file import MAX_FACES
from viewgain.meshes._read import read_mesh
from viewgain.meshes._triangle_mesh import TriangleMesh


@dataclass(frozen=True, slots=True, kw_only=True)
class MeshEntry:
    """A mesh that has not been read yet."""

    category: str
    """The folder's name, or the name of its synset (ShapeNetCore)."""
    name: str
    """Unique within the category in all known data sets, though nothing enforces it."""
    path: Path
    part: str | None = None
    """ "train" or "test" where the data set says so (ModelNet)."""

    def load(self, *, max_faces: int = MAX_FACES) -> TriangleMesh:
        """Return the mesh, named ``category/name``; raises as :func:`viewgain.meshes.read_mesh`."""
        return replace(read_mesh(self.path, max_faces=max_faces), name=f"{self.category}/{self.name}")

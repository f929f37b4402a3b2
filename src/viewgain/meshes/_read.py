"""The one door for mesh files: checked, decoded by trimesh, cleaned; whatever goes wrong ends in one line."""

import io
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from viewgain.arrays import Points
from viewgain.errors import ConfigError, MeshError, ViewgainError
from viewgain.meshes._checks import check_obj, check_off, check_ply, check_stl
from viewgain.meshes._clean import Integers, cleaned
from viewgain.meshes._file import MAX_FACES, PathLike, load_bytes, one_line, printable, require_few
from viewgain.meshes._gltf import Beside, check_gltf
from viewgain.meshes._triangle_mesh import TriangleMesh

CHECKS: dict[str, tuple[Callable[[Path, bytes, int], bytes], str]] = {
    ".ply": (check_ply, "ply"),
    ".obj": (check_obj, "obj"),
    ".stl": (check_stl, "stl"),
    ".off": (check_off, "ply"),
    ".glb": (check_gltf, "glb"),
    ".gltf": (check_gltf, "gltf"),
}
"""The file extensions that are read, what is checked before trimesh decodes one, and what trimesh decodes it as."""


def read_mesh(path: PathLike, *, max_faces: int = MAX_FACES) -> TriangleMesh:
    """Return the mesh in a PLY, OBJ, STL, OFF, GLB or GLTF file; docs/meshes.md has the details.

    All parts of the file become one mesh, in the file's own units and axes; polygons are cut into triangles; colours and textures
    are left out. Triangles without area and vertices without triangles are dropped; duplicated triangles, holes and edges of more
    than two triangles stay as they are.

    Args:
        path: The mesh.
        max_faces: More triangles than this are refused.

    Raises:
        MeshError: If the file is missing, not one of these, truncated, damaged, too large, or has no surface; one line that names
            the file, the cause and the way out.
        ConfigError: If ``max_faces`` is not positive.
    """
    path = Path(path)
    if max_faces < 1:
        raise ConfigError(f"max_faces: got {max_faces}, wanted at least 1")
    try:
        data = load_bytes(path)
        if path.suffix.lower() not in CHECKS:
            raise MeshError(f"{path}: unknown type of file '{path.suffix}'; wanted one of {' '.join(CHECKS)}")
        check, kind = CHECKS[path.suffix.lower()]
        with np.errstate(all="ignore"):
            return _mesh(path, *_decoded(path, check(path, data, max_faces), kind, max_faces))
    except Exception as error:
        raise _translated(error, path) from error


def _decoded(path: Path, data: bytes, kind: str, max_faces: int) -> tuple[Points, Integers]:
    """Return all vertices and triangles that trimesh finds, every part in its place; points and lines are left out."""
    import trimesh

    beside: Any = Beside(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what a warning could mean for the mesh is checked here
        # Except this one, which older numpy gives instead of an error where text is no number: the rest would be left out.
        warnings.filterwarnings("error", "string or file could not be read", DeprecationWarning)
        loaded: Any = trimesh.load(io.BytesIO(data), kind, resolver=beside, process=False, skip_materials=True, fix_texture=False)
        if isinstance(loaded, trimesh.Scene):
            placed = [loaded.geometry[loaded.graph[node][1]] for node in loaded.graph.nodes_geometry]
            require_few(path, sum(len(getattr(part, "faces", ())) for part in placed), max_faces)
            for part in placed:
                _require_sound(path, part)
            loaded = loaded.to_mesh()
    _require_sound(path, loaded)
    faces = np.asarray(getattr(loaded, "faces", ()))
    require_few(path, len(faces), max_faces)
    return np.asarray(loaded.vertices, dtype=float), faces


def _require_sound(path: Path, part: Any) -> None:
    """Refuse what trimesh did not check: indices, and that the faces of a binary PLY are all as long as the first."""
    faces: Any = getattr(part, "faces", ())
    if len(faces) and not 0 <= faces.min() <= faces.max() < len(part.vertices):
        raise MeshError(
            f"{path}: faces name vertices {faces.min()} to {faces.max()} (counted from 0) but there are {len(part.vertices)};"
            " the file is damaged; export the mesh again"
        )
    table = part.metadata.get("_ply_raw", {}).get("face", {}).get("data")
    lists = [table[name] for name in table.dtype.names if table.dtype[name].names] if isinstance(table, np.ndarray) else []
    if any(np.any(one["f0"] != one["f0"][0]) for one in lists):
        raise MeshError(f"{path}: its faces differ in their numbers of corners; export it as ASCII PLY, or as triangles")


def _mesh(path: Path, vertices: Points, faces: Integers) -> TriangleMesh:
    if len(faces) == 0:
        raise MeshError(f"{path}: has {len(vertices)} vertices and no faces, so no surface; export it as a mesh of triangles")
    vertices, kept = cleaned(vertices, faces)
    if len(kept) == 0:
        raise MeshError(f"{path}: all {len(faces)} triangles have no area, so there is no surface; export the mesh again")
    return TriangleMesh(vertices, kept.astype(np.int32, copy=False), str(path))


def _translated(error: Exception, path: Path) -> ViewgainError:
    """Return what to raise for any failure: one printable line that names the file."""
    if isinstance(error, ViewgainError):
        return type(error)(printable(str(error)))
    if isinstance(error, MemoryError):
        return MeshError(printable(f"{path}: does not fit into memory; simplify the mesh"))
    if isinstance(error, OSError) and error.strerror:
        return MeshError(printable(f"{path}: cannot be read ({error.strerror}); check the file and its permissions"))
    cause = one_line(error)
    if cause == "PLY is unexpected length!":
        cause = "its length is not what the header says, with as many corners in every face as in the first"
    return MeshError(printable(f"{path}: is truncated, damaged or no {path.suffix} file ({cause}); export triangles again"))

"""What every mesh file goes through, whatever its format: the bytes, the limits, and texts that fit into one line."""

import os
from pathlib import Path
from typing import TypeAlias

from viewgain.errors import MeshError
from viewgain.errors import one_line as one_line
from viewgain.errors import printable as printable

PathLike: TypeAlias = str | os.PathLike[str]

LARGEST_FILE = 2**31
"""Bytes, of any file; binary STL with ten million triangles has 0.5 GB."""

LARGEST_TEXT = 250_000_000
"""Bytes, of ASCII PLY and STL, OBJ and OFF: trimesh takes about 25 times as much memory for them."""

MAX_FACES = 10_000_000
"""Triangles that are read unless told otherwise; docs/meshes.md has the time and memory that this takes."""


def load_bytes(path: Path) -> bytes:
    """Return the content of a mesh file.

    Raises:
        MeshError: If there is no such file, it is not a regular file, it is empty or over 2 GiB.
    """
    if not path.exists():
        raise MeshError(f"{path}: no such file; check the path")
    if not path.is_file():
        raise MeshError(f"{path}: is {'a folder' if path.is_dir() else 'not a regular file'}, no mesh; give one file")
    size = path.stat().st_size
    if size == 0:
        raise MeshError(f"{path}: the file is empty (0 bytes); export the mesh again")
    require_small(path, size, LARGEST_FILE)
    return path.read_bytes()


def require_small(path: Path, size: int, largest: int) -> None:
    """Refuse a file of more bytes than ``largest``."""
    if size > largest:
        raise MeshError(f"{path}: {size / 1e9:.2f} GB is over the limit of {largest / 1e9:.2f} GB; simplify it or make it binary")


def require_few(path: Path, faces: int, max_faces: int) -> None:
    """Refuse more faces than the caller wants to wait for."""
    if faces > max_faces:
        raise MeshError(f"{path}: has {faces} faces, over the limit of {max_faces} faces; simplify the mesh or raise max_faces")

"""glTF 2.0 meshes (.glb, .gltf): what trimesh would misread is refused, and buffers are taken from beside the file only."""

import json
from pathlib import Path
from urllib.parse import unquote

from viewgain.errors import MeshError
from viewgain.meshes._file import load_bytes, require_few

_DEEPEST = 256
"""Nodes within nodes; trimesh walks from each to the root."""


class Beside:
    """The files in the folder of a mesh, by the URI that its header gives them."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def __getitem__(self, uri: str) -> bytes:
        folder = self._path.parent.resolve()
        file = (folder / unquote(uri)).resolve()
        if not (file.is_relative_to(folder) and file.is_file()):
            raise MeshError(f"{self._path}: its buffer {uri[:80]!r} is no file beside it; put it there, or export one .glb file")
        return load_bytes(file)


def check_gltf(path: Path, data: bytes, max_faces: int) -> bytes:
    """Return the bytes as they are.

    Raises:
        MeshError: If there are more than ``max_faces`` faces; or what trimesh takes for something else: compressed and quantised
            positions for plain ones or zeros, a node that is also a camera for no mesh; or what it takes too long for.
    """
    header = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")] if path.suffix.lower() == ".glb" else data)
    accessors, nodes, faces = header.get("accessors", []), header.get("nodes", []), 0
    for primitive in (primitive for mesh in header.get("meshes", []) for primitive in mesh["primitives"]):
        places = primitive.get("indices"), primitive["attributes"].get("POSITION")
        used = [accessors[place] for place in places if place is not None]
        if any("bufferView" not in one or "sparse" in one or one.get("normalized") or one["count"] < 0 for one in used):
            raise MeshError(f"{path}: its geometry is compressed, sparse or quantised; export plain float positions")
        faces += used[0]["count"] // 3 if used else 0
    require_few(path, faces, max_faces)
    if any("camera" in node and ("mesh" in node or "children" in node) for node in nodes):
        raise MeshError(f"{path}: a node of its scene is a camera and something else; export the mesh without cameras")
    level = set(range(len(nodes)))
    for _ in range(_DEEPEST):
        level = {child for index in level for child in nodes[index].get("children", [])}
    if level:
        raise MeshError(f"{path}: its nodes are nested in a circle or more than {_DEEPEST} deep; export the mesh again")
    return data

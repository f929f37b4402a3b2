"""Mesh files of every format, written byte by byte or by trimesh, so that the readers are tested against others."""

import json
import struct
from pathlib import Path

import numpy as np
import trimesh

# A pyramid with a square bottom: one quad and four triangles, no two corners alike.
VERTICES = np.array([[0.0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0], [0.25, 0.5, 3]])
POLYGONS = ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4))
TRIPLES = ((0, 3, 2), (0, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4))
TRIANGLES = np.array(TRIPLES)


def put(folder: Path, name: str, content: bytes | str) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def soup(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The (f, 9) corners of the triangles, the triangles sorted and each begun at its least corner: independent of numbering."""
    triangles = []
    for corners in np.round(np.asarray(vertices, dtype=float)[np.asarray(faces)], 5) + 0.0:
        turns = [np.roll(corners, -turn, axis=0).ravel().tolist() for turn in range(3)]
        triangles.append(min(turns))
    return np.array(sorted(triangles))


def text(rows: np.ndarray | tuple[tuple[int, ...], ...], before: str = "") -> str:
    return "".join(before + " ".join(str(number) for number in row) + "\n" for row in rows)


def counted(polygons: tuple[tuple[int, ...], ...] = POLYGONS, after: str = "") -> str:
    return "".join(f"{len(polygon)} " + " ".join(map(str, polygon)) + f"{after}\n" for polygon in polygons)


def off(header: str = "OFF\n", vertices: np.ndarray = VERTICES, after: str = "") -> str:
    return f"{header}{len(vertices)} {len(POLYGONS)} 0\n{text(vertices)}{counted(after=after)}"


def obj(before: str = "") -> str:
    return before + text(VERTICES, "v ") + text(tuple(tuple(i + 1 for i in polygon) for polygon in POLYGONS), "f ")


def ply_header(vertices: object = 5, faces: object = 5, form: str = "binary_little_endian", *, extra: str = "") -> str:
    lines = ["ply", f"format {form} 1.0", "comment made by a test", f"element vertex {vertices}"]
    lines += [f"property float {name}" for name in "xyz"]
    lines += [f"element face {faces}", "property list uchar int vertex_indices"]
    return "\n".join([*lines, *extra.splitlines(), "end_header", ""])


def ply(polygons: tuple[tuple[int, ...], ...] = TRIPLES, order: str = "<", vertices: np.ndarray = VERTICES) -> bytes:
    form = "binary_little_endian" if order == "<" else "binary_big_endian"
    rows = [struct.pack(f"{order}B{len(polygon)}i", len(polygon), *polygon) for polygon in polygons]
    return ply_header(len(vertices), len(polygons), form).encode() + vertices.astype(f"{order}f4").tobytes() + b"".join(rows)


def stl(claimed: int | None = None) -> bytes:
    facets = np.zeros(len(TRIANGLES), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    facets["corners"] = VERTICES[TRIANGLES]
    return b"solid, yet binary".ljust(80) + struct.pack("<I", len(facets) if claimed is None else claimed) + facets.tobytes()


def stl_text() -> str:
    facets = [f"facet normal 0 0 0\nouter loop\n{text(corners, 'vertex ')}endloop\nendfacet\n" for corners in VERTICES[TRIANGLES]]
    return "solid pyramid\n" + "".join(facets) + "endsolid pyramid\n"


def gltf(**changes: object) -> tuple[dict[str, object], bytes]:
    """The JSON and the buffer of the pyramid, in a node that stands 10 to the right of its parent."""
    points, corners = VERTICES.astype("<f4").tobytes(), TRIANGLES.astype("<u2").tobytes()
    header: dict[str, object] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1]}, {"mesh": 0, "translation": [10, 0, 0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(points + corners)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(points)},
            {"buffer": 0, "byteOffset": len(points), "byteLength": len(corners)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(VERTICES), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": TRIANGLES.size, "type": "SCALAR"},
        ],
    }
    return header | changes, points + corners


def glb(header: dict[str, object] | None = None, **changes: object) -> bytes:
    default, buffer = gltf(**changes)
    words = json.dumps(default if header is None else header).encode()
    words += b" " * (-len(words) % 4)
    chunks = struct.pack("<I4s", len(words), b"JSON") + words + struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def by_trimesh(extension: str, mesh: trimesh.Trimesh | None = None) -> bytes:
    mesh = trimesh.Trimesh(VERTICES, TRIANGLES, process=False) if mesh is None else mesh
    content = mesh.export(file_type=extension)
    return content.encode() if isinstance(content, str) else content

"""PLY clouds: the header is checked against the file's size here, trimesh decodes the vertices."""

import io
import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from viewgain.arrays import Array, Points
from viewgain.errors import ScanError
from viewgain.geometry import require_rigid
from viewgain.scans._raw import RawScan, grid, require_magic, require_room

_BYTES = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16", "float16"), 2),
    **dict.fromkeys(("int", "uint", "float", "int32", "uint32", "float32"), 4),
    **dict.fromkeys(("int64", "uint64", "double", "float64"), 8),
}
_LONGEST_HEADER = 2**16


@dataclass(slots=True)
class _Element:
    """One ``element`` of the header with its ``property`` lines."""

    name: str
    count: int
    properties: list[list[str]] = field(default_factory=list)

    @property
    def has_list(self) -> bool:
        return any(words[0] == "list" for words in self.properties)

    @property
    def row_bytes(self) -> int:
        return sum(_BYTES[words[0]] for words in self.properties)


def read_ply(path: Path, data: bytes) -> RawScan:
    """Return the vertices of a PLY file (ascii or binary, either byte order), with normals where it has them.

    Faces are left out. The comments that :func:`viewgain.scans.write_scan` puts in give units, image and pose.

    Raises:
        ScanError: If it is no PLY file, is truncated, or has no x, y, z.
    """
    require_magic(path, data, "PLY", b"ply")
    header, body = _split(path, data)
    form, elements = _parse(path, header)
    vertices = next((element for element in elements if element.name == "vertex"), None)
    if vertices is None or not {"x", "y", "z"} <= {words[-1] for words in vertices.properties}:
        raise ScanError(f"{path}: the PLY header has no vertex element with x, y and z; export it as a point cloud")
    vertex = _decode(path, form, elements, body)
    points = _columns(vertex, "x", "y", "z")
    if len(points) != vertices.count:
        raise ScanError(f"{path}: the header claims {vertices.count} vertices, {len(points)} were found; export the scan again")
    names = {words[-1] for words in vertices.properties}
    normals = _columns(vertex, "nx", "ny", "nz") if {"nx", "ny", "nz"} <= names else None
    faces = any(element.name == "face" and element.count for element in elements)
    notes = ("the file is a mesh: its vertices were read, its faces were not",) if faces else ()
    return _with_comments(path, header, vertex, RawScan(points=points, normals=normals, notes=notes))


def _split(path: Path, data: bytes) -> tuple[list[str], bytes]:
    end = re.search(rb"^end_header[ \t\r]*\n", data[:_LONGEST_HEADER], re.MULTILINE)
    if end is None:
        raise ScanError(f"{path}: the PLY header has no end_header line; the file is truncated or damaged; export the scan again")
    return data[: end.start()].decode("ascii", "replace").splitlines(), data[end.end() :]


def _parse(path: Path, header: list[str]) -> tuple[str, list[_Element]]:
    form, elements = "", []
    for words in (line.split() for line in header):
        try:
            if words[:1] == ["format"]:
                form = words[1]
            elif words[:1] == ["element"]:
                elements.append(_Element(words[1], int(words[2])))
                if elements[-1].count < 0:
                    raise ValueError(words[2])
            elif words[:1] == ["property"]:
                if words[1] != "list" and (words[1] not in _BYTES or len(words) != 3):
                    raise ValueError(words[1])
                elements[-1].properties.append(words[1:])
        except (IndexError, ValueError):
            line = " ".join(words)[:80]
            raise ScanError(f"{path}: the PLY header line '{line}' makes no sense; export the scan again") from None
    if form not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ScanError(f"{path}: the PLY has the format '{form[:40]}', wanted ascii or binary_..._endian; export the scan again")
    return form, elements


def _decode(path: Path, form: str, elements: list[_Element], body: bytes) -> Any:
    """Return trimesh's vertex data: a structured array (binary) or a dict of columns (ascii).

    Only the part of the file up to the vertices is handed over, so faces of mixed sizes and range grids do no harm.
    """
    from trimesh.exchange.ply import load_ply

    wanted = elements[: [element.name for element in elements].index("vertex") + 1]
    if any(element.has_list for element in wanted):
        raise ScanError(f"{path}: the PLY has list properties before or among its vertices; export it as a point cloud")
    rows = sum(element.count for element in wanted)
    if form == "ascii":
        lines = [line for line in body.split(b"\n") if line.strip()]
        if rows > len(lines):
            raise ScanError(
                f"{path}: the header claims {rows} rows but only {len(lines)} follow;"
                " the file is truncated or its header is wrong; export the scan again"
            )
        _require_columns(path, wanted, lines)
        body = b"\n".join(lines[:rows])
    else:
        claimed = sum(element.count * element.row_bytes for element in wanted)
        require_room(path, claimed, len(body), f"{wanted[-1].count} vertices")
        body = body[:claimed]
    if wanted[-1].count == 0:
        raise ScanError(f"{path}: the PLY holds no vertices; is the scene in range?")
    lines_out = ["ply", f"format {form} 1.0"]
    for element in wanted:
        lines_out += [f"element {element.name} {element.count}", *(f"property {' '.join(words)}" for words in element.properties)]
    content = io.BytesIO("\n".join([*lines_out, "end_header", ""]).encode() + body)
    return load_ply(content, fix_texture=False, skip_materials=True)["metadata"]["_ply_raw"]["vertex"]["data"]


def _require_columns(path: Path, elements: list[_Element], lines: list[bytes]) -> None:
    row = 0
    for element in elements:
        for line in lines[row : row + element.count]:
            row += 1
            found = len(line.split())
            if found != len(element.properties):
                raise ScanError(
                    f"{path}: row {row} of the PLY has {found} numbers, wanted {len(element.properties)};"
                    " the file is truncated or damaged; export the scan again"
                )


def _column(vertex: Any, name: str) -> Array:
    return np.asarray(vertex[name], dtype=float).reshape(-1)


def _columns(vertex: Any, *names: str) -> Points:
    return np.column_stack([_column(vertex, name) for name in names])


def _with_comments(path: Path, header: list[str], vertex: Any, raw: RawScan) -> RawScan:
    """Add what the comments of write_scan say: ``comment viewgain`` and units m, image H W or camera_to_world with 16 numbers."""
    comments = [line.split()[2:] for line in header if line.split()[:2] == ["comment", "viewgain"]]
    own = {words[0]: words[1:] for words in comments if words}
    if own.get("units") == ["m"]:
        raw = replace(raw, scale=1.0, scale_note="metres, as the file says")
    if "camera_to_world" in own:
        pose = np.array([float(word) for word in own["camera_to_world"]]).reshape(4, 4)
        raw = replace(raw, camera_to_world=require_rigid(pose, f"{path}: camera_to_world"))
    if "image" in own:
        height, width = (int(word) for word in own["image"])
        pixels = _column(vertex, "pixel")
        if not 0 < height * width <= 2**26 or pixels.min() < 0 or pixels.max() >= height * width:
            raise ScanError(f"{path}: pixel numbers do not fit the image of {width} x {height}; write the scan again")
        normals = None if raw.normals is None else grid(raw.normals, pixels, (height, width))
        raw = replace(raw, points=grid(raw.points, pixels, (height, width)), normals=normals)
    return raw

"""What trimesh would misread in silence is refused, or put into words that it reads right, before it sees the bytes.

Each check takes a file's path, its bytes and the limit on faces, and returns the bytes for trimesh. What trimesh refuses is
left to it: a binary PLY of another length than its header says, letters among numbers, most indices that are too large.
"""

import re
from pathlib import Path

from viewgain.errors import MeshError
from viewgain.meshes._file import LARGEST_TEXT, require_few, require_small

_LONGEST_HEADER = 2**16
_OFF_AS_PLY = b"""ply
format ascii 1.0
element vertex %d
property double x
property double y
property double z
element face %d
property list uint int vertex_indices
end_header"""


def check_ply(path: Path, data: bytes, max_faces: int) -> bytes:
    """Refuse a PLY file without faces, with too many, or (ASCII) with fewer rows than claimed."""
    header = data[: data.find(b"end_header", 0, _LONGEST_HEADER) + 10]
    counts = {name: int(count) for name, count in re.findall(rb"^element\s+(\S+)\s+(\d+)", header, re.MULTILINE)}
    if not data.startswith(b"ply") or len(header) < 10:
        raise MeshError(f"{path}: is not a PLY file from 'ply' to 'end_header'; check its type or export the mesh again")
    if not counts.get(b"face"):
        raise MeshError(f"{path}: has no faces: a point cloud, not a mesh; reconstruct its surface first")
    require_few(path, counts[b"face"], max_faces)
    if re.search(rb"^format\s+ascii", header, re.MULTILINE):
        require_small(path, len(data), LARGEST_TEXT)
        last, _, _ = header.rpartition(b"element")[2].partition(b"list")
        place = last.count(b"property") - 1 if last.split()[0] == b"face" else None
        _require_rows(path, data[len(header) :], sum(counts.values()), place)
    # trimesh takes an element "edge" for a path.
    return _ascii(header).replace(b"element edge", b"element edges") + data[len(header) :]


def check_off(path: Path, data: bytes, max_faces: int) -> bytes:
    """Refuse an OFF file with too many faces or fewer rows than claimed; return it as PLY, whose rows are the same.

    (Of OFF, trimesh does not read triangles together with pentagons.)
    """
    require_small(path, len(data), LARGEST_TEXT)
    rows = re.sub(rb"\n\s+", b"\n", re.sub(rb"#.*", b"", _ascii(data))).strip()
    found = re.match(rb"(?:ST)?C?N?OFF\s*(\d+)\s+(\d+).*", rows)
    if found is None:
        raise MeshError(f"{path}: is not an OFF file: it does not begin with OFF and two counts; export the mesh as text OFF")
    vertices, faces, rows = int(found[1]), int(found[2]), rows[found.end() :]
    require_few(path, faces, max_faces)
    _require_rows(path, rows, vertices + faces, 0 if faces else None)
    return _OFF_AS_PLY % (vertices, faces) + rows


def check_stl(path: Path, data: bytes, max_faces: int) -> bytes:
    """Refuse an STL file that was cut off or has too many facets; make one solid of several, whose vertices trimesh would merge.

    A binary file may begin with ``solid`` as ASCII ones do, and may have bytes behind its facets, which trimesh does not take.
    """
    claimed = int.from_bytes(data[80:84], "little")
    end = 84 + 50 * claimed
    if len(data) != end and data[:1024].lstrip()[:5].lower() == b"solid" and b"\0" not in data[:1024]:
        require_small(path, len(data), LARGEST_TEXT)
        if b"endsolid" not in data[-4096:].lower():
            raise MeshError(f"{path}: the STL has no endsolid at its end; the file is truncated; export the mesh again")
        facets, facet_ends = re.subn(rb"(?i)endfacet", b"", re.sub(rb"(?im)^[ \t]*(end)?solid.*$", b"", _ascii(data)))
        require_few(path, facet_ends, max_faces)
        return b"solid\n" + facets + b"\nendsolid\n"
    if len(data) < max(84, end):
        raise MeshError(f"{path}: claims {claimed} facets but has {len(data)} bytes; the STL is truncated; export the mesh again")
    require_few(path, claimed, max_faces)
    return data[:end]


def check_obj(path: Path, data: bytes, max_faces: int) -> bytes:
    """Refuse an OBJ file with too many faces; leave corners with nothing but a vertex, counted from the first one."""
    require_small(path, len(data), LARGEST_TEXT)
    data = b"\n" + _ascii(data).replace(b"\t", b" ").replace(b"\r\n", b"\n")
    # Lines that go on in the next, comments, textures and normals of corners, indentation, and changes of material.
    for unwanted, instead in ((rb"\\\n", b" "), (rb"#.*", b""), (rb"/\S*", b""), (rb"\n +", b"\n"), (rb"\nusemtl.*", b"")):
        data = re.sub(unwanted, instead, data)
    require_few(path, data.count(b"\nf "), max_faces)
    return _counted_from_one(path, data) if re.search(rb"\nf.* [-0]", data) else data


def _counted_from_one(path: Path, data: bytes) -> bytes:
    """Rewrite corners that count back from the latest vertex, which trimesh takes for the last, and refuse a zero."""
    lines, vertices = data.split(b"\n"), 0
    for row, line in enumerate(lines):
        vertices += line.startswith(b"v ")
        if line.startswith(b"f "):
            corners = [corner + (vertices + 1) * (corner < 0) for corner in map(int, line.split()[1:])]
            if min(corners) < 1:
                raise MeshError(f"{path}: '{line[:60].decode()}' names a vertex before the first; export the mesh again")
            lines[row] = b"f " + b" ".join(b"%d" % corner for corner in corners)
    return b"\n".join(lines)


def _require_rows(path: Path, rows: bytes, claimed: int, place: int | None) -> None:
    """Refuse a text that ends before its last row does; word ``place`` of that says how many corners follow it."""
    rows = rows.strip()
    last = rows[rows.rfind(b"\n") + 1 :].split()
    found = rows.count(b"\n") + 1
    if found == claimed and place is not None and len(last) <= place + int(last[place]):
        found -= 1
    if found < claimed:
        raise MeshError(
            f"{path}: the header claims {claimed} rows but only {found} follow;"
            " the file is truncated or its header is wrong; export the mesh again"
        )


def _ascii(data: bytes) -> bytes:
    """Drop what is not ASCII, as in names; trimesh wants UTF-8, or a package that guesses."""
    return data.translate(None, bytes(range(128, 256)))

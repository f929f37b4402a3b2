"""PCD clouds: the header is checked against the file's size here, pypcd4 decodes the data."""

import io
import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array, Pose, Vector
from viewgain.errors import ScanError
from viewgain.geometry import pose, require_rigid
from viewgain.scans._raw import RawScan, require_magic, require_room

_BYTES = {("F", 4), ("F", 8), *((kind, size) for kind in "UI" for size in (1, 2, 4, 8))}
_IDENTITY = ["0", "0", "0", "1", "0", "0", "0"]
_LONGEST_HEADER = 2**16
_LARGEST_EXPANSION = 300
"""LZF turns at most 3 bytes into 264, so a block that claims to grow more than this lies."""


class _Header:
    """The ten lines that every PCD begins with; missing COUNT, HEIGHT, VIEWPOINT and POINTS take PCL's defaults."""

    def __init__(self, path: Path, text: str) -> None:
        lines = {words[0].upper(): words[1:] for words in map(str.split, text.splitlines()) if words and words[0] != "#"}
        try:
            names = lines["FIELDS"]
            self.names = [name if re.fullmatch(r"\w+", name) and name != "_" else f"field{i}" for i, name in enumerate(names)]
            self.sizes = [int(word) for word in lines["SIZE"]]
            self.types = [word.upper() for word in lines["TYPE"]]
            self.counts = [int(word) for word in lines.get("COUNT", ["1"] * len(names))]
            self.width, self.height = int(lines["WIDTH"][0]), int(lines.get("HEIGHT", ["1"])[0])
            self.points = int(lines.get("POINTS", [str(self.width * self.height)])[0])
            self.viewpoint = [float(word) for word in lines.get("VIEWPOINT", _IDENTITY)]
            self.encoding = lines["DATA"][0].lower()
        except (KeyError, ValueError, IndexError) as error:
            raise ScanError(f"{path}: the PCD header lacks or garbles {error}; export the scan again") from None
        self._check(path)

    def _check(self, path: Path) -> None:
        complaint = None
        if not len(self.names) == len(self.sizes) == len(self.types) == len(self.counts):
            complaint = "FIELDS, SIZE, TYPE and COUNT differ in length"
        elif not {"x", "y", "z"} <= set(self.names) or len(set(self.names)) != len(self.names):
            complaint = f"the fields are {' '.join(self.names)[:60]}, wanted x, y and z, each once"
        elif any(pair not in _BYTES for pair in zip(self.types, self.sizes, strict=True)) or min(self.counts) < 1:
            complaint = "an impossible combination of TYPE, SIZE and COUNT"
        elif self.points < 0 or self.width * self.height != self.points:
            complaint = f"WIDTH {self.width} x HEIGHT {self.height} is not POINTS {self.points}"
        elif len(self.viewpoint) != 7:
            complaint = f"VIEWPOINT has {len(self.viewpoint)} numbers, wanted 7"
        elif self.encoding not in ("ascii", "binary", "binary_compressed"):
            complaint = f"DATA {self.encoding[:40]}, wanted ascii, binary or binary_compressed"
        if complaint:
            raise ScanError(f"{path}: the PCD header makes no sense: {complaint}; export the scan again")

    @property
    def row_bytes(self) -> int:
        return sum(size * count for size, count in zip(self.sizes, self.counts, strict=True))

    def text(self) -> str:
        """Return the header as pypcd4 wants it."""
        rows: dict[str, list[Any]] = {
            **{"VERSION": ["0.7"], "FIELDS": self.names, "SIZE": self.sizes, "TYPE": self.types, "COUNT": self.counts},
            **{"WIDTH": [self.width], "HEIGHT": [self.height], "VIEWPOINT": _IDENTITY, "POINTS": [self.points]},
            "DATA": [self.encoding],
        }
        return "".join(f"{key} {' '.join(map(str, row))}\n" for key, row in rows.items())


def read_pcd(path: Path, data: bytes) -> RawScan:
    """Return the points of a PCD file (ascii, binary, binary_compressed); HEIGHT > 1 keeps the image.

    A VIEWPOINT other than identity is the pose of the camera, and the points are in the camera's frame (PCL's convention);
    identity means that the pose is unknown.

    Raises:
        ScanError: If it is no PCD file, is truncated, or has no x, y, z.
    """
    require_magic(path, data, "PCD", b"#", b"VERSION", b"FIELDS")
    end = re.search(rb"^DATA[ \t]+\S+[ \t\r]*\n", data[:_LONGEST_HEADER], re.MULTILINE)
    if end is None:
        raise ScanError(f"{path}: the PCD header has no DATA line; the file is truncated or no PCD; export the scan again")
    header = _Header(path, data[: end.end()].decode("ascii", "replace"))
    if header.points == 0:
        raise ScanError(f"{path}: the PCD holds no points; is the scene in range?")
    rows = _decode(header, _checked_body(path, header, data[end.end() :]))
    if len(rows) != header.points:
        raise ScanError(f"{path}: the header claims {header.points} points, {len(rows)} were found; export the scan again")
    shape = (header.height, header.width) if header.height > 1 else (header.points,)
    names = rows.dtype.names or ()
    normals = ("normal_x", "normal_y", "normal_z")
    strength = next((name for name in ("amplitude", "intensity") if name in names and header.height > 1), None)
    return RawScan(
        points=_columns(rows, "x", "y", "z").reshape(*shape, 3),
        normals=_columns(rows, *normals).reshape(*shape, 3) if set(normals) <= set(names) else None,
        amplitude=rows[strength].astype(float).reshape(shape) if strength else None,
        camera_to_world=_pose(path, np.array(header.viewpoint)),
        pose_in_file_units=True,
    )


def _checked_body(path: Path, header: _Header, body: bytes) -> bytes:
    if header.encoding == "ascii":
        lines = [b" ".join(line.split()) for line in body.split(b"\n") if line.strip()]
        if header.points > len(lines):
            raise ScanError(
                f"{path}: the header claims {header.points} points but only {len(lines)} rows follow;"
                " the file is truncated or its header is wrong; export the scan again"
            )
        return b"\n".join(lines[: header.points])
    claimed = header.points * header.row_bytes
    if header.encoding == "binary":
        require_room(path, claimed, len(body), f"{header.points} points")
        return body
    packed, unpacked = struct.unpack("<II", body[:8]) if len(body) >= 8 else (8, 0)
    require_room(path, packed, len(body) - 8, f"a compressed block for {header.points} points")
    if unpacked != claimed or claimed > _LARGEST_EXPANSION * max(packed, 1):
        raise ScanError(
            f"{path}: the header claims {header.points} points ({claimed} bytes) but the compressed block of {packed} bytes"
            f" says {unpacked}; the file is damaged; export the scan again"
        )
    return body


def _decode(header: _Header, body: bytes) -> NDArray[Any]:
    from pypcd4.pypcd4 import PointCloud

    content: Any = io.BytesIO(header.text().encode() + body)
    return np.atleast_1d(PointCloud.from_fileobj(content).pc_data)


def _columns(rows: NDArray[Any], *names: str) -> Array:
    return np.column_stack([rows[name].astype(float) for name in names])


def _pose(path: Path, viewpoint: Vector) -> Pose | None:
    """Return the camera's pose from (tx, ty, tz, qw, qx, qy, qz), None for identity."""
    if np.allclose(viewpoint, [0, 0, 0, 1, 0, 0, 0], atol=1e-9):
        return None
    w, x, y, z = viewpoint[3:] / np.linalg.norm(viewpoint[3:])
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return require_rigid(pose(rotation, viewpoint[:3]), f"{path}: VIEWPOINT")

"""One file of named arrays in the safetensors layout: eight bytes of header length, a JSON header, then the arrays.

One file, so that a shard is one rename, one checksum and one open descriptor; the header carries the checksum of what follows.
"""

import hashlib
import json
import mmap
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from viewgain.errors import DataError

Columns: TypeAlias = dict[str, NDArray[Any]]
"""Arrays by name."""
_TYPES = {
    "F32": "<f4",
    "F16": "<f2",
    "I64": "<i8",
    "I32": "<i4",
    "I16": "<i2",
    "U32": "<u4",
    "U16": "<u2",
    "U8": "|u1",
    "BOOL": "|b1",
}
_NAMES = {np.dtype(value).str: key for key, value in _TYPES.items()}
_LARGEST_HEADER = 100_000_000
"""The limit that the format itself sets, bytes."""


def encoded(columns: Columns, metadata: Mapping[str, str]) -> bytes:
    """Return the bytes of a file. Arrays lie in order of the size of their numbers, largest first, so that each is aligned."""
    names = sorted(columns, key=lambda name: (-columns[name].dtype.itemsize, name))
    body = b"".join(np.ascontiguousarray(columns[name]).tobytes() for name in names)
    header: dict[str, Any] = {"__metadata__": {**metadata, "sha256": hashlib.sha256(body).hexdigest()}}
    start = 0
    for name in names:
        array = columns[name]
        kind, shape = _NAMES[array.dtype.newbyteorder("<").str], list(array.shape)
        header[name] = {"dtype": kind, "shape": shape, "data_offsets": [start, start + array.nbytes]}
        start += array.nbytes
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 8)
    return struct.pack("<Q", len(text)) + text + body


def opened(path: Path) -> tuple[Columns, dict[str, str]]:
    """Return the arrays of a file, memory-mapped and read-only, and its metadata. The content is not checked: see :func:`intact`.

    Raises:
        DataError: If the file is missing, or its header is damaged or does not fit its size.
    """
    try:
        with path.open("rb") as file:
            content = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        (length,) = struct.unpack("<Q", content[:8])
        if length > _LARGEST_HEADER:
            raise ValueError(f"a header of {length} bytes")
        header = json.loads(content[8 : 8 + length])
        metadata = {str(key): str(value) for key, value in header.pop("__metadata__", {}).items()}
        columns = {str(name): _view(content, 8 + length, entry) for name, entry in header.items()}
        if 8 + length + max((entry["data_offsets"][1] for entry in header.values()), default=0) != len(content):
            raise ValueError("its size is not what its header says")
    except (OSError, ValueError, KeyError, TypeError, AttributeError, struct.error) as error:
        raise DataError(f"{path}: cannot be read as a shard ({error}); run its build with --resume") from error
    return columns, metadata


def intact(path: Path) -> bool:
    """Return whether a file can be opened and its arrays have the checksum that its header states."""
    try:
        _, metadata = opened(path)
        with path.open("rb") as file:
            (length,) = struct.unpack("<Q", file.read(8))
            file.seek(8 + length)
            return hashlib.file_digest(file, "sha256").hexdigest() == metadata.get("sha256")
    except (DataError, OSError):
        return False


def _view(content: mmap.mmap, start: int, entry: Mapping[str, Any]) -> NDArray[Any]:
    low, high = entry["data_offsets"]
    kind, shape = np.dtype(_TYPES[entry["dtype"]]), tuple(entry["shape"])
    count = int(np.prod(shape, dtype=np.int64))
    if not 0 <= low <= high or high - low != count * kind.itemsize or start + high > len(content):
        raise ValueError("an array does not fit the file")
    return np.frombuffer(content, kind, count, start + low).reshape(shape) if count else np.zeros(shape, kind)

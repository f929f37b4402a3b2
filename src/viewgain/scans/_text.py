"""Text clouds (XYZ, TXT, CSV, ASC, PTS): one point per line, columns found by a header line or by their order."""

import io
import re
from pathlib import Path

import numpy as np

from viewgain.arrays import Array
from viewgain.errors import ScanError
from viewgain.scans._raw import RawScan, one_line

_AXES = {"x": 0, "y": 1, "z": 2, "points:0": 0, "points:1": 1, "points:2": 2}
_NORMALS = {"nx": 0, "ny": 1, "nz": 2, "normal_x": 0, "normal_y": 1, "normal_z": 2}


def read_text(path: Path, data: bytes) -> RawScan:
    """Return the points of a text file with comma, semicolon, tab or space between the columns.

    Lines that begin with ``#`` or ``//`` are comments, except that the last one before the data may name the columns. Without
    names the first three columns are x, y, z. With semicolons a comma may be the decimal point.

    Raises:
        ScanError: If it is not text, has fewer than three columns, or a line that is no row of numbers.
    """
    if re.search(rb"[\x00-\x08\x0e-\x1f]", data):
        raise ScanError(f"{path}: is not a text file; wanted rows of x, y, z; is the extension right?")
    # Only a name in the header can be more than ASCII, and no name that counts is.
    text = data.removeprefix(b"\xef\xbb\xbf").decode("latin-1").replace("\r\n", "\n").replace("\r", "\n")
    lines = [line.strip(" ") for line in text.split("\n")]
    start, header = _header(path, lines)
    rows = [line for line in lines[start:] if line.strip() and not _is_comment(line)]
    delimiter = _delimiter(rows[0])
    if delimiter == ";" and "," in rows[0]:
        rows = [row.replace(",", ".") for row in rows]
    points, normals, note = _columns(path, header, len(_fields(rows[0], delimiter)))
    table = _parse(path, rows, delimiter, points + normals)
    return RawScan(points=table[:, :3], normals=table[:, 3:] if normals else None, notes=(note,))


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith(("#", "//"))


def _delimiter(line: str) -> str | None:
    return next((delimiter for delimiter in (";", "\t", ",") if delimiter in line), None)


def _fields(line: str, delimiter: str | None) -> list[str]:
    fields = [field.strip().strip('"') for field in line.split(delimiter)]
    return fields[:-1] if fields[-1:] == [""] else fields


def _is_number(word: str) -> bool:
    try:
        float(word.replace(",", "."))
    except ValueError:
        return False
    return True


def _header(path: Path, lines: list[str]) -> tuple[int, list[str]]:
    """Return the number of the first data line and the names of the columns (empty if there are none).

    At most one line that is not a comment may come before the data: names of columns, or the number of points (PTS).
    """
    header: list[str] = []
    skipped = 0
    for number, line in enumerate(lines):
        if not line.strip():
            continue
        bare = re.sub(r"^\s*(#|//)\s*", "", line)
        fields = _fields(bare, _delimiter(bare))
        if bare == line.lstrip():
            if len(fields) >= 3 and all(map(_is_number, fields[:3])):
                return number, header
            skipped += 1
        if skipped > 1:
            raise ScanError(f"{path}: line {number + 1} is no row of numbers: '{line[:60]}'; wanted x, y, z")
        header = [name.lower() for name in fields]
    raise ScanError(f"{path}: no line has three numbers; wanted one point per line as x, y, z")


def _columns(path: Path, header: list[str], count: int) -> tuple[list[int], list[int], str]:
    """Return which columns are x, y, z, which are the normals (if any), and the note that says so."""
    named = [re.split(r"[\s(\[/]", name)[0] for name in header]
    if not header or len(named) < 3 or not any(name in _AXES for name in named):
        if len(named) >= 3 and len(named) == count and not any(map(_is_number, named)):
            raise ScanError(f"{path}: the columns are {', '.join(header)[:60]}; wanted x, y and z among them")
        return [0, 1, 2], [], "columns: the first three are x, y, z (no names given)"
    axes = {_AXES[name]: column for column, name in enumerate(named) if name in _AXES}
    if sorted(axes) != [0, 1, 2]:
        raise ScanError(f"{path}: the columns are {', '.join(header)[:60]}; wanted x, y and z among them")
    normals = {_NORMALS[name]: column for column, name in enumerate(named) if name in _NORMALS}
    use_normals = [normals[axis] for axis in range(3)] if sorted(normals) == [0, 1, 2] else []
    return [axes[axis] for axis in range(3)], use_normals, "columns: x, y, z as the header names them"


def _parse(path: Path, rows: list[str], delimiter: str | None, columns: list[int]) -> Array:
    try:
        content = io.StringIO("\n".join(rows))
        table = np.loadtxt(content, delimiter=delimiter, usecols=columns, ndmin=2, comments=None, quotechar='"')
    except ValueError as error:
        raise ScanError(f"{path}: a line is no row of numbers ({one_line(error)}); is the file truncated?") from error
    return np.asarray(table, dtype=float)

"""Text clouds: separators, headers, comments, decimal commas."""

from pathlib import Path

import numpy as np
import pytest

from tests.scans import files
from viewgain.scans import read_scan

POINTS = np.round(files.cloud(), 4)
NORMALS = np.round(files.unit_vectors(), 4)


def rows(table: np.ndarray, delimiter: str = ",", end: str = "\n", decimal: str = ".") -> str:
    return "".join(delimiter.join(f"{number:.4f}" for number in row).replace(".", decimal) + end for row in table)


CASES = {
    "plain": rows(POINTS, " "),
    "many blanks": rows(POINTS, "    "),
    "comma and blank": rows(POINTS, ", "),
    "header": "X,Y,Z\n" + rows(POINTS),
    "header with units": "x [m];y [m];z [m]\n" + rows(POINTS, ";"),
    "quoted header": '"x","y","z"\n' + rows(POINTS),
    "header as comment": "# x y z\n" + rows(POINTS, " "),
    "cloudcompare": "//X Y Z\n" + rows(POINTS, " "),
    "paraview": '"Points:0","Points:1","Points:2"\n' + rows(POINTS),
    "number of points": "150\n" + rows(POINTS, " "),
    "comments": "# scanned today\n# with care\n" + rows(POINTS[:70]) + "# half time\n\n" + rows(POINTS[70:]),
    "other columns": rows(np.column_stack([POINTS, NORMALS, np.arange(150)])),
    "trailing delimiter": rows(POINTS, ";", ";\n"),
    "decimal comma": rows(POINTS, ";", decimal=","),
    "windows": rows(POINTS, "\t", "\r\n"),
    "old mac": rows(POINTS, "\t", "\r"),
    "byte order mark": "\ufeffx,y,z\n" + rows(POINTS),
    "no end of line": rows(POINTS)[:-1],
    "shuffled": "label,z,x,y\n" + rows(np.column_stack([np.arange(150), POINTS[:, [2, 0, 1]]])),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("suffix", ["csv", "xyz", "txt"])
def test_separators_and_headers(tmp_path: Path, case: str, suffix: str) -> None:
    scan = read_scan(files.put(tmp_path, f"scan.{suffix}", CASES[case]))
    np.testing.assert_array_equal(scan.points, POINTS)


def test_a_header_in_another_encoding(tmp_path: Path) -> None:
    data = "x,y,z,Höhe\n".encode("latin-1") + rows(np.column_stack([POINTS, POINTS[:, 2]])).encode()
    np.testing.assert_array_equal(read_scan(files.put(tmp_path, "scan.csv", data)).points, POINTS)


def test_named_normals_are_kept(tmp_path: Path) -> None:
    scan = read_scan(files.put(tmp_path, "scan.csv", "x,y,z,nx,ny,nz\n" + rows(np.column_stack([POINTS, NORMALS]))))
    np.testing.assert_allclose(scan.normals, NORMALS, rtol=0, atol=1e-4)  # four digits were written


def test_which_columns_were_taken_is_said(tmp_path: Path) -> None:
    assert any("first three" in note for note in read_scan(files.put(tmp_path, "a.csv", rows(POINTS))).notes)
    assert any(
        "as the header names them" in note for note in read_scan(files.put(tmp_path, "b.csv", "x,y,z\n" + rows(POINTS))).notes
    )


def test_invalid_returns_are_counted(tmp_path: Path) -> None:
    scan = read_scan(files.put(tmp_path, "scan.csv", rows(POINTS) + "nan,nan,nan\n0,0,0\n0,0,0\ninf,1,1\n"))
    dropped = scan.dropped
    assert (dropped.not_a_number, dropped.zero, dropped.infinite) == (1, 2, 1)
    np.testing.assert_array_equal(scan.points, POINTS)

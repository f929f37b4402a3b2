"""A mesh of ten million faces is read, in bounded memory."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from tests.meshes import files
from viewgain.errors import MeshError
from viewgain.meshes import read_mesh

SIDE = 2236
"""Squares along each side of a carpet, two triangles each: 9,999,392 triangles."""


@pytest.mark.slow
def test_ten_million_faces(tmp_path: Path) -> None:
    x, y = (values.ravel() for values in np.meshgrid(np.arange(SIDE + 1), np.arange(SIDE + 1)))
    corner = (np.arange(SIDE)[:, None] * (SIDE + 1) + np.arange(SIDE)).ravel()
    below, above = np.array([0, 1, SIDE + 1]), np.array([1, SIDE + 2, SIDE + 1])
    faces = np.zeros(2 * SIDE**2, [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"] = 3
    faces["corners"] = np.vstack([corner[:, None] + below, corner[:, None] + above])
    path = tmp_path / "carpet.ply"
    with path.open("wb") as file:
        file.write(files.ply_header(len(x), len(faces)).encode())
        np.column_stack([x, y, 0 * x]).astype("<f4").tofile(file)
        faces.tofile(file)
    del faces
    with pytest.raises(MeshError, match="has 9999392 faces, over the limit of 9000000 faces"):
        read_mesh(path, max_faces=9_000_000)
    tracemalloc.start()
    try:
        mesh = read_mesh(path)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
        path.unlink()
    assert len(mesh.faces) == 2 * SIDE**2
    assert mesh.area == SIDE**2  # halves of whole numbers add up exactly
    assert peak < 1_500_000_000  # bytes; 1.2 GB at the time of writing

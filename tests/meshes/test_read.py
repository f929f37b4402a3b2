"""Every format is read back as it was written, by the test or by trimesh; what a reader decides is what docs/meshes.md says."""

import json
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.meshes import files
from viewgain.errors import ConfigError
from viewgain.meshes import TriangleMesh, read_mesh

MOVED = files.VERTICES + np.array([10, 0, 0])  # the glTF files stand in a node of their own


def assert_pyramid(mesh: TriangleMesh, vertices: np.ndarray = files.VERTICES) -> None:
    np.testing.assert_array_equal(files.soup(mesh.vertices, mesh.faces), files.soup(vertices, files.TRIANGLES))


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("binary.ply", files.ply()),
        ("big_endian.ply", files.ply(order=">")),
        ("latin.ply", files.ply().replace(b"a test", b"un caf\xe9")),
        ("ascii.ply", files.ply_header(form="ascii") + files.text(files.VERTICES) + files.counted()),
        ("no_last_newline.ply", (files.ply_header(form="ascii") + files.text(files.VERTICES) + files.counted()).rstrip()),
        ("windows.ply", files.ply_header(form="ascii").replace("\n", "\r\n") + files.text(files.VERTICES) + files.counted()),
        ("plain.off", files.off()),
        ("modelnet.off", files.off("OFF")),
        ("upper.OFF", files.off("# a comment\n\nOFF\n# another\n")),
        ("colours.off", files.off(after=" 0.5 0.5 0.5 1")),
        ("normals.off", files.off("NOFF\n", np.hstack([files.VERTICES, files.VERTICES]))),
        ("plain.obj", files.obj()),
        ("missing_material.obj", files.obj("mtllib nowhere.mtl\no pyramid\nusemtl gold\ns off\n")),
        ("tabs.obj", files.obj().replace(" ", "\t").replace("\n", "  \r\n")),
        ("latin.obj", files.obj("# caf\xe9\n").encode("latin-1")),
        ("indented.obj", files.obj().replace("f ", "  f ") + "# f 1 2 3\n"),
        ("several_materials.obj", files.obj().replace("f 2", "usemtl gold\nf 2").replace("f 4", "usemtl lead\nf 4")),
        ("binary.stl", files.stl()),
        ("longer_than_claimed.stl", files.stl() + b"note"),
        ("ascii.stl", files.stl_text()),
        ("upper.stl", files.stl_text().upper()),
        ("named.stl", files.stl_text().replace("pyramid", "vertex 3 solid")),
    ],
)
def test_written_by_hand(tmp_path: Path, name: str, content: bytes | str) -> None:
    assert_pyramid(read_mesh(files.put(tmp_path, name, content)))


@pytest.mark.parametrize("extension", ["ply", "obj", "stl", "off", "glb"])
def test_written_by_trimesh(tmp_path: Path, extension: str) -> None:
    ball = trimesh.creation.icosphere(subdivisions=2)
    mesh = read_mesh(files.put(tmp_path, f"ball.{extension}", files.by_trimesh(extension, ball)))
    # Files hold float32 or at least 8 digits.
    np.testing.assert_allclose(mesh.bounds, ball.bounds, atol=1e-6)
    assert len(mesh.faces) == len(ball.faces)
    assert mesh.area == pytest.approx(ball.area, rel=1e-6)


def test_glb_and_gltf_apply_the_transforms_of_nodes(tmp_path: Path) -> None:
    assert_pyramid(read_mesh(files.put(tmp_path, "a.glb", files.glb())), MOVED)
    header, buffer = files.gltf(buffers=[{"byteLength": len(files.gltf()[1]), "uri": "with%20space.bin"}])
    files.put(tmp_path, "with space.bin", buffer)
    # trimesh looks the buffer up by its escaped name, the file has the plain one.
    assert_pyramid(read_mesh(files.put(tmp_path, "b.gltf", json.dumps(header))), MOVED)


def test_the_parts_of_a_scene_are_one_mesh(tmp_path: Path) -> None:
    scene = trimesh.Scene()
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3], [0, 0, 1])
    box = trimesh.creation.box(extents=(1, 2, 3))
    scene.add_geometry(box)
    scene.add_geometry(box, transform=turn)
    scene.add_geometry(trimesh.PointCloud([[100.0, 0, 0], [0, 100, 0]]))
    mesh = read_mesh(files.put(tmp_path, "scene.glb", scene.export(file_type="glb")))
    corners = np.vstack([box.vertices, trimesh.transform_points(box.vertices, turn)])
    assert len(mesh.faces) == 24
    np.testing.assert_allclose(mesh.bounds, [corners.min(axis=0), corners.max(axis=0)], atol=1e-6)  # float32 in the file


def test_obj_indices_that_count_backwards_mean_the_latest_vertices(tmp_path: Path) -> None:
    content = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3/-3 -2/-2/-1 -1//-1\nv 0 0 5\nv 1 0 5\nv 0 1 5\nf -3 -2 -1\n"
    mesh = read_mesh(files.put(tmp_path, "a.obj", content))
    np.testing.assert_array_equal(mesh.triangles[:, :, 2], [[0, 0, 0], [5, 5, 5]])


def test_obj_with_textures_continued_lines_and_other_records(tmp_path: Path) -> None:
    content = "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 # corner\nvt 0 0\nvn 0 0 1\nl 1 2\np 1\nf 1/1/1 \\\n 2/1/1 3/1/1\n"
    mesh = read_mesh(files.put(tmp_path, "a.obj", content))
    np.testing.assert_array_equal(mesh.triangles, [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
def test_ply_with_other_elements_and_properties(tmp_path: Path, form: str) -> None:
    header = "\n".join(
        [
            f"ply\nformat {form} 1.0\nelement camera 2\nproperty list uchar float lens\nproperty int id",
            "element vertex 3\nproperty uchar red\nproperty double z\nproperty double y\nproperty double x",
            "element face 2\nproperty uchar red\nproperty list uchar uint vertex_index\nproperty list uchar float texcoord",
            "element edge 1\nproperty int a\nend_header\n",
        ]
    )
    rows: list[tuple[str, tuple[float, ...]]] = [("B1fi", (1, 0.5, 7)), ("B1fi", (1, 0.25, 8))]
    rows += [("Bddd", (9, z, y, x)) for x, y, z in ((0, 0, 0), (1, 0, 2), (0, 1, 0))]
    rows += [("BB3IB6f", (9, 3, *corners, 6, 0, 0, 0.5, 0.5, 1, 1)) for corners in ((0, 1, 2), (2, 1, 0))]
    rows += [("i", (1,))]
    if form == "ascii":
        body = "".join(" ".join(map(str, numbers)) + "\n" for _, numbers in rows).encode()
    else:
        body = b"".join(struct.pack("<" + kinds, *numbers) for kinds, numbers in rows)
    mesh = read_mesh(files.put(tmp_path, "a.ply", header.encode() + body))
    np.testing.assert_array_equal(mesh.vertices, [[0, 0, 0], [1, 0, 2], [0, 1, 0]])
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [2, 1, 0]])


def test_a_polygon_becomes_a_fan_and_keeps_its_area(tmp_path: Path) -> None:
    angles = np.linspace(0, 2 * np.pi, 7, endpoint=False)
    ring = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    mesh = read_mesh(files.put(tmp_path, "a.ply", files.ply((tuple(range(7)),), vertices=ring)))
    assert len(mesh.faces) == 5
    assert mesh.area == pytest.approx(7 / 2 * np.sin(2 * np.pi / 7), rel=1e-6)  # the file is float32


@pytest.mark.parametrize("extension", ["off", "obj", "ply"])
def test_polygons_of_many_sizes(tmp_path: Path, extension: str) -> None:
    # A triangle, a square and a pentagon side by side, 0.5 + 1 + 1.5.
    points = "0 0 0\n1 0 0\n0 1 0\n2 0 0\n3 0 0\n3 1 0\n2 1 0\n4 0 0\n5 0 0\n5 1 0\n4.5 2 0\n4 1 0\n"
    faces = ("0 1 2", "3 4 5 6", "7 8 9 10 11")
    rows = "".join(f"{len(face.split())} {face}\n" for face in faces)
    ones = "".join("f " + " ".join(str(int(corner) + 1) for corner in face.split()) + "\n" for face in faces)
    content = {
        "off": f"OFF\n12 3 0\n{points}{rows}",
        "ply": files.ply_header(12, 3, "ascii") + points + rows,
        "obj": "v " + points.strip().replace("\n", "\nv ") + "\n" + ones,
    }[extension]
    mesh = read_mesh(files.put(tmp_path, f"a.{extension}", content))
    assert len(mesh.faces) == 6
    assert mesh.area == 3


def test_degenerate_faces_and_unused_vertices_are_dropped(tmp_path: Path) -> None:
    vertices = "".join(f"v {x} {y} 0\n" for x, y in ((9, 9), (0, 0), (0.1, 0.1), (0.3, 0.3), (1, 0), (0, 1))) + "v nan inf 0\n"
    faces = "f 2 3 4\nf 2 2 5\nf 2 5 6\nf 4 4 4\nf 2 5\nf 2\n"  # a line, a doubled corner, the triangle, a point, and no polygons
    mesh = read_mesh(files.put(tmp_path, "a.obj", vertices + faces))
    np.testing.assert_array_equal(mesh.vertices, [[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2]])


@pytest.mark.parametrize("scale", [1e-30, 1e-6, 1.0, 1e6, 1e30])
def test_what_is_degenerate_does_not_depend_on_the_unit(tmp_path: Path, scale: float) -> None:
    line = np.outer([0.1, 0.3, 0.7], [0.1, 0.3, 0.7])  # in float64 its triangle has a tiny area
    points = np.vstack([line, [[1, 0, 0], [1, 1e-6, 0]]]) * scale
    mesh = read_mesh(files.put(tmp_path, "a.obj", files.text(points, "v ") + "f 1 2 3\nf 1 4 5\n"))
    assert len(mesh.faces) == 1


def test_open_non_manifold_and_duplicated_triangles_stay(tmp_path: Path) -> None:
    three_at_an_edge = "f 1 2 3\nf 1 2 4\nf 1 2 5\n"
    points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\n"
    mesh = read_mesh(files.put(tmp_path, "a.obj", points + three_at_an_edge + "f 1 2 3\nf 3 2 1\n"))
    assert len(mesh.faces) == 5
    assert mesh.area == pytest.approx(2.5)


def test_the_limit_is_inclusive_and_must_be_positive(tmp_path: Path) -> None:
    path = files.put(tmp_path, "a.ply", files.ply())
    assert len(read_mesh(path, max_faces=6).faces) == 6
    with pytest.raises(ConfigError, match="max_faces"):
        read_mesh(path, max_faces=0)


def test_the_mesh_is_named_after_its_file(tmp_path: Path) -> None:
    path = files.put(tmp_path, "a.stl", files.stl())
    assert read_mesh(str(path)).name == str(path)

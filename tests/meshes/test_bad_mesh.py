"""Every bad mesh gives one line that names the file, the cause and the way out; nothing else ever comes through."""

import copy
import json
import os
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.meshes import files
from viewgain.errors import MeshError
from viewgain.meshes import TriangleMesh, read_mesh

Maker = Callable[[Path], Path]
FOUR = "3 0 1 2\n3 0 1 4\n3 0 1 2\n3 0 1 4\n"
NO_FACE_ELEMENT = files.ply_header(form="ascii").split("element face")[0] + "end_header\n"
LINE = np.outer([0.1, 0.2, 0.3, 0.7, 0.9], [0.1, 0.3, 0.7])  # to the last digit, not exactly
HUGE = 10_000_000
GOOD = {
    "a.ply": files.ply(),
    "ascii.ply": (files.ply_header(form="ascii") + files.text(files.VERTICES) + files.counted()).encode(),
    "a.off": files.off().encode(),
    "a.obj": files.obj().encode(),
    "a.stl": files.stl(),
    "ascii.stl": files.stl_text().encode(),
    "a.glb": files.glb(),
    "a.gltf": json.dumps(files.gltf()[0]).encode(),
}


def put(name: str, content: bytes | str) -> Maker:
    return lambda folder: files.put(folder, name, content)


def folder(path: Path) -> Path:
    (path / "a.ply").mkdir()
    return path / "a.ply"


def pipe(path: Path) -> Path:
    os.mkfifo(path / "a.ply")
    return path / "a.ply"


def link_to_itself(path: Path) -> Path:
    (path / "a.ply").symlink_to(path / "a.ply")
    return path / "a.ply"


def ascii_ply(vertices: str, faces: str, counts: tuple[int, int]) -> str:
    return files.ply_header(*counts, form="ascii") + vertices + faces


def gltf_buffer(uri: str, length: int = 96) -> str:
    return json.dumps(files.gltf(buffers=[{"byteLength": length, "uri": uri}])[0])


def accessor(index: int, **changes: object) -> bytes:
    header = copy.deepcopy(files.gltf()[0])
    header["accessors"][index] |= changes  # type: ignore[index]
    return files.glb(header)


def without_view(index: int) -> bytes:
    header = copy.deepcopy(files.gltf()[0])
    del header["accessors"][index]["bufferView"]  # type: ignore[index]
    return files.glb(header)


def points_only() -> bytes:
    return files.glb(meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "mode": 0}]}])


def nested(depth: int) -> list[dict[str, object]]:
    return [*({"children": [index + 1]} for index in range(depth)), {"mesh": 0}]


BAD: dict[str, tuple[Maker, str]] = {
    "missing": (lambda path: path / "nowhere.ply", "no such file"),
    "folder": (folder, "is a folder"),
    "pipe": (pipe, "not a regular file"),
    "link to itself": (link_to_itself, "a.ply"),
    "unknown extension": (put("a.fbx", "Kaydara"), "unknown type of file '.fbx'; wanted one of .ply"),
    "no extension": (put("mesh", "?"), "unknown type"),
    "ill-named": (put("a\nb.ply", "?"), "not a PLY"),
    **{f"empty {name}": (put(name, b""), "empty") for name in GOOD},
    **{f"garbage {name}": (put(name, b"\x93\xff\x00garbage" * 40), name) for name in GOOD},
    **{f"zeros {name}": (put(name, bytes(5000)), name) for name in GOOD},
    # wrong type
    "obj called ply": (put("a.ply", files.obj()), "not a PLY"),
    "ply called off": (put("a.off", files.ply()), "not an OFF"),
    "ply called obj": (put("a.obj", files.ply()), "no faces"),
    "ply called stl": (put("a.stl", files.ply()), "truncated"),
    "stl called glb": (put("a.glb", files.stl()), "no .glb file"),
    "json called gltf": (put("a.gltf", '{"points": []}'), "no faces"),
    "list called gltf": (put("a.gltf", "[]"), "no .gltf file"),
    "deep json called gltf": (put("a.gltf", "[" * 100_000), "damaged"),
    "glTF 1": (put("a.glb", b"glTF\x01" + bytes(40)), "no .glb file"),
    # truncated
    "short binary ply": (put("a.ply", files.ply()[:-3]), "truncated"),
    "ply without faces left": (put("a.ply", files.ply()[: -len(files.TRIANGLES) * 13]), "no faces"),
    "short header": (put("a.ply", files.ply()[:60]), "end_header"),
    "short ascii ply": (put("a.ply", ascii_ply(files.text(files.VERTICES), FOUR, (5, 5))), "claims 10 rows but only 9"),
    "faces of two sizes": (put("a.ply", files.ply(files.POLYGONS)), "as many corners in every face as in the first"),
    "faces of three sizes": (put("a.ply", files.ply(((0, 3, 2, 1), (0, 1, 0, 1, 0), (0, 1, 4)))), "a.ply"),  # as long as 3 quads
    "short row": (put("a.ply", ascii_ply(files.text(files.VERTICES), "3 0 1 2\n4 0 1 4\n", (5, 2))), "claims 7 rows but only 6"),
    "short vertex": (put("a.ply", ascii_ply("0 0 0\n1 0\n0 1 0\n", "3 0 1 2\n", (3, 1))), "damaged"),
    "short off": (put("a.off", files.off()[:-8]), "claims 10 rows but only 9"),
    "off without counts": (put("a.off", "OFF\n"), "counts"),
    "off with a negative count": (put("a.off", "OFF\n-3 1 0\n"), "two counts"),
    "off with letters": (put("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 x 0\n3 0 1 2\n"), "damaged"),
    "binary off": (put("a.off", b"OFF BINARY\n" + bytes(100)), "two counts"),
    "short stl": (put("a.stl", files.stl()[:-60]), "truncated"),
    "very short stl": (put("a.stl", files.stl()[:50]), "stl"),
    "short ascii stl": (put("a.stl", files.stl_text()[:300]), "endsolid"),
    "two vertices in a facet": (put("a.stl", files.stl_text().replace("vertex", "note", 1)), "damaged"),
    "short glb": (put("a.glb", files.glb()[:-10]), "truncated"),
    "short obj line": (put("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1\n"), "no faces"),
    # no faces
    "point cloud ply": (put("a.ply", files.ply(())), "point cloud"),
    "cloud without face element": (put("a.ply", NO_FACE_ELEMENT), "point cloud"),
    "point cloud obj": (put("a.obj", files.text(files.VERTICES, "v ")), "no faces"),
    "point cloud off": (put("a.off", "OFF\n5 0 0\n" + files.text(files.VERTICES)), "no faces"),
    "empty stl": (put("a.stl", files.stl(0)[:84]), "no faces"),
    "empty ascii stl": (put("a.stl", "solid a\nendsolid a\n"), "no faces"),
    "points glb": (put("a.glb", points_only()), "no faces"),
    "glb without anything": (put("a.glb", files.glb({"asset": {"version": "2.0"}})), "a.glb"),
    "lines only": (put("a.ply", files.ply(((0, 1), (1, 2)))), "no faces"),
    # no surface, no numbers
    "all on a line": (put("a.off", files.off(vertices=LINE)), "no area"),
    "all on a point": (put("a.off", files.off(vertices=0 * files.VERTICES)), "no area"),
    "NaN": (put("a.ply", files.ply(vertices=np.where(files.VERTICES == 3, np.nan, files.VERTICES))), "not finite"),
    "infinite": (put("a.ply", files.ply(vertices=np.where(files.VERTICES == 3, np.inf, files.VERTICES))), "not finite"),
    "NaN obj": (put("a.obj", files.obj().replace("3.0", "nan")), "not finite"),
    "too large to square": (put("a.obj", files.obj().replace(".0", "e200")), "scale it down"),
    # indices
    "index too large": (put("a.ply", files.ply((*files.TRIPLES, (0, 1, 5)))), "0 to 5 (counted from 0) but there are 5"),
    "index negative": (put("a.ply", files.ply((*files.TRIPLES, (0, 1, -1)))), "vertices -1 to 4"),
    "obj index 0": (put("a.obj", files.obj() + "f 0 1 2\n"), "'f 0 1 2' names a vertex before the first"),
    "obj index too large": (put("a.obj", files.obj() + "f 1 2 6\n"), "index 5 is out of bounds"),
    "obj index too negative": (put("a.obj", files.obj() + "f 1 2 -6\n"), "'f 1 2 -6' names a vertex before the first"),
    "obj index beyond 32 bits": (put("a.obj", files.obj() + f"f 1 2 {2**32 + 3}\n"), "out of bounds"),
    "obj index beyond 64 bits": (put("a.obj", files.obj() + f"f 1 2 {2**70}\n"), "damaged"),
    "off index too large": (put("a.off", files.off().replace("3 3 0 4", "3 3 0 5")), "0 to 5 (counted from 0) but there are 5"),
    "glb index too large": (put("a.glb", accessor(0, count=4)), "damaged"),
    # headers that lie
    "ply claims faces": (put("a.ply", files.ply().replace(b"face 6", b"face 9999999")), "truncated"),
    "ply claims vertices": (put("a.ply", files.ply().replace(b"vertex 5", b"vertex 9999999")), "length is not"),
    "ascii ply claims faces": (put("a.ply", ascii_ply(files.text(files.VERTICES), files.counted(), (5, 9_999_999))), "truncated"),
    "ply claims more than any": (put("a.ply", files.ply().replace(b"face 6", b"face 9999999999999999")), "limit of 10000000"),
    "ply claims a long list": (put("a.ply", files.ply(((0, 1, 2),)).replace(b"\x03\0\0\0\0", b"\xff\0\0\0\0")), "truncated"),
    "ply with a negative count": (put("a.ply", files.ply().replace(b"face 6", b"face -5")), "no faces"),
    "ply of unknown type": (put("a.ply", files.ply().replace(b"float x", b"quad x")), "'quad'"),
    "ply without z": (put("a.ply", files.ply().replace(b"float z", b"float w")), "no field of name z"),
    "ply with two x": (put("a.ply", files.ply().replace(b"float z", b"float x")), "truncated, damaged"),
    "off claims faces": (put("a.off", files.off().replace("5 5 0", f"5 {HUGE} 0")), "truncated"),
    "off claims vertices": (put("a.off", files.off().replace("5 5 0", f"{HUGE} 5 0")), "truncated"),
    "stl claims facets": (put("a.stl", files.stl(HUGE)), f"claims {HUGE} facets"),
    "glb camera on a mesh": (put("a.glb", files.glb(nodes=[{"mesh": 0, "camera": 0}])), "without cameras"),
    "glb claims corners": (put("a.glb", accessor(1, count=HUGE)), "truncated"),
    "glb claims a negative count": (put("a.glb", accessor(1, count=-3)), "a.glb"),
    "glb claims zeros": (put("a.glb", without_view(0)), "compressed"),
    "glb is quantised": (put("a.glb", accessor(0, normalized=True)), "quantised"),
    "glb nodes in a circle": (put("a.glb", files.glb(nodes=[{"children": [1]}, {"children": [0], "mesh": 0}])), "in a circle"),
    "glb nodes too deep": (put("a.glb", files.glb(nodes=nested(5000))), "256 deep"),
    "glb node that is not there": (put("a.glb", files.glb(nodes=[{"children": [7]}])), "a.glb"),
    "gltf without its buffer": (put("a.gltf", gltf_buffer("a.bin")), "its buffer 'a.bin' is no file beside it"),
    "gltf with a device for a buffer": (put("a.gltf", gltf_buffer("/dev/zero")), "no file beside it"),
    "gltf with a buffer elsewhere": (put("a.gltf", gltf_buffer("../a.bin")), "no file beside it"),
    "gltf with a buffer on the web": (put("a.gltf", gltf_buffer("https://example.com/a.bin")), "no file beside it"),
    "gltf with a short buffer": (put("a.gltf", gltf_buffer("data:;base64,AAAA")), "truncated"),
}  # fmt: skip


def refused(path: Path, **settings: int) -> str:
    with pytest.raises(MeshError) as caught:
        read_mesh(path, **settings)
    message = str(caught.value)
    assert message.isprintable()
    assert ";" in message or "," in message  # what was got, and what was wanted or what to do
    return message


def mesh_or_none(path: Path) -> TriangleMesh | None:
    """Read what may be damaged; whatever is refused is refused as it should be."""
    try:
        return read_mesh(path)
    except MeshError as error:
        message = str(error)
    assert message.isprintable()
    assert str(path.parent) in message
    return None


@pytest.mark.parametrize("case", BAD)
def test_bad_file(tmp_path: Path, case: str) -> None:
    make, expected = BAD[case]
    path = make(tmp_path)
    message = refused(path)
    assert message.startswith(str(path).replace("\n", "?"))
    assert expected in message


@pytest.mark.parametrize("case", [case for case in BAD if "claims" in case])
def test_nothing_is_allocated_on_the_word_of_a_header(tmp_path: Path, case: str) -> None:
    path = BAD[case][0](tmp_path)
    refused(path)  # what is imported and cached on the way is not what is measured
    tracemalloc.start()
    try:
        refused(path)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 1_000_000  # bytes; what these headers claim is 20 MB and more


@pytest.mark.parametrize("name", [name for name in GOOD if name != "a.gltf"])
def test_more_faces_than_wanted(tmp_path: Path, name: str) -> None:
    message = refused(files.put(tmp_path, name, GOOD[name]), max_faces=5)
    assert "over the limit of 5 faces" in message
    assert "raise max_faces" in message


def test_many_instances_of_a_part_count_each(tmp_path: Path) -> None:
    nodes = [{"children": list(range(1, 101))}, *({"mesh": 0} for _ in range(100))]
    path = files.put(tmp_path, "a.glb", files.glb(nodes=nodes))
    assert len(read_mesh(path, max_faces=600).faces) == 600
    assert "has 600 faces" in refused(path, max_faces=599)


def test_a_file_that_may_not_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = files.put(tmp_path, "a.ply", files.ply())

    def denied(_: Path) -> bytes:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "read_bytes", denied)  # as root, who runs the tests in a container, may read everything
    assert "Permission denied" in refused(path)


@pytest.mark.parametrize("name", GOOD)
def test_a_file_of_more_than_two_gigabytes_is_not_read(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    with path.open("wb") as file:
        file.truncate(2**31 + 1)  # a hole: it takes no room on the disk
    assert "over the limit of 2.15 GB" in refused(path)


@pytest.mark.parametrize("name", ["a.obj", "a.off"])
def test_a_text_of_more_than_a_quarter_gigabyte_is_not_decoded(tmp_path: Path, name: str) -> None:
    path = files.put(tmp_path, name, GOOD[name])
    with path.open("ab") as file:
        file.truncate(250_000_001)
    assert "over the limit of 0.25 GB" in refused(path)


@pytest.mark.parametrize("name", GOOD)
def test_cut_off_anywhere(tmp_path: Path, name: str) -> None:
    for length in range(1, len(GOOD[name])):
        path = files.put(tmp_path, name, GOOD[name][:length])
        mesh = mesh_or_none(path)
        if mesh is not None:
            # Text that was cut between lines, inside its last number, or within what is no geometry.
            assert name in ("ascii.ply", "a.off", "a.obj", "ascii.stl")
            assert 1 <= len(mesh.faces) <= 6


@settings(max_examples=400)
@given(data=st.data())
def test_damaged_anywhere(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(sorted(GOOD)))
    content = bytearray(GOOD[name])
    places = st.tuples(st.integers(0, len(content) - 1), st.integers(0, 255))
    for place, value in data.draw(st.lists(places, min_size=1, max_size=8)):
        content[place] = value
    path = files.put(tmp_path_factory.getbasetemp(), f"damaged/{name}", bytes(content))
    mesh = mesh_or_none(path)
    assert mesh is None or mesh.area > 0

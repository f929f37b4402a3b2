"""Every bad file gives one line that names the file, the cause and the way out; nothing else ever comes through."""

import json
import os
import struct
import tracemalloc
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.scans import files
from viewgain.errors import ConfigError, ScanError
from viewgain.scans import read_scan

Maker = Callable[[Path], Path]


def put(name: str, content: bytes | str) -> Maker:
    return lambda folder: files.put(folder, name, content)


def beside(name: str, content: bytes, sidecar: str) -> Maker:
    def make(folder: Path) -> Path:
        files.put(folder, "intrinsics.json", sidecar)
        return files.put(folder, name, content)

    return make


def folder_named(name: str) -> Maker:
    def make(folder: Path) -> Path:
        (folder / name).mkdir()
        return folder / name

    return make


def pipe(folder: Path) -> Path:
    os.mkfifo(folder / "pipe.ply")
    return folder / "pipe.ply"


def ply_header(vertices: str, form: str = "binary_little_endian") -> bytes:
    lines = [
        "ply",
        f"format {form} 1.0",
        f"element vertex {vertices}",
        *(f"property float {name}" for name in "xyz"),
        "end_header",
        "",
    ]
    return "\n".join(lines).encode()


def pcd_header(points: int, data: str, **changes: str) -> bytes:
    rows = {"VERSION": "0.7", "FIELDS": "x y z", "SIZE": "4 4 4", "TYPE": "F F F", "COUNT": "1 1 1", "WIDTH": str(points)}
    rows |= {"HEIGHT": "1", "VIEWPOINT": "0 0 0 1 0 0 0", "POINTS": str(points), "DATA": data} | changes
    return "".join(f"{key} {value}\n" for key, value in rows.items() if value).encode()


def npy_header(shape: tuple[int, ...], kind: str = "<f4") -> bytes:
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    text += b" " * (-(len(text) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text


def npz_with_wrong_size(folder: Path) -> Path:
    """An archive whose directory and whose array header both claim 2 GB."""
    path = folder / "lie.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("points.npy", npy_header((180_000_000, 3)) + bytes(1200))
        archive.infolist()[0].file_size = 2_160_000_128
    return path


def pickle_npy() -> bytes:
    return npy_header((200, 3), "|O") + b"cos\nsystem\n(S'true'\ntR." * 30


def object_npz(folder: Path) -> Path:
    np.savez(folder / "object.npz", points=np.array([{"a": 1}] * 200, dtype=object))
    return folder / "object.npz"


def huge_png() -> bytes:
    """A depth image whose (correctly checked) header claims 2.4 GB."""
    data = files.png(files.counts())
    header = b"IHDR" + struct.pack(">II", 30000, 40000) + data[24:29]
    return data[:12] + header + struct.pack(">I", zlib.crc32(header)) + data[33:]


GARBAGE = np.random.default_rng(7).integers(0, 256, 5000, dtype=np.uint8).tobytes()
CLOUD = files.cloud()
FEW = files.cloud(99)
NOTHING = np.full((200, 3), np.nan)
TWO_BILLION = 180_000_000  # points of 12 bytes: 2.2 GB

CASES: dict[str, tuple[Maker, str]] = {
    "missing": (lambda folder: folder / "missing.ply", "no such file"),
    "missing of unknown type": (lambda folder: folder / "missing", "no such file"),
    "folder": (folder_named("folder.ply"), "is a folder"),
    "pipe": (pipe, "not a regular file"),
    "unknown extension": (put("scan.docx", b"hello"), r"unknown type of file '.docx'; wanted one of .ply .pcd"),
    "no extension": (put("scan", b"hello"), "unknown type of file"),
    **{
        f"empty {suffix}": (put(f"scan.{suffix}", b""), "is empty")
        for suffix in ("ply", "pcd", "npy", "npz", "png", "csv", "foo")
    },
    **{
        f"garbage {suffix}": (put(f"scan.{suffix}", GARBAGE), "is not a") for suffix in ("ply", "pcd", "npy", "npz", "png", "xyz")
    },
    "png named ply": (put("scan.ply", files.png(files.counts())), "is not a PLY file: it looks like a .png file"),
    "ply named csv": (put("scan.csv", files.ply(files.xyz(CLOUD))), "is not a text file"),
    "ply without end": (put("scan.ply", ply_header("500")[:40]), "no end_header"),
    "ply of garbage": (put("scan.ply", b"ply\n" + GARBAGE), "no end_header"),
    "ply unknown format": (put("scan.ply", ply_header("500", "middle_endian")), "format 'middle_endian'"),
    "ply unknown type": (put("scan.ply", ply_header("500").replace(b"float", b"quux")), "'property quux x' makes no sense"),
    "ply negative count": (put("scan.ply", ply_header("-5")), "'element vertex -5' makes no sense"),
    "ply word count": (put("scan.ply", ply_header("many")), "makes no sense"),
    "ply without z": (
        put("scan.ply", ply_header("500").replace(b"property float z\n", b"")),
        "no vertex element with x, y and z",
    ),
    "ply without vertices": (put("scan.ply", ply_header("0")), "no vertices"),
    "ply list first": (put("scan.ply", ply_header("9").replace(b"float z", b"list uchar int z")), "list properties"),
    "ply 2 GB": (put("scan.ply", ply_header(str(TWO_BILLION)) + bytes(1200)), "claims 180000000 vertices .* only 1200 bytes"),
    "ply ascii 2 GB": (
        put("scan.ply", ply_header(str(TWO_BILLION), "ascii") + b"1 2 3\n"),
        "claims 180000000 rows but only 1 follow",
    ),
    "ply beyond integers": (put("scan.ply", ply_header("9" * 30) + bytes(1200)), "claims 9{30} vertices"),
    "ply ascii short row": (
        put("scan.ply", files.ply(files.xyz(CLOUD), "ascii")[:-30]),
        "row 150 of the PLY has 2 numbers, wanted 3",
    ),
    "pcd without data": (put("scan.pcd", pcd_header(500, "")), "no DATA line"),
    "pcd without fields": (put("scan.pcd", pcd_header(500, "binary", FIELDS="")), "lacks or garbles 'FIELDS'"),
    "pcd other fields": (put("scan.pcd", pcd_header(500, "binary", FIELDS="a b c")), "wanted x, y and z"),
    "pcd lengths": (put("scan.pcd", pcd_header(500, "binary", SIZE="4 4")), "differ in length"),
    "pcd size 3": (put("scan.pcd", pcd_header(500, "binary", SIZE="3 3 3")), "impossible combination"),
    "pcd width": (put("scan.pcd", pcd_header(500, "binary", WIDTH="499")), "WIDTH 499 x HEIGHT 1 is not POINTS 500"),
    "pcd viewpoint": (put("scan.pcd", pcd_header(500, "binary", VIEWPOINT="0 0 0")), "VIEWPOINT has 3 numbers"),
    "pcd encoding": (put("scan.pcd", pcd_header(500, "zip")), "DATA zip"),
    "pcd no points": (put("scan.pcd", pcd_header(0, "binary")), "no points"),
    "pcd 2 GB": (put("scan.pcd", pcd_header(TWO_BILLION, "binary") + bytes(1200)), "claims 180000000 points .* only 1200 bytes"),
    "pcd ascii 2 GB": (put("scan.pcd", pcd_header(TWO_BILLION, "ascii") + b"1 2 3\n"), "only 1 rows follow"),
    "pcd packed 2 GB": (
        put("scan.pcd", pcd_header(TWO_BILLION, "binary_compressed") + struct.pack("<II", 1000, 2_160_000_000) + bytes(1000)),
        "the file is damaged",
    ),
    "pcd packed garbage": (
        put("scan.pcd", pcd_header(200, "binary_compressed") + struct.pack("<II", 1000, 2400) + GARBAGE[:1000]),
        "error in compressed data",
    ),
    "npy 2 GB": (put("scan.npy", npy_header((TWO_BILLION, 3)) + bytes(1200)), "claims an array of shape .* only 1200 bytes"),
    "npy beyond integers": (put("scan.npy", npy_header((2**40, 2**40)) + bytes(1200)), "claims an array"),
    "npy negative": (put("scan.npy", npy_header((-3, 3)) + bytes(1200)), "impossible shape"),
    "npy header": (put("scan.npy", npy_header((200, 3)).replace(b"shape", b"shade")), "header is truncated or damaged"),
    "npy pickle": (put("scan.npy", pickle_npy()), "wanted plain numbers"),
    "npy text": (put("scan.npy", files.npy(np.array(["a"] * 200))), "holds <U1, wanted plain numbers"),
    "npy shape": (put("scan.npy", files.npy(np.zeros((4, 4, 4, 3)))), r"got an array of shape \(4, 4, 4, 3\)"),
    "npy depth without camera": (put("scan.npy", files.npy(files.counts())), "16 x 12 pixels needs its camera"),
    "npz 2 GB": (npz_with_wrong_size, "claims 2160000128 bytes in 1328 packed ones"),
    "npz pickle": (object_npz, "wanted plain numbers"),
    "npz keys": (put("scan.npz", files.npz(a=CLOUD, b=CLOUD)), "has the keys a, b; wanted one of points"),
    "npz no keys": (put("scan.npz", files.npz()), "has the keys none"),
    "npz normals": (put("scan.npz", files.npz(points=CLOUD, normals=CLOUD[:50])), "got normals of shape"),
    "npz depth without camera": (put("scan.npz", files.npz(z=files.counts())), "needs its camera"),
    "text words": (put("scan.xyz", "hello\nworld, this\nis text\n"), "is no row of numbers"),
    "text one column": (put("scan.csv", "1\n2\n3\n"), "is no row of numbers"),
    "text header only": (put("scan.csv", "x,y,z\n"), "no line has three numbers"),
    "text names": (put("scan.csv", "a,b,c\n" + "1,2,3\n" * 200), "the columns are a, b, c; wanted x, y and z"),
    "text ragged": (put("scan.csv", "1,2,3\n" * 200 + "4,5"), "is the file truncated"),
    "png 8 bit": (
        put("scan.png", files.png(files.counts().astype(np.uint8))),
        "8-bit grey image, wanted a 16-bit grey depth image",
    ),
    "png colour": (put("scan.png", files.png(np.zeros((12, 16, 3), np.uint8))), "a colour image, wanted a 16-bit"),
    "png without camera": (put("scan.png", files.png(files.counts())), "put scan.json or intrinsics.json beside it"),
    "png 2 GB": (put("scan.png", huge_png()), "claims 30000 x 40000 pixels in"),
    "png header": (put("scan.png", files.png(files.counts())[:20] + b"????" + files.png(files.counts())[24:]), "damaged"),
    "png all zero": (beside("scan.png", files.png(np.zeros((12, 16), np.uint16)), files.camera_json()), "0 valid points"),
    "png saturated": (beside("scan.png", files.png(np.full((12, 16), 65535, np.uint16)), files.camera_json()), "0 valid points"),
    **{
        f"few {name}": (put(name, data), "99 valid points, wanted at least 100") for name, data in files.every_format(FEW).items()
    },
    **{
        f"invalid {name}": (put(name, data), "0 valid points, wanted at least 100")
        for name, data in files.every_format(NOTHING).items()
    },
}


@pytest.mark.parametrize("case", CASES)
def test_bad_scans_raise_one_line_that_names_the_file(tmp_path: Path, case: str) -> None:
    make, message = CASES[case]
    path = make(tmp_path)
    with pytest.raises(ScanError, match=message) as caught:
        read_scan(path)
    assert path.name in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize("case", [name for name in CASES if "2 GB" in name])
def test_a_header_that_lies_costs_no_memory(tmp_path: Path, case: str) -> None:
    path = CASES[case][0](tmp_path)
    with pytest.raises(ScanError):
        read_scan(path)  # imports the libraries
    tracemalloc.start()
    try:
        with pytest.raises(ScanError):
            read_scan(path)
        assert tracemalloc.get_traced_memory()[1] < 5_000_000
    finally:
        tracemalloc.stop()


MATRIX = files.POSE.tolist()
CAMERA_CASES: dict[str, tuple[str | bytes, str]] = {
    "not json": ("{fx: 1", "is not valid JSON"),
    "not text": (GARBAGE, "is not a text file"),
    "a list": ("[1, 2]", "holds a JSON list"),
    "empty object": ("{}", "lacks fx, fy, cx, cy"),
    "without fx": (files.camera_json().replace('"fx"', '"ffx"'), "lacks fx; wanted fx, fy, cx, cy .* found"),
    "text fx": (files.camera_json(fx="wide"), "got 'wide' for fx"),
    "true fx": (files.camera_json(fx=True), "got 'True' for fx"),
    "huge fx": (files.camera_json(fx=10**400), "for fx, wanted a finite number"),
    "infinite fx": (files.camera_json(fx=1e999), "for fx, wanted a finite number"),
    "negative fx": (files.camera_json(fx=-5), "positive focal lengths"),
    "other size": (files.camera_json(width=640, height=480), "640 x 480 pixels but .*scan.png has 16 x 12"),
    "half a pixel": (files.camera_json(width=16.5), "wanted whole numbers"),
    "without height": (json.dumps({"fx": 1, "fy": 1, "cx": 1, "cy": 1, "width": 16}), "lacks width or height"),
    "kind": (files.camera_json(depth_kind="slant"), "depth_kind 'slant', wanted 'z' or 'range'"),
    "scale": (files.camera_json(depth_scale=0), "got depth_scale 0"),
    "text scale": (files.camera_json(depth_scale="mm"), "got 'mm' for depth_scale"),
    "lens": (files.camera_json(distortion=[0.1] * 9), "9 distortion coefficients, wanted at most 8"),
    "lens words": (files.camera_json(distortion="strong"), "wanted a list of coefficients"),
    "fisheye": (files.camera_json(distortion=[0.1] * 4, model="kannala_brandt4"), "'kannala_brandt4' is not supported"),
    "matrix": (json.dumps({"width": 16, "height": 12, "intrinsic_matrix": [[1, 2], [3, 4]]}), "camera matrix is not 3x3"),
    "pose": (files.camera_json(camera_to_world=[1, 2, 3]), "camera_to_world: got 3 numbers"),
    "pose object": (files.camera_json(pose={"x": 1}), "pose: is not a matrix of numbers"),
    "pose not rigid": (files.camera_json(pose=np.diag([2.0, 2, 2, 1]).tolist()), "is not a rigid motion"),
}


@pytest.mark.parametrize("case", CAMERA_CASES)
@pytest.mark.parametrize("given", [True, False], ids=["given", "beside"])
def test_bad_camera_files_raise_one_line_that_names_them(tmp_path: Path, case: str, given: bool) -> None:
    content, message = CAMERA_CASES[case]
    scan = files.put(tmp_path, "scan.png", files.png(files.counts()))
    camera = files.put(tmp_path, "camera.json" if given else "scan.json", content)
    with pytest.raises(ConfigError, match=message) as caught:
        read_scan(scan, intrinsics=camera if given else None)
    assert camera.name in str(caught.value)
    assert "\n" not in str(caught.value)


POSE_CASES: dict[str, tuple[str, str | bytes, str]] = {
    "not json": ("pose.json", "[[1, 0", "is not valid JSON"),
    "no pose": ("pose.json", "{}", "has no pose; wanted a 4x4 matrix under camera_to_world"),
    "a word": ("pose.json", '"here"', "is not a matrix of numbers"),
    "ragged": ("pose.json", "[[1, 2], [3]]", "is not a matrix of numbers"),
    "deep": ("pose.json", "[" * 100_000, "is not valid JSON"),
    "not rigid": ("pose.json", json.dumps(np.ones((4, 4)).tolist()), "is not a rigid motion"),
    "words": ("pose.txt", "one two three", "wanted 16 numbers"),
    "three numbers": ("pose.txt", "1 2 3", "got 3 numbers"),
    "not text": ("pose.txt", GARBAGE, "is not a text file"),
}


@pytest.mark.parametrize("case", POSE_CASES)
def test_bad_pose_files_raise_one_line_that_names_them(tmp_path: Path, case: str) -> None:
    name, content, message = POSE_CASES[case]
    scan = files.put(tmp_path, "scan.npy", files.npy(CLOUD))
    pose = files.put(tmp_path, name, content)
    with pytest.raises(ConfigError, match=message) as caught:
        read_scan(scan, camera_to_world=pose)
    assert pose.name in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_camera_and_pose_files_are_named(tmp_path: Path) -> None:
    scan = files.put(tmp_path, "scan.png", files.png(files.counts()))
    with pytest.raises(ConfigError, match=r"gone\.json: no such intrinsics file"):
        read_scan(scan, intrinsics=tmp_path / "gone.json")
    with pytest.raises(ConfigError, match=r"gone\.txt: no such pose file"):
        read_scan(scan, intrinsics=files.CAMERA, camera_to_world=tmp_path / "gone.txt")
    with pytest.raises(ConfigError, match="no such intrinsics file"):
        read_scan(scan, intrinsics=tmp_path)


def test_bad_arguments(tmp_path: Path) -> None:
    scan = files.put(tmp_path, "scan.npy", files.npy(CLOUD))
    with pytest.raises(ConfigError, match="got 'inch', wanted 'm' or 'mm'"):
        read_scan(scan, units="inch")
    with pytest.raises(ConfigError, match="min_amplitude: got nan"):
        read_scan(scan, min_amplitude=float("nan"))
    with pytest.raises(ScanError, match="has none; give amplitude="):
        read_scan(scan, min_amplitude=5)
    with pytest.raises(ConfigError, match="camera_to_world: could not convert string to float"):
        read_scan(scan, camera_to_world=np.array(["here"]))
    with pytest.raises(ConfigError, match=r"^camera_to_world: got an array .* wanted a 4x4 pose matrix"):
        read_scan(scan, camera_to_world=np.eye(3))
    ply = files.put(tmp_path, "scan.ply", files.ply(files.xyz(CLOUD)))
    with pytest.raises(ScanError, match=r"scan\.ply: is an unorganised cloud, .* leave them out"):
        read_scan(ply, intrinsics=files.CAMERA)


def test_an_unreadable_file_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scan = files.put(tmp_path, "scan.npy", files.npy(CLOUD))

    def refuse(self: Path) -> bytes:
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "read_bytes", refuse)
    with pytest.raises(ScanError, match=r"scan\.npy: cannot be read \(Permission denied\)"):
        read_scan(scan)


def test_too_large_a_file_is_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "large.ply"
    with path.open("wb") as file:
        file.truncate(2**31)  # sparse: takes no room on the disk
    with pytest.raises(ScanError, match=r"2\.1 GB is larger than any depth scan"):
        read_scan(path)

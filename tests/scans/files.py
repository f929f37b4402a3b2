"""Scan files of every format, written byte by byte or by another library, so that the readers are tested against others."""

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from pypcd4 import Encoding, PointCloud

from viewgain.camera import Intrinsics

CAMERA = Intrinsics(width=16, height=12, fx=20.0, fy=21.0, cx=7.25, cy=5.75)
POSE = np.array([[0.0, -1.0, 0.0, 0.3], [1.0, 0.0, 0.0, -0.2], [0.0, 0.0, 1.0, 1.5], [0.0, 0.0, 0.0, 1.0]])


def cloud(count: int = 150, seed: int = 0) -> np.ndarray:
    """A cloud in front of the camera, metres."""
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(-0.4, 0.4, (count, 2)), rng.uniform(0.6, 1.5, count)])


def unit_vectors(count: int = 150, seed: int = 1) -> np.ndarray:
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def counts(camera: Intrinsics = CAMERA, seed: int = 0) -> np.ndarray:
    """A depth image of 600 to 1500 counts with one pixel of no return."""
    image = np.random.default_rng(seed).integers(600, 1500, (camera.height, camera.width)).astype(np.uint16)
    image[0, 0] = 0
    return image


def ply(columns: dict[str, np.ndarray], form: str = "binary_little_endian", *, header: str = "", footer: bytes = b"") -> bytes:
    """A PLY with float64 columns; ``header`` are more header lines after the vertices, ``footer`` their data."""
    names = [f"property double {name}" for name in columns]
    count = len(next(iter(columns.values())))
    lines = ["ply", f"format {form} 1.0", "comment made by a test", f"element vertex {count}", *names]
    head = "\n".join([*lines, *header.splitlines(), "end_header", ""]).encode()
    table = np.column_stack(list(columns.values()))
    if form == "ascii":
        body = "".join(" ".join(repr(float(number)) for number in row) + "\n" for row in table).encode()
    else:
        body = table.astype("<f8" if form == "binary_little_endian" else ">f8").tobytes()
    return head + body + footer


def xyz(points: np.ndarray) -> dict[str, np.ndarray]:
    return {name: points[:, axis] for axis, name in enumerate("xyz")}


def pcd(
    points: np.ndarray,
    encoding: str = "binary",
    *,
    shape: tuple[int, int] | None = None,
    viewpoint: tuple[float, ...] | None = None,
) -> bytes:
    content = PointCloud.from_points(points, ("x", "y", "z"), (np.float64,) * 3)
    height, width = shape or (1, len(points))
    extra: dict[str, Any] = {"viewpoint": viewpoint} if viewpoint else {}
    content.metadata = content.metadata.model_copy(update={"height": height, "width": width, **extra})
    buffer = io.BytesIO()
    content.save(buffer, Encoding(encoding))
    return buffer.getvalue()


def npy(array: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def npz(**arrays: Any) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)
    return buffer.getvalue()


def png(image: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, format="PNG")
    return buffer.getvalue()


def text(points: np.ndarray, delimiter: str = " ", header: str = "") -> bytes:
    rows = (delimiter.join(repr(float(number)) for number in row) for row in points)
    return "\n".join([*([header] if header else []), *rows, ""]).encode()


def camera_json(camera: Intrinsics = CAMERA, **more: Any) -> str:
    names = ("width", "height", "fx", "fy", "cx", "cy")
    return json.dumps({name: getattr(camera, name) for name in names} | {"distortion": list(camera.distortion)} | more)


def put(folder: Path, name: str, content: bytes | str) -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def every_format(points: np.ndarray) -> dict[str, bytes]:
    """The same cloud in each of the formats, by file name."""
    return {
        "ascii.ply": ply(xyz(points), "ascii"),
        "little.ply": ply(xyz(points)),
        "big.ply": ply(xyz(points), "binary_big_endian"),
        "ascii.pcd": pcd(points, "ascii"),
        "binary.pcd": pcd(points, "binary"),
        "compressed.pcd": pcd(points, "binary_compressed"),
        "cloud.npy": npy(points),
        "cloud.npz": npz(points=points),
        "space.xyz": text(points),
        "tab.txt": text(points, "\t"),
        "comma.csv": text(points, ",", "x,y,z"),
        "semicolon.csv": text(points, ";"),
    }

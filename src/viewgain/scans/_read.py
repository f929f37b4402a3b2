"""The one door for scan files: chooses the reader, settles units, axes, pose and amplitude, and keeps errors to one line."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from viewgain.arrays import Array, Image, Pose
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError, MissingExtraError, ScanError, ViewgainError
from viewgain.scans._depth_image import decode_amplitude, read_depth_png
from viewgain.scans._frame import face_forward, unit_normals
from viewgain.scans._intrinsics_file import resolve_camera
from viewgain.scans._numpy import read_npy, read_npz
from viewgain.scans._pcd import read_pcd
from viewgain.scans._ply import read_ply
from viewgain.scans._pose_file import read_pose
from viewgain.scans._raw import MAGIC, PathLike, RawScan, load_bytes, one_line, printable
from viewgain.scans._scan import Scan
from viewgain.scans._text import read_text
from viewgain.scans._units import METRES_PER_UNIT, metres_per_unit

Reader = Callable[[Path, bytes, Intrinsics | Path | None], RawScan]


def _without_camera(reader: Callable[[Path, bytes], RawScan]) -> Reader:
    return lambda path, data, camera: reader(path, data)


READERS: dict[str, Reader] = {
    ".ply": _without_camera(read_ply),
    ".pcd": _without_camera(read_pcd),
    ".npy": read_npy,
    ".npz": read_npz,
    ".png": read_depth_png,
    **dict.fromkeys((".xyz", ".txt", ".csv", ".asc", ".pts"), _without_camera(read_text)),
}
"""The reader of each file extension."""


def read_scan(
    path: PathLike,
    *,
    intrinsics: Intrinsics | PathLike | None = None,
    amplitude: PathLike | Image | None = None,
    min_amplitude: float | None = None,
    camera_to_world: Pose | PathLike | None = None,
    units: str | None = None,
) -> Scan:
    """Return the scan in a PLY, PCD, NPZ, NPY, XYZ, TXT, CSV or 16-bit depth PNG file; docs/formats.md has the details.

    Points come out in metres in the camera frame (x right, y down, z forward). What the reader decided on its own (units, axes,
    camera) is in ``notes``; returns that are NaN, infinite, zero or too weak are left out and counted in ``dropped``.

    Args:
        path: The scan.
        intrinsics: The camera of a depth image (or organised cloud), or its JSON file. A depth PNG without it takes
            ``<stem>.json`` or ``intrinsics.json`` beside it.
        amplitude: (h, w) signal strength, or a grey PNG of it; replaces the file's own.
        min_amplitude: Returns with less signal than this are dropped.
        camera_to_world: (4, 4) pose of the camera in the world, metres, or a JSON or text file of it; replaces the file's own. It
            takes the file's axes to the world, so it follows when a cloud is turned.
        units: "m" or "mm"; None takes what the file says, else millimetres if the median distance is above 20, else metres.

    Raises:
        ScanError: If the file is missing, not one of these, truncated, damaged, or has fewer than 100 valid points; one line that
            names the file, the cause and the way out.
        ConfigError: If the camera or pose file, ``units`` or ``min_amplitude`` makes no sense.
        MissingExtraError: If the library that reads this format is not installed.
    """
    path = Path(path)
    if units is not None and units not in METRES_PER_UNIT:
        raise ConfigError(f"units: got {units!r}, wanted 'm' or 'mm' (or leave it out to have them detected)")
    if min_amplitude is not None and not np.isfinite(min_amplitude):
        raise ConfigError(f"min_amplitude: got {min_amplitude}, wanted a finite number")
    camera = intrinsics if intrinsics is None or isinstance(intrinsics, Intrinsics) else Path(intrinsics)
    try:
        with np.errstate(all="ignore"):
            raw = _with_camera(path, _reader(path)(path, load_bytes(path), camera), camera)
            raw = _with_amplitude(path, raw, amplitude, min_amplitude)
            if camera_to_world is not None:
                raw = replace(raw, camera_to_world=read_pose(camera_to_world), pose_in_file_units=False)
            return _settled(path, raw, units, min_amplitude)
    except Exception as error:
        raise _translated(error, path) from error


def _translated(error: Exception, path: Path) -> ViewgainError:
    """Return what to raise for any failure: one printable line that names the file."""
    if isinstance(error, ViewgainError):
        return type(error)(printable(str(error)))
    reason = printable(one_line(error))
    if isinstance(error, ImportError):
        return MissingExtraError(f"{path}: reading {path.suffix} files needs the package {error.name}; install it with pip")
    if isinstance(error, MemoryError):
        return ScanError(f"{path}: does not fit into memory; is this the right file?")
    if isinstance(error, OSError) and error.strerror:
        return ScanError(
            printable(f"{error.filename or path}: cannot be read ({error.strerror}); check the file and its permissions")
        )
    return ScanError(f"{path}: is damaged or no {path.suffix} file ({reason}); export the scan again")


def _reader(path: Path) -> Reader:
    """Return the reader by extension, or by the first bytes where the extension is unknown."""
    extension = path.suffix.lower()
    if extension in READERS:
        return READERS[extension]
    data = load_bytes(path)
    for magic, known in MAGIC.items():
        if data.startswith(magic):
            return READERS[known]
    raise ScanError(f"{path}: unknown type of file '{extension}'; wanted one of {' '.join(READERS)}")


def _with_camera(path: Path, raw: RawScan, camera: Intrinsics | Path | None) -> RawScan:
    """Attach a given camera to an organised cloud; readers of depth images have done so already."""
    if camera is None or raw.from_depth:
        return raw
    if raw.points.ndim != 3:
        raise ScanError(f"{path}: is an unorganised cloud, which has no image for the intrinsics; leave them out")
    found = resolve_camera(camera, (raw.points.shape[1], raw.points.shape[0]), path)
    pose = found.camera_to_world
    if pose is not None and raw.camera_to_world is None:
        raw = replace(raw, camera_to_world=pose, pose_in_file_units=False)
    return replace(raw, intrinsics=found.intrinsics)


def _with_amplitude(path: Path, raw: RawScan, amplitude: PathLike | Image | None, min_amplitude: float | None) -> RawScan:
    """Attach a given amplitude image, and check it against the points."""
    name = str(path)
    if isinstance(amplitude, np.ndarray):
        raw = replace(raw, amplitude=np.asarray(amplitude, dtype=float))
        name = "amplitude"
    elif amplitude is not None:
        source = Path(amplitude)
        raw = replace(raw, amplitude=decode_amplitude(source, load_bytes(source)))
        name = str(source)
    if raw.amplitude is None:
        if min_amplitude is not None:
            raise ScanError(f"{path}: min_amplitude needs an amplitude image and the scan has none; give amplitude=<file.png>")
        return raw
    if raw.points.shape[:-1] != raw.amplitude.shape or raw.points.ndim != 3:
        image, cloud = raw.amplitude.shape, raw.points.shape
        raise ScanError(
            f"{name}: got an amplitude image of shape {image} for points of shape {cloud} in {path}; give the one of this scan"
        )
    return raw


def _settled(path: Path, raw: RawScan, units: str | None, min_amplitude: float | None) -> Scan:
    """Return the scan in metres and in the camera's frame, without weak returns."""
    factor, unit_note = metres_per_unit(raw.points, units, raw.scale, raw.scale_note)
    points, pose = raw.points * factor, raw.camera_to_world
    if pose is not None and raw.pose_in_file_units:
        pose = pose.copy()
        pose[:3, 3] *= factor
    normals = unit_normals(raw.normals)
    frame_notes: tuple[str, ...] = ()
    if not raw.from_depth:
        (points, normals, pose), frame_notes = face_forward(points, normals, pose)
    points, weak = _without_weak(points, raw.amplitude, min_amplitude)
    scan = Scan.from_array(
        points,
        intrinsics=raw.intrinsics,
        normals=normals,
        amplitude=raw.amplitude,
        camera_to_world=pose,
        source=str(path),
        notes=(unit_note, *raw.notes, *frame_notes),
    )
    dropped = replace(scan.dropped, not_a_number=scan.dropped.not_a_number - weak, weak=weak)
    return replace(scan, dropped=dropped)


def _without_weak(points: Array, amplitude: Image | None, min_amplitude: float | None) -> tuple[Array, int]:
    if amplitude is None or min_amplitude is None:
        return points, 0
    weak = ~(amplitude >= min_amplitude) & np.isfinite(points).all(axis=-1) & (np.abs(points).max(axis=-1) >= 1e-9)
    return np.where(weak[..., None], np.nan, points), int(weak.sum())

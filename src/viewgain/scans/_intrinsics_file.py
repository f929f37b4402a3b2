"""Camera files: our own keys and those of RealSense, Azure Kinect, Orbbec, ROS and Open3D, all as JSON."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from viewgain.arrays import Pose
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError
from viewgain.scans._camera_keys import distortion, flatten, focal, image_size, number
from viewgain.scans._pose_file import find_pose, load_json
from viewgain.scans._raw import PathLike


@dataclass(frozen=True, slots=True, kw_only=True)
class DepthCamera:
    """All that a camera file says about a depth image."""

    intrinsics: Intrinsics
    source: str
    """The file's name, for messages."""
    scale: float | None = None
    """Metres per count of the depth image; None if unsaid."""
    scale_note: str = ""
    """Where ``scale`` comes from."""
    kind: str = "z"
    """"z" for depth along the line of sight, "range" for distance along each pixel's ray."""
    camera_to_world: Pose | None = None


def read_intrinsics(path: PathLike, *, size: tuple[int, int] | None = None) -> Intrinsics:
    """Return the camera of a JSON intrinsics file.

    Keys (any case, underscores optional): fx, fy, cx, cy (or ppx, ppy; or a 3x3 under intrinsic_matrix, camera_matrix, K),
    width, height, and the lens under distortion, coeffs or k1 ... k6, p1, p2; at the top or in a block named intrinsics, depth
    and so on.

    Args:
        path: The JSON file.
        size: (width, height), pixels, for a file that does not say it.

    Raises:
        ConfigError: If the file is missing, not JSON, lacks a key, or has a lens model other than Brown's or the rational one.
    """
    return read_depth_camera(path, size=size).intrinsics


def read_depth_camera(path: PathLike, *, size: tuple[int, int] | None = None) -> DepthCamera:
    """Return the camera, depth scale, depth kind and pose of a JSON intrinsics file; raises as :func:`read_intrinsics`."""
    path = Path(path)
    content = load_json(path, "intrinsics")
    if not isinstance(content, dict):
        raise ConfigError(f"{path}: holds a JSON {type(content).__name__}, wanted an object with fx, fy, cx, cy, width, height")
    flat = flatten(content)
    fx, fy, cx, cy = focal(flat, path)
    width, height = image_size(flat, path, size)
    coefficients = distortion(flat, path)
    try:
        intrinsics = Intrinsics(width=width, height=height, fx=fx, fy=fy, cx=cx, cy=cy, distortion=coefficients)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from error
    kind = flat.get("depthkind", "z")
    if kind not in ("z", "range"):
        raise ConfigError(f"{path}: got depth_kind {str(kind)[:40]!r}, wanted 'z' or 'range'")
    scale, note = _scale(flat, path)
    pose = find_pose(content, path, beside_camera=True)
    return DepthCamera(intrinsics=intrinsics, source=str(path), scale=scale, scale_note=note, kind=kind, camera_to_world=pose)


def _scale(flat: dict[str, Any], path: Path) -> tuple[float | None, str]:
    if "depthscale" not in flat:
        return None, ""
    given = number(flat["depthscale"], "depth_scale", path)
    if not 1e-6 <= given <= 1e6:
        raise ConfigError(f"{path}: got depth_scale {given:g}, wanted metres per count, such as 0.001")
    scale = metres_per_count(given)
    return scale, f"{scale:.6g} m per count (depth_scale {given:g} in {path})"


def resolve_camera(camera: Intrinsics | Path, size: tuple[int, int], image: Path) -> DepthCamera:
    """Return the camera given as an object or a file, of the ``size`` (width, height) that ``image`` has.

    Raises:
        ConfigError: As :func:`read_intrinsics`, and if the sizes differ.
    """
    if isinstance(camera, Intrinsics):
        camera_file = DepthCamera(intrinsics=camera, source="intrinsics")
    else:
        camera_file = read_depth_camera(camera, size=size)
    found = (camera_file.intrinsics.width, camera_file.intrinsics.height)
    if found != size:
        raise ConfigError(
            f"{camera_file.source}: is for images of {found[0]} x {found[1]} pixels but {image} has {size[0]} x {size[1]};"
            " give the intrinsics of this stream"
        )
    return camera_file


def metres_per_count(scale: float) -> float:
    """Return metres per count from the three conventions in use, told apart by magnitude.

    Up to 0.01 it is metres per count (RealSense: 0.001), from 100 counts per metre (Open3D: 1000), between millimetres per count
    (Orbbec: 1.0, 0.1).
    """
    if scale >= 100:
        return 1 / scale
    return scale if scale <= 0.01 else scale / 1000

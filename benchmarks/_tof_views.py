"""A real scan beside simulated scans of the same scene, and what is measured on both by the same rules."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from viewgain.arrays import Array, Image, Points, Vector
from viewgain.box import Box, box_hits, edge_distances, entry_mask, outline
from viewgain.camera import Intrinsics, Sensor, sensor
from viewgain.geometry import Plane, fit_plane
from viewgain.measure import measure
from viewgain.scans import Scan
from viewgain.scenes import Scene
from viewgain.simulate import Effects, capture

OPENNI = Intrinsics(width=640, height=480, fx=570.3422, fy=570.3422, cx=319.5, cy=239.5)
"""The camera whose pixel grid the trai clouds lie on: OpenNI's default for PrimeSense cameras (found by their own spacing)."""
LEAST_JUMP = 0.15
"""An edge of an outline is a depth edge if its background is at least this much farther, metres."""
_NOTHING = -1

Ids = NDArray[np.intp]


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """One real scan and how it is simulated."""

    file: str
    """Below ``real_boxes``."""
    title: str
    """For tables and pictures."""
    camera: str
    """Preset."""
    box: float
    """Reflectivity of the boxes."""
    floor: float
    """Reflectivity of the floor."""
    window: int = 7
    """Side of the square patches of an organised scan, pixels."""
    leaf: float = 0.0
    """Side of the voxels that the cloud was averaged in, metres; 0 for an organised scan."""
    wall: bool = False
    """Whether a wall is fitted behind the floor."""


@dataclass(frozen=True, slots=True, eq=False)
class Setup:
    """The scene of a real scan as far as it is known, camera frame."""

    case: Case
    boxes: tuple[Box, ...]
    planes: tuple[Plane, ...]
    """Floor, then the wall if there is one."""
    camera: Intrinsics
    shadowed: frozenset[int] = frozenset()
    """Edges of the first box's outline beyond which the lamp throws the box's shadow, by the amplitude image."""

    def sensor(self) -> Sensor:
        """Return the preset with the intrinsics of this very camera."""
        return replace(sensor(self.case.camera), intrinsics=self.camera)

    def scene(self, box: float, floor: float) -> Scene:
        """Return the scene with these reflectivities; a wall is as the floor."""
        shares = (box,) * len(self.boxes) + (floor,) * len(self.planes)
        return Scene(self.boxes, (), self.planes, shares)

    @property
    def floor_id(self) -> int:
        """Number of the floor among the surfaces: five faces per box come first."""
        return 5 * len(self.boxes)


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Rays of one scan, real or simulated, with what they should have met."""

    setup: Setup
    directions: Points
    """(n, 3) unit."""
    ranges: Vector
    """(n,) metres; NaN for no return (organised scans only)."""
    expected: Vector
    """(n,) range of the first surface of the setup; inf for none."""
    surface: Ids
    """(n,) its number; -1 for none."""
    cosine: Vector
    """(n,) of incidence."""
    shape: tuple[int, int] | None
    """Image, row by row; None for a cloud."""
    amplitude: Vector | None
    """(n,) in the camera's own units, where the scan has it."""

    @property
    def excess(self) -> Vector:
        """(n,) measured minus expected range, metres."""
        return np.asarray(np.where(np.isfinite(self.expected), self.ranges - self.expected, np.nan))

    @property
    def deviation(self) -> Vector:
        """(n,) height above the expected surface, towards the camera's side, metres."""
        return np.asarray(-self.excess * self.cosine)

    @property
    def incidence_deg(self) -> Vector:
        """(n,) angle of incidence, degrees."""
        return np.asarray(np.rad2deg(np.arccos(np.clip(self.cosine, 0, 1))))

    def outline_px(self, box: Box) -> Vector:
        """Return the (n,) signed distance to a box's outline, pixels, positive inside."""
        image = self.directions[:, :2] / self.directions[:, 2:]
        return np.asarray(edge_distances(outline(box), image).distance * self.setup.camera.fx)


def set_up(case: Case, scan: Scan) -> Setup:
    """Return the scene of a scan: its measured boxes, the floor of the first, its camera."""
    result = measure(scan)
    boxes = tuple(estimate.box for estimate in result.boxes if not any(estimate.is_open))
    floor = boxes[0].floor
    planes = (floor, _wall(scan, floor, boxes)) if case.wall else (floor,)
    bare = Setup(case, boxes, planes, fitted_camera(scan) if scan.shape is not None else OPENNI)
    return bare if scan.amplitude is None else replace(bare, shadowed=_shadowed(bare, scan))


def _shadowed(setup: Setup, scan: Scan) -> frozenset[int]:
    """Return the depth edges of the first box beyond which the floor is darker than a little farther away."""
    directions = setup.camera.directions().reshape(-1, 3)
    near = edge_distances(outline(setup.boxes[0]), directions[:, :2] / directions[:, 2:])
    distance = near.distance * setup.camera.fx
    light = np.asarray(scan.amplitude, dtype=float).ravel()
    dark = set()
    for edge in np.flatnonzero(jumps(setup) > LEAST_JUMP):
        on = (near.edge == edge) & (near.along > 0.08) & (near.along < 0.92)
        beside, farther = (np.median(light[on & (distance < -a) & (distance > -b)]) for a, b in ((0, 2.5), (14, 22)))
        if beside < 0.85 * farther:
            dark.add(int(edge))
    return frozenset(dark)


def fitted_camera(scan: Scan) -> Intrinsics:
    """Return the pinhole camera with Brown distortion on whose rays the points of an organised cloud lie."""
    assert scan.shape is not None
    assert scan.pixels is not None
    height, width = scan.shape
    chosen = slice(None, None, max(1, len(scan.points) // 4000))
    row, column = np.divmod(scan.pixels[chosen], width)
    pixels, points = np.stack([column, row], axis=-1), scan.points[chosen]

    def camera(numbers: Array) -> Intrinsics:
        fx, fy, cx, cy, *lens = (float(number) for number in numbers)
        return Intrinsics(width=width, height=height, fx=fx, fy=fy, cx=cx, cy=cy, distortion=tuple(lens))

    start = np.array([0.7 * width, 0.7 * width, (width - 1) / 2, (height - 1) / 2, *[0.0] * 5])
    size = [100, 100, 10, 10, 0.1, 0.1, 0.01, 0.01, 0.1]
    found = least_squares(lambda x: (camera(x).project(points) - pixels).ravel(), start, x_scale=size, loss="soft_l1")
    return camera(found.x)


def pixel_grid(scan: Scan) -> tuple[float, float, float]:
    """Return the focal length on whose pixel grid the points of a cloud lie, how strongly, and the strength by chance.

    Points that were not averaged with others have a depth of whole millimetres; their x / z then are whole pixels over the focal
    length, and the mean of exp(2 pi i f x / z) stands out at the true f (1 if all lie on the grid).
    """
    image = _single(scan)[:, 1] / _single(scan)[:, 2]
    image = image[np.abs(image) < 0.35]
    focal = np.arange(150.0, 800.0, 0.1)
    strength = np.array([np.abs(np.exp(2j * np.pi * f * image).mean()) for f in focal])
    best = int(np.argmax(strength))
    return float(focal[best]), float(strength[best]), float(len(image) ** -0.5)


def depth_step(scan: Scan) -> float:
    """Return the usual distance of neighbouring depths that occur often, over their square, 1 / m."""
    depth, count = np.unique(np.rint(1e3 * _single(scan)[:, 2]), return_counts=True)
    depth = depth[count >= 0.3 * np.quantile(count, 0.95)] / 1e3
    return float(np.median(np.diff(depth) / (depth[:-1] * depth[1:])))


def _single(scan: Scan) -> Points:
    """Return the points whose depth is a whole number of millimetres."""
    depth = 1e3 * scan.points[:, 2]
    return scan.points[np.abs(depth - np.rint(depth)) < 0.003]


def real_look(setup: Setup, scan: Scan) -> Look:
    """Return the real scan, its rays those of the fitted camera (organised) or of its points."""
    return _looked(setup, scan)


def simulated_look(
    setup: Setup,
    *,
    seed: int,
    like: Scan,
    effects: Effects | None = None,
    shares: tuple[float, float] | None = None,
    change: Callable[[Sensor], Sensor] = lambda preset: preset,
) -> Look:
    """Return a simulated scan of the setup; an unorganised one is averaged in voxels and cut to the room of the real cloud."""
    box, floor = shares or (setup.case.box, setup.case.floor)
    scan = capture(setup.scene(box, floor), np.eye(4), change(setup.sensor()), rng=np.random.default_rng(seed), effects=effects)
    if like.shape is not None:
        return _looked(setup, scan)
    points = voxel_means(scan.points, setup.case.leaf)
    low, high = np.quantile(like.points, [0.001, 0.999], axis=0)
    return _looked(setup, Scan(points=points[np.all((points >= low) & (points <= high), axis=1)]))


def voxel_means(points: Points, leaf: float) -> Points:
    """Return the mean of the points in each occupied cube of side ``leaf``, the grid through the origin (PCL's VoxelGrid)."""
    _, voxel, count = np.unique(np.floor(points / leaf).astype(np.int64), axis=0, return_inverse=True, return_counts=True)
    sums = np.stack([np.bincount(voxel.ravel(), points[:, k]) for k in range(3)], axis=-1)
    return np.asarray(sums / count[:, None])


def _looked(setup: Setup, scan: Scan) -> Look:
    distance = np.linalg.norm(scan.points, axis=1)
    if scan.shape is None or scan.pixels is None:
        directions, ranges = scan.points / distance[:, None], distance
    else:
        directions = setup.camera.directions().reshape(-1, 3)
        ranges = np.full(len(directions), np.nan)
        ranges[scan.pixels] = distance
    amplitude = None if scan.amplitude is None else np.asarray(scan.amplitude, dtype=float).ravel()
    return Look(setup, directions, ranges, *_expected(setup, directions), scan.shape, amplitude)


def _expected(setup: Setup, directions: Points) -> tuple[Vector, Ids, Vector]:
    ranges = np.full(len(directions), np.inf)
    surface, cosine = np.full(len(directions), _NOTHING), np.zeros(len(directions))
    for number, box in enumerate(setup.boxes):
        hits = box_hits(box, directions)
        nearer = entry_mask(box, directions) & (hits.ranges < ranges)
        ranges, cosine = np.where(nearer, hits.ranges, ranges), np.where(nearer, hits.cosine, cosine)
        surface = np.where(nearer, 5 * number + hits.planes, surface)
    for number, plane in enumerate(setup.planes):
        far, approach = plane_ranges(plane, directions)
        nearer = far < ranges
        ranges, cosine = np.where(nearer, far, ranges), np.where(nearer, approach, cosine)
        surface = np.where(nearer, setup.floor_id + number, surface)
    return ranges, surface, cosine


def plane_ranges(plane: Plane, directions: Points) -> tuple[Vector, Vector]:
    """Return (n,) ranges and cosines of incidence of rays on a plane; inf where it is not ahead."""
    approach = -(directions @ plane.normal)
    return np.where(approach > 1e-6, plane.offset / np.maximum(approach, 1e-6), np.inf), np.maximum(approach, 0.0)


def _wall(scan: Scan, floor: Plane, boxes: tuple[Box, ...]) -> Plane:
    """Return the plane of what is higher than any box, by trimmed least squares."""
    top = max(float(box.extents[2]) for box in boxes)
    points = scan.points[floor.height(scan.points) > top + 0.1]
    plane = fit_plane(points)
    for _ in range(10):
        off = np.abs(plane.height(points))
        plane = fit_plane(points[off <= max(float(np.quantile(off, 0.6)), 0.005)])
    return plane


def jumps(setup: Setup) -> Vector:
    """Return how much farther the background of each edge of the first box's outline is than the edge itself, metres."""
    box = setup.boxes[0]
    shape = outline(box)
    following = np.roll(shape.vertices, -1, axis=0)
    corners = box.corners()[shape.corners]
    middle = (corners + np.roll(corners, -1, axis=0)) / 2
    side = following - shape.vertices
    inward = np.stack([-side[:, 1], side[:, 0]], axis=1) / np.linalg.norm(side, axis=1, keepdims=True)
    beside = middle[:, :2] / middle[:, 2:] - inward * 2 / setup.camera.fx
    rays = np.column_stack([beside, np.ones(len(beside))])
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    back = np.min([plane_ranges(plane, rays)[0] for plane in setup.planes], axis=0)
    return np.asarray(back - np.linalg.norm(middle, axis=1))


def range_picture(look: Look) -> Image:
    """Return the (h, w) ranges of an organised scan."""
    assert look.shape is not None
    return look.ranges.reshape(look.shape)

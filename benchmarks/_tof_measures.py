"""What ``real-tof`` measures on a scan, real or simulated: local noise, bends, what happens at depth edges, missing returns."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from benchmarks._tof_views import LEAST_JUMP, Ids, Look, Setup, jumps, plane_ranges
from viewgain.arrays import Array, Indices, Mask, Vector
from viewgain.box import FACES, PLANE_NORMALS, box_hits, edge_distances, outline
from viewgain.geometry import inverse, transform

GATE = 0.06
"""What lies farther than this from the expected surface is another thing, metres."""
INSIDE_PX = 4
"""Pixels from the border of a face or of the floor that are left out where edges must not count."""
PATCH = 0.05
"""Side of a patch of an unorganised cloud, metres."""
SEGMENT_PX = 8.0
"""Length of the pieces of an outline whose position is looked for one by one."""


def interior(look: Look) -> Mask:
    """Return the (n,) mask of rays that should meet one flat surface only, with all their neighbours within INSIDE_PX."""
    if look.shape is not None:
        image = look.surface.reshape(look.shape)
        size = 2 * INSIDE_PX + 1
        flat = ndimage.minimum_filter(image, size) == ndimage.maximum_filter(image, size)
        return np.asarray(flat.ravel() & (look.surface >= 0))
    inside = look.surface >= 0
    for number, box in enumerate(look.setup.boxes):
        on = (look.surface >= 5 * number) & (look.surface < 5 * number + 5)
        local = transform(inverse(box.box_to_camera), look.directions[on] * look.expected[on, None])
        local[:, 2] -= box.extents[2] / 2
        room = np.sort(box.extents / 2 - np.abs(local), axis=1)[:, 1]  # the least is the face itself
        inside[on] &= room > max(0.015, 1.5 * look.setup.case.leaf)
        inside &= on | (np.abs(look.outline_px(box)) > 8)
    return np.asarray(inside)


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """Local noise on small flat patches, (m,) each."""

    sd: Vector
    """Standard deviation of the range about the patch's own plane, metres."""
    range: Vector
    """Metres."""
    incidence_deg: Vector
    on_floor: Mask
    products: Vector
    """Sum of the products of neighbouring residuals."""
    squares: Vector
    """What that sum would be if neighbours had the same residual."""

    def take(self, chosen: Mask | Indices) -> "Patches":
        """Return a subset."""
        return Patches(*(getattr(self, name)[chosen] for name in Patches.__slots__))


def joined(parts: list[Patches]) -> Patches:
    """Return the patches of several looks as one."""
    return Patches(*(np.concatenate([getattr(part, name) for part in parts]) for name in Patches.__slots__))


def lag_one(patches: Patches) -> float:
    """Return the correlation of the residuals of neighbouring pixels; -0.05 or so for white noise, for the planes are fitted."""
    return float(patches.products.sum() / patches.squares.sum()) if patches.squares.sum() > 0 else float("nan")


def noise_patches(look: Look) -> Patches:
    """Return the noise on square windows of pixels (organised) or on squares of the surface (cloud), each on one surface."""
    excess = look.excess
    good = np.flatnonzero(interior(look) & np.isfinite(excess) & (np.abs(excess) < GATE))
    keys, at = _tiles(look, good)
    order = np.lexsort(keys.T[::-1])
    cuts = np.flatnonzero(np.any(np.diff(keys[order], axis=0) != 0, axis=1)) + 1
    rows = []
    for group in np.split(order, cuts):
        least = 0.8 * look.setup.case.window**2 if look.shape is not None else 12
        if len(group) < least:
            continue
        pixels, place = good[group], at[group]
        design = np.column_stack([np.ones(len(group)), place - place.mean(axis=0)])
        left = excess[pixels] - design @ np.linalg.lstsq(design, excess[pixels], rcond=None)[0]
        spread = 1.4826 * np.median(np.abs(left)) + 2e-4
        kept = np.abs(left) < 4 * spread
        sd = np.sqrt(np.sum(left[kept] ** 2) / max(kept.sum() - 3, 1))
        products, squares = _neighbours(look, pixels[kept], left[kept])
        middle = pixels[len(pixels) // 2]
        on_floor = look.surface[middle] >= look.setup.floor_id
        rows.append((sd, np.median(look.ranges[pixels]), np.median(look.incidence_deg[pixels]), on_floor, products, squares))
    columns = np.array(rows, dtype=float).reshape(-1, 6).T
    return Patches(columns[0], columns[1], columns[2], columns[3] > 0, columns[4], columns[5])


def _tiles(look: Look, good: Indices) -> tuple[Array, Array]:
    """Return for chosen rays the (m, 3) key of their patch and their (m, 2) place, in pixels or metres."""
    if look.shape is not None:
        place = np.stack(np.divmod(good, look.shape[1]), axis=-1).astype(float)
        return np.column_stack([look.surface[good], place // look.setup.case.window]), place
    points = look.directions[good] * look.expected[good, None]
    place = np.empty((len(good), 2))
    for surface in np.unique(look.surface[good]):
        on = look.surface[good] == surface
        box = look.setup.boxes[min(surface // 5, len(look.setup.boxes) - 1)]
        normal = PLANE_NORMALS[surface % 5] if surface < look.setup.floor_id else np.array([0.0, 0.0, 1.0])
        local = transform(inverse(box.box_to_camera), points[on])
        place[on] = local[:, np.abs(normal) < 0.5]
    return np.column_stack([look.surface[good], place // PATCH]), place


def _neighbours(look: Look, pixels: Indices, left: Vector) -> tuple[float, float]:
    """Return the mean product of residuals of pixels side by side and above each other, and the mean square, times pairs."""
    if look.shape is None:
        return 0.0, 0.0
    value = dict(zip(pixels.tolist(), left.tolist(), strict=True))
    pairs = [x * value[k + step] for k, x in value.items() for step in (1, look.shape[1]) if k + step in value]
    return float(np.sum(pairs)), len(pairs) * float(np.mean(left**2))


@dataclass(frozen=True, slots=True, eq=False)
class Profile:
    """A mean (or median) along a coordinate, with its 95 % interval."""

    at: Vector
    """Middle of each bin."""
    mean: Vector
    """NaN where a bin is empty."""
    low: Vector
    high: Vector


def side_faces(setup: Setup, look: Look, *, least: int = 150) -> list[int]:
    """Return the numbers of the upright faces that have enough returns of a scan."""
    near = np.isfinite(look.excess) & (np.abs(look.excess) < GATE)
    return [k for k in range(setup.floor_id) if k % 5 != FACES.index("top") and (near & (look.surface == k)).sum() >= least]


def face_bend(looks: list[Look], face: int, bins: int = 10) -> Profile:
    """Return how far a face stands out of the plane of its upper half, against height over the floor, metres.

    The interval is a bootstrap over upright strips of the face (and over scans, for several).
    """
    strips = [strip for look in looks for strip in _strips(look, face)]
    height = float(looks[0].setup.boxes[face // 5].extents[2])
    edges = np.linspace(0.0, height, bins + 1)
    return _profile(strips, edges, lambda rows: rows[:, 0] > height / 2)


def _strips(look: Look, face: int, count: int = 12) -> list[Array]:
    """Return the rays on a face as strips of rows (height, along, deviation), without the margin at its upright edges and top."""
    box = look.setup.boxes[face // 5]
    on = np.flatnonzero((look.surface == face) & (np.abs(look.excess) < GATE))
    local = transform(inverse(box.box_to_camera), look.directions[on] * look.expected[on, None])
    axis = int(np.argmin(np.abs(PLANE_NORMALS[face % 5, :2])))
    margin = max(0.01, INSIDE_PX * float(np.median(look.expected[on])) / look.setup.camera.fx)
    room = box.extents[axis] / 2 - margin
    kept = (np.abs(local[:, axis]) < room) & (local[:, 2] < box.extents[2] - margin)
    rows = np.column_stack([local[kept, 2], local[kept, axis], look.deviation[on[kept]]])
    strip = np.clip(((rows[:, 1] + room) / (2 * room) * count).astype(int), 0, count - 1)
    return [rows[strip == k] for k in range(count) if np.any(strip == k)]


def _profile(strips: list[Array], edges: Array, reference: Callable[[Array], Mask], draws: int = 100) -> Profile:
    """Return binned medians of deviation minus the plane through the reference rows, with a bootstrap over strips."""
    rng = np.random.default_rng(0)
    thin = max(1, sum(len(strip) for strip in strips) // 20000)
    strips = [strip[::thin] for strip in strips]

    def once(chosen: list[Array]) -> Vector:
        rows = np.concatenate(chosen)
        flat = rows[reference(rows)]
        design = np.column_stack([np.ones(len(rows)), rows[:, :2]])
        plane = _robust_plane(flat)
        left = rows[:, 2] - design @ plane
        which = np.digitize(rows[:, 0], edges) - 1
        return np.array([np.median(left[which == k]) if (which == k).sum() >= 5 else np.nan for k in range(len(edges) - 1)])

    mean = once(strips)
    drawn = np.array([once([strips[k] for k in rng.integers(len(strips), size=len(strips))]) for _ in range(draws)])
    empty = np.all(np.isnan(drawn), axis=0)
    drawn[:, empty] = 0.0
    low, high = np.nanquantile(drawn, [0.025, 0.975], axis=0)
    low[empty] = high[empty] = np.nan
    return Profile((edges[1:] + edges[:-1]) / 2, mean, low, high)


def _robust_plane(rows: Array) -> Vector:
    """Return the (3,) coefficients of deviation over 1 and the first two columns, outliers dropped."""
    design = np.column_stack([np.ones(len(rows)), rows[:, :2]])
    kept = np.ones(len(rows), dtype=bool)
    plane = np.zeros(3)
    for _ in range(4):
        plane = np.linalg.lstsq(design[kept], rows[kept, 2], rcond=None)[0]
        left = np.abs(rows[:, 2] - design @ plane)
        kept = left <= 3 * 1.4826 * np.median(left) + 1e-6
    return np.asarray(plane)


FOOT_EDGES = np.array([0.0, 0.01, 0.02, 0.03, 0.045, 0.06, 0.08, 0.10, 0.13, 0.16, 0.20])
"""Distances from the foot of a box, metres."""
RIM_EDGES = np.array([0.0, 2, 4, 6, 8, 11, 15, 20, 26, 33, 42, 52])
"""Distances from the outline of a box, pixels of a camera with a focal length of 367."""


def floor_before(looks: list[Look]) -> Profile | None:
    """Return the height of the floor before the lit faces of the first box against the distance from its foot, metres.

    The plane is fitted to 15 to 40 cm from the foot.
    """
    strips = [strip for look in looks for strip in _floor_strips(look, hidden=False)]
    if sum(len(strip) for strip in strips) < 200:
        return None
    return _profile(strips, FOOT_EDGES, lambda rows: (rows[:, 0] > 0.15) & (rows[:, 0] < 0.4))


def floor_behind(looks: list[Look]) -> Profile | None:
    """Return the height of the floor behind a depth edge of the first box against the distance from its outline, pixels.

    The plane is fitted beyond 40 of those pixels.
    """
    strips = [strip for look in looks for strip in _floor_strips(look, hidden=True)]
    if sum(len(strip) for strip in strips) < 200:
        return None
    return _profile(strips, RIM_EDGES, lambda rows: (rows[:, 0] > 40) & (rows[:, 0] < 90))


def _floor_strips(look: Look, *, hidden: bool, count: int = 12) -> list[Array]:
    """Return the floor around a box as strips of rows (distance, place along, height)."""
    setup = look.setup
    box = setup.boxes[0]
    on = np.flatnonzero((look.surface == setup.floor_id) & (np.abs(look.excess) < 1.5 * GATE))
    image = look.directions[on, :2] / look.directions[on, 2:]
    shape = outline(box)
    near = edge_distances(shape, image)
    jump = jumps(setup)[near.edge]
    points = look.directions[on] * look.expected[on, None]
    local = transform(inverse(box.box_to_camera), points)
    beyond = np.maximum(np.abs(local[:, :2]) - box.extents[:2] / 2, 0)
    middle = (near.along > 0.08) & (near.along < 0.92)
    if hidden:
        distance = -near.distance * 367.0
        kept = (jump > LEAST_JUMP) & ~np.isin(near.edge, list(setup.shadowed)) & middle & (distance > 0) & (distance < 90)
        place = near.edge + near.along
        along = near.along * 100
    else:
        distance = np.linalg.norm(beyond, axis=1)
        kept = (jump < 0.02) & middle & (distance < 0.4) & (near.distance < 0) & (beyond.min(axis=1) == 0)
        along = np.where(beyond[:, 0] > 0, local[:, 1], local[:, 0])
        place = near.edge + near.along
    rows = np.column_stack([distance, along, look.deviation[on]])[kept]
    strip = np.floor(place[kept] * count).astype(int)
    return [rows[strip == k] for k in np.unique(strip)]


@dataclass(frozen=True, slots=True, eq=False)
class Rim:
    """Pixels around the depth edges of a box's outline, (n,) each."""

    inside_px: Vector
    """Distance to the outline where this scan shows it, pixels, positive inside."""
    missing: Mask
    flying: Mask
    """On neither side within 3 sigma + 2 cm."""
    midway: Mask
    """Between 20 and 80 % of the way from near to far."""
    segment: Ids
    """Piece of the outline."""
    shift_px: Vector
    """Per edge: how far inside the fitted outline this scan shows it, pixels."""


BAND_PX = 3.0
"""Half width of the band in which flying pixels are counted, pixels."""


def rim(look: Look, *, shadowed: bool = False) -> Rim | None:
    """Return what happens around the depth edges of the first box, those with the lamp's shadow beyond them or the others.

    Each edge is first laid where this very scan shows it: a straight line through the points that best part near from far. Near
    and far are what is measured 5 to 14 pixels to each side.
    """
    setup = look.setup
    box = setup.boxes[0]
    shape = outline(box)
    near = edge_distances(shape, look.directions[:, :2] / look.directions[:, 2:])
    distance = near.distance * setup.camera.fx
    length = np.linalg.norm(np.roll(shape.vertices, -1, axis=0) - shape.vertices, axis=1) * setup.camera.fx
    front = box_hits(box, look.directions).ranges
    back = np.min([plane_ranges(plane, look.directions)[0] for plane in setup.planes], axis=0)
    sigma = 3 * setup.sensor().range_sigma(np.where(np.isfinite(back), back, 1.0), np.full(len(back), 0.5)) + 0.02
    parts, shifts = [], []
    for edge in np.flatnonzero(jumps(setup) > LEAST_JUMP):
        on = (near.edge == edge) & (near.along > 0.08) & (near.along < 0.92) & (np.abs(distance) < 16)
        on = np.flatnonzero(on & (back - front > np.maximum(2.5 * sigma, LEAST_JUMP)) & np.isfinite(back) & np.isfinite(front))
        if len(on) < 200 or (int(edge) in setup.shadowed) != shadowed:
            continue
        segment = np.floor(near.along[on] * length[edge] / SEGMENT_PX).astype(int)
        d, ranges = distance[on], look.ranges[on]
        low = front[on] + _level(ranges - front[on], (d > 5) & (d < 14))
        high = back[on] + _level(ranges - back[on], (d < -5) & (d > -14))
        shift = _edge_line(d, ranges < (low + high) / 2, np.isfinite(ranges), segment)
        if np.abs(np.median(shift)) > 6:
            continue
        with np.errstate(invalid="ignore"):
            flying = (np.abs(ranges - low) > sigma[on]) & (np.abs(ranges - high) > sigma[on])
            midway = np.abs((ranges - low) / (high - low) - 0.5) < 0.3
        parts.append((d - shift, np.isnan(ranges), flying, midway, 1000 * edge + segment))
        shifts.append(float(np.median(shift)))
    if not parts:
        return None
    inside, missing, flying, midway, segment = (np.concatenate([part[k] for part in parts]) for k in range(5))
    return Rim(inside, missing, flying, midway, segment, np.array(shifts))


LIGHT_PX = np.arange(-4.25, 4.5, 0.5)
"""Bins of the distance to the outline for :func:`light_profile`, pixels."""


def light_profile(looks: list[Look]) -> Vector:
    """Return how the amplitude rises from the background (0) to the box (1) across the lit depth edges, per bin of LIGHT_PX.

    The amplitude shows how much a pixel sees of each side, whatever the camera does to the ranges afterwards. Each edge is laid
    where the amplitude passes halfway.
    """
    places, values = [], []
    for look in looks:
        setup, light = look.setup, look.amplitude
        assert light is not None
        near = edge_distances(outline(setup.boxes[0]), look.directions[:, :2] / look.directions[:, 2:])
        distance = near.distance * setup.camera.fx
        for edge in np.flatnonzero(jumps(setup) > LEAST_JUMP):
            on = np.flatnonzero((near.edge == edge) & (near.along > 0.1) & (near.along < 0.9) & (np.abs(distance) < 14))
            if int(edge) in setup.shadowed or len(on) < 200:
                continue
            d, piece = distance[on], np.floor(near.along[on] * 30).astype(int)
            low, high = np.empty(len(on)), np.empty(len(on))
            for k in np.unique(piece):
                mine = piece == k
                low[mine] = np.median(light[on[mine & (d < -4)]])
                high[mine] = np.median(light[on[mine & (d > 4)]])
            shift = _edge_line(d, light[on] > (low + high) / 2, np.ones(len(on), dtype=bool), piece)
            places.append(d - shift)
            values.append((light[on] - low) / (high - low))
    place, value = np.concatenate(places), np.concatenate(values)
    which = np.digitize(place, LIGHT_PX) - 1
    return np.array([np.mean(value[which == k]) for k in range(len(LIGHT_PX) - 1)])


def _level(excess: Vector, where: Mask) -> float:
    there = excess[where & np.isfinite(excess) & (np.abs(excess) < 0.1)]
    return float(np.median(there)) if len(there) >= 10 else 0.0


def _edge_line(distance: Vector, is_near: Mask, seen: Mask, segment: Ids) -> Vector:
    """Return the (n,) position of the edge at each pixel: a line through the best step of each piece."""
    steps = np.arange(-8.0, 8.01, 0.25)
    pieces, found = [], []
    for piece in np.unique(segment):
        mine = (segment == piece) & seen
        if mine.sum() < 20:
            continue
        d, on = distance[mine, None], is_near[mine, None]
        wrong = np.sum(on & (d < steps), axis=0) + np.sum(~on & (d >= steps), axis=0)
        pieces.append(piece)
        found.append(float(steps[wrong == wrong.min()].mean()))
    if len(pieces) < 3:
        return np.full(len(distance), np.median(found) if found else 0.0)
    x, y = np.array(pieces, dtype=float), np.array(found)
    kept = np.ones(len(x), dtype=bool)
    line = np.zeros(2)
    for _ in range(4):
        line = np.polyfit(x[kept], y[kept], 1)
        left = np.abs(y - np.polyval(line, x))
        kept = left <= max(3 * float(np.median(left)), 0.5)
    return np.asarray(np.polyval(line, segment))


def shares_along(rims: list[Rim], edges: Array, what: str) -> Profile:
    """Return the share of missing or flying pixels against the distance to the outline, with a bootstrap over its pieces."""
    rng = np.random.default_rng(0)
    hits, totals = [], []
    for part in rims:
        which = np.digitize(part.inside_px, edges) - 1
        inside = (which >= 0) & (which < len(edges) - 1)
        for piece in np.unique(part.segment):
            mine = inside & (part.segment == piece)
            totals.append(np.bincount(which[mine], minlength=len(edges) - 1))
            hits.append(np.bincount(which[mine], getattr(part, what)[mine], len(edges) - 1))
    hit, total = np.array(hits), np.array(totals)
    with np.errstate(invalid="ignore"):
        mean = hit.sum(axis=0) / total.sum(axis=0)
        picks = rng.integers(len(hit), size=(400, len(hit)))
        drawn = hit[picks].sum(axis=1) / total[picks].sum(axis=1)
    low, high = np.nanquantile(drawn, [0.025, 0.975], axis=0)
    return Profile((edges[1:] + edges[:-1]) / 2, mean, low, high)


def band_share(rims: list[Rim], what: str) -> tuple[float, float, float]:
    """Return the share within the band around the outline and its 95 % interval."""
    whole = shares_along(rims, np.array([-BAND_PX, BAND_PX]), what)
    return float(whole.mean[0]), float(whole.low[0]), float(whole.high[0])


def missing_counts(look: Look, edges_deg: Array) -> tuple[Array, Array]:
    """Return, per bin of incidence, how many interior pixels have no return, and how many there are, faces and floor apart.

    Shapes (2, bins). Connected holes of over 200 pixels at the border of the image are left out: what is there is not known.
    """
    assert look.shape is not None
    hole = np.isnan(look.ranges).reshape(look.shape)
    labels, _ = ndimage.label(hole)
    rim_labels = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
    sizes = np.bincount(labels.ravel())
    unknown = np.isin(labels, [k for k in rim_labels if k > 0 and sizes[k] > 200])
    unknown = ndimage.binary_dilation(unknown, iterations=6).ravel()
    strange = np.isfinite(look.excess) & (np.abs(look.excess) > 1.5 * GATE)
    good = interior(look) & ~unknown & ~strange & (look.surface <= look.setup.floor_id)
    which = np.digitize(look.incidence_deg, edges_deg) - 1
    good &= (which >= 0) & (which < len(edges_deg) - 1)
    lost, total = np.zeros((2, len(edges_deg) - 1)), np.zeros((2, len(edges_deg) - 1))
    for row, mine in enumerate((good & (look.surface < look.setup.floor_id), good & (look.surface == look.setup.floor_id))):
        total[row] = np.bincount(which[mine], minlength=len(edges_deg) - 1)
        lost[row] = np.bincount(which[mine], np.isnan(look.ranges[mine]), len(edges_deg) - 1)
    return lost, total


def summed(counts: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Return the sums of several :func:`missing_counts`."""
    return np.sum([part[0] for part in counts], axis=0), np.sum([part[1] for part in counts], axis=0)

"""Is it a box, and what should the user know: faces seen, flags, and the share of the evidence that the box explains."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Mask, Vector3
from viewgain.box import FACES, Box, border_share, edges_shown, incidence
from viewgain.measure._evidence import (
    MAX_SLENDER,
    MIN_FLAPS,
    NOTHING_AGAINST,
    Evidence,
    flaps,
    free_edge,
    holes,
    relief,
    tolerance,
)
from viewgain.measure._likelihood import Evaluation
from viewgain.measure._mixture import Pixels
from viewgain.measure._range_image import RangeImage
from viewgain.measure._stretch import SPANNING, SPANNING_POINTS

GRAZING = np.deg2rad(72.0)
"""A face seen at a larger mean angle of incidence is flagged as grazing."""
FEW_POINTS = 300
"""A box with fewer returns is flagged."""
BENT_M = 0.004
"""A face whose residuals follow a paraboloid of at least this depth is flagged as bent, metres."""
MIN_FACE_POINTS = 25
"""A face counts as seen with at least this many returns."""
MIN_EDGE_SHOWN = 0.1
"""An edge shows where a face ends if at least this share of it lies in the image."""
MIN_EXPLAINED = 0.75
"""An object is a box only if this share of its returns lies on the box's faces."""
MIN_EXPLAINED_FEW = 0.95
"""The same with few returns: on so few, many things look nearly like a box."""
MIN_OVERLAP = 0.6
"""An object is a box only if object and outline share this much of their union."""
MIN_THICKNESS = 0.02
"""A box thinner than this that is seen by less than one pixel in a hundred is none, metres."""
FLAPS_WIDEN = 0.04
"""Standard deviation that flaps add to each side of a box, as a share of the cube root of its volume."""
_ENDS = ((0, 1), (2, 3), (4,))
"""The faces at the ends of each axis of the box, except the bottom."""
_AXIS = {"+x": 0, "-x": 0, "+y": 1, "-y": 1, "top": 2}


@dataclass(frozen=True, slots=True)
class FaceView:
    """One face of the box that is turned towards the camera."""

    name: str
    """Which face: +x, -x, +y, -y (box frame) or top."""
    incidence: float
    """Angle between the face's normal and the line of sight to its centre, radians."""
    returns: int
    """How many returns lie on it."""
    bend: float
    """Depth of the paraboloid fitted to its residuals, metres; positive bulges towards the camera."""
    edges: Array
    """(5,) share of its edge with each of the faces that lies in the image (viewgain.box.edges_shown)."""
    reach: Vector3
    """(3,) how far its returns stretch along the box's x, y and z, metres: between their 1 % quantiles; 0 without returns."""

    @property
    def seen(self) -> bool:
        """Whether it has enough returns to count as seen."""
        return self.returns >= MIN_FACE_POINTS


@dataclass(frozen=True, slots=True)
class Quality:
    """What the evidence says about a fitted box beyond its numbers."""

    explained: float
    """Share of the returns inside the outline that lie on the faces."""
    overlap: float
    """Share of the object's pixels and the outline's pixels that both claim (intersection over union)."""
    faces: tuple[FaceView, ...]
    """Faces turned towards the camera."""
    returns: int
    """Returns on the box."""
    border: float
    """Share of the outline on the image border or beyond it (viewgain.box.Constraints)."""
    evidence: Evidence = NOTHING_AGAINST
    """What the pixels say against the box."""
    size: float = np.inf
    """Cube root of the box's volume, metres."""

    @property
    def cut(self) -> bool:
        """Whether the outline leaves the image."""
        return self.border > 0

    def spans(self, axis: int) -> bool:
        """Return whether faces with many returns show this axis of the box (0 x, 1 y, 2 z) from end to end.

        An end is shown by the face that lies there or by the edge of another face with it; the lower end of z is the floor.
        """
        along = [face for face in self.faces if FACES.index(face.name) in SPANNING[axis] and face.returns >= SPANNING_POINTS]
        at_ends = [[face for face in self.faces if face.name == FACES[end]] for end in _ENDS[axis]]
        return bool(along) and all(
            any(face.returns >= SPANNING_POINTS for face in own) or any(face.edges[end] >= MIN_EDGE_SHOWN for face in along)
            for own, end in zip(at_ends, _ENDS[axis], strict=True)
        )

    def reach(self, axis: int) -> float:
        """Return how far the returns on the faces stretch along an axis of the box, metres: it is no shorter than that."""
        return max((float(face.reach[axis]) for face in self.faces), default=0.0)

    @property
    def faces_seen(self) -> int:
        """How many faces have enough returns to count."""
        return sum(face.seen for face in self.faces)

    @property
    def is_box(self) -> bool:
        """Whether the object may be called a box."""
        needed = MIN_EXPLAINED_FEW if self.returns < FEW_POINTS else MIN_EXPLAINED
        fits = self.explained >= needed and self.overlap >= MIN_OVERLAP and self.faces_seen > 0
        return fits and not self.evidence.against(self.size) and not self.evidence.endless

    @property
    def why_not(self) -> str:
        """The reason where it is no box: the image's border where all that it lacks is an end, else its shape."""
        return "cut_by_border" if self.cut and self.evidence.endless and not self.evidence.against(self.size) else "not_a_box"


def assess(box: Box, evaluation: Evaluation, pixels: Pixels, image: RangeImage, own: Mask, sigma: Array) -> Quality:
    """Return the quality of a fitted box.

    Args:
        box: The fitted box, in the frame of this scan's camera.
        evaluation: Its likelihood at the pixels.
        pixels: The pixels it was fitted to.
        image: The scan.
        own: (h, w) mask of the object's pixels.
        sigma: (n,) standard deviation of each pixel's range as the floor shows it, metres.
    """
    returned = np.isfinite(pixels.ranges) & ~pixels.other
    inside = (evaluation.inside > 1) & returned
    on_face = on_faces(evaluation, pixels, sigma)
    claimed, weight = evaluation.inside > 0, pixels.weight
    covered = float(weight[claimed & returned].sum())
    both = float(weight[on_face].sum() + weight[claimed & ~inside & returned].sum())
    faces = face_views(box, evaluation, pixels, on_face)
    returns = float(weight[on_face].sum())
    behind, before = holes(evaluation, pixels, sigma)
    return Quality(
        explained=float(weight[on_face].sum() / max(weight[inside].sum(), 1)),
        overlap=both / max(covered + max(float(own.sum()) - both, 0.0), 1.0),
        faces=faces,
        returns=int(returns),
        border=float(border_share(box, pixels.plane.to_pixels, pixels.plane.size)),
        evidence=Evidence(
            relief=relief(evaluation, pixels, on_face, sigma),
            holes=behind,
            proud=before,
            free_edge=free_edge(evaluation, pixels, sigma),
            bulge=_bulge(box, faces),
            slender=bool(box.extents[2] > MAX_SLENDER * box.extents[:2].max()),
            sliver=bool(box.extents.min() < MIN_THICKNESS and returns < 0.01 * image.ranges.size),
            flaps=flaps(box, pixels, returns, sigma),
        ),
        size=float(np.cbrt(box.volume)),
    )


def widened(covariance: Array, quality: Quality) -> Array:
    """Return the (9, 9) covariance of a box with what bent faces and flaps add: their sides are not where a flat face would be.

    A face bent by a depth may end anywhere within it, and turns the box, so that the other sides follow by half of it. Flaps drag
    the edges that they hang on.
    """
    added = np.zeros(3)
    for face in quality.faces:
        if abs(face.bend) > BENT_M:
            added += (face.bend * np.where(np.arange(3) == _AXIS[face.name], 1.0, 0.5)) ** 2
    if quality.evidence.flaps > MIN_FLAPS:
        added += (FLAPS_WIDEN * quality.size) ** 2
    wider = covariance.copy()
    wider[range(6, 9), range(6, 9)] += added
    return np.asarray(wider)


def _bulge(box: Box, faces: tuple[FaceView, ...]) -> float:
    """Return the deepest bend of a well-seen face over that face's shorter side."""
    depths = [abs(face.bend) / float(np.delete(box.extents, _AXIS[face.name]).min()) for face in faces if face.returns >= 100]
    return max(depths, default=0.0)


def on_faces(evaluation: Evaluation, pixels: Pixels, sigma: Array) -> Mask:
    """Return the (n,) mask of pixels well inside the outline whose range agrees with the box: four sigma, 5 mm and 0.4 %."""
    inside = (evaluation.inside > 1) & np.isfinite(pixels.ranges) & ~pixels.other
    return np.asarray(inside & (np.abs(pixels.ranges - evaluation.hits.ranges) < tolerance(pixels.ranges, sigma)))


def flags(quality: Quality, *, is_open: bool, touching: bool) -> tuple[str, ...]:
    """Return the names of everything a user should know about a measured box, in a fixed order."""
    named = {
        "cut": quality.cut,
        "open": is_open,
        "grazing": any(face.incidence > GRAZING for face in quality.faces),
        "bent": any(abs(face.bend) > BENT_M for face in quality.faces),
        "few_points": quality.returns < FEW_POINTS,
        "touching": touching,
        "flaps": quality.evidence.flaps > MIN_FLAPS,
    }
    return tuple(name for name, holds in named.items() if holds)


def face_views(box: Box, evaluation: Evaluation, pixels: Pixels, on_face: Mask) -> tuple[FaceView, ...]:
    """Return the faces of ``box`` that are turned towards the camera, with their returns among ``on_face`` (n,)."""
    shown = edges_shown(box, pixels.plane.to_pixels, pixels.plane.size)
    views = []
    for index, angle in enumerate(incidence(box)):
        mine = on_face & (evaluation.hits.planes == index)
        if np.isfinite(angle):
            returns, bend, reach = int(pixels.weight[mine].sum()), _bend(evaluation, pixels, mine), _reach(box, pixels, mine)
            views.append(FaceView(FACES[index], float(angle), returns, bend, shown[index], reach))
    return tuple(views)


def _reach(box: Box, pixels: Pixels, mine: Mask) -> Vector3:
    """Return the (3,) stretch of a face's returns along the axes of the box."""
    if not mine.any():
        return np.zeros(3)
    points = pixels.directions[mine] * pixels.ranges[mine, None]
    low, high = np.quantile((points - box.box_to_camera[:3, 3]) @ box.box_to_camera[:3, :3], [0.01, 0.99], axis=0)
    return np.asarray(high - low)


def _bend(evaluation: Evaluation, pixels: Pixels, mine: Mask) -> float:
    """Return the depth of the least-squares paraboloid through a face's residuals, zero unless it is beyond three sigma."""
    if mine.sum() < 4 * MIN_FACE_POINTS:
        return 0.0
    image = pixels.image[mine]
    scaled = (image - image.mean(axis=0)) / np.maximum(image.std(axis=0), 1e-9)
    bowl = 1 - np.sum(scaled**2, axis=1) / 2
    design = np.column_stack([np.ones(len(bowl)), scaled, bowl])
    height = (evaluation.hits.ranges[mine] - pixels.ranges[mine]) * evaluation.hits.cosine[mine]
    gram = np.linalg.inv(design.T @ design)
    coefficients = gram @ design.T @ height
    sigma = float(np.std(height - design @ coefficients))
    depth = 2.0 * float(coefficients[3])
    return depth if abs(depth) > 6 * sigma * float(np.sqrt(gram[3, 3])) else 0.0

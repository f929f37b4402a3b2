"""Is it a box, and what should the user know: faces seen, flags, and the share of the evidence that the box explains."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Mask
from viewgain.box import FACES, FLOOR, PLANE_NORMALS, Box, outline
from viewgain.measure._likelihood import Evaluation
from viewgain.measure._mixture import Pixels
from viewgain.measure._range_image import RangeImage

CUT_MARGIN_PX = 1.0
"""An outline that comes this close to the image border is cut."""
GRAZING = np.deg2rad(72.0)
"""A face seen at a larger mean angle of incidence is flagged as grazing."""
FEW_POINTS = 300
"""A box with fewer returns is flagged."""
BENT_M = 0.004
"""A face whose residuals follow a paraboloid of at least this depth is flagged as bent, metres."""
MIN_FACE_POINTS = 25
"""A face counts as seen with at least this many returns."""
SPANNING = (("+y", "-y", "top"), ("+x", "-x", "top"), ("+x", "-x", "+y", "-y"))
"""The faces that contain each axis of the box."""
SPANNING_POINTS = 100
"""A face with at least this many returns shows how far it reaches."""
MIN_EXPLAINED = 0.75
"""An object is a box only if this share of its returns lies on the box's faces."""
MIN_EXPLAINED_FEW = 0.95
"""The same with few returns: on so few, many things look nearly like a box."""
MIN_OVERLAP = 0.6
"""An object is a box only if object and outline share this much of their union."""


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
    cut: bool
    """Whether the outline leaves the image."""

    def spans(self, axis: int) -> bool:
        """Return whether a face with many returns contains this axis of the box (0 x, 1 y, 2 z)."""
        return any(face.returns >= SPANNING_POINTS for face in self.faces if face.name in SPANNING[axis])

    @property
    def faces_seen(self) -> int:
        """How many faces have enough returns to count."""
        return sum(face.seen for face in self.faces)

    @property
    def is_box(self) -> bool:
        """Whether the object may be called a box."""
        needed = MIN_EXPLAINED_FEW if self.returns < FEW_POINTS else MIN_EXPLAINED
        return self.explained >= needed and self.overlap >= MIN_OVERLAP and self.faces_seen > 0


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
    return Quality(
        explained=float(weight[on_face].sum() / max(weight[inside].sum(), 1)),
        overlap=both / max(covered + max(float(own.sum()) - both, 0.0), 1.0),
        faces=face_views(box, evaluation, pixels, on_face),
        returns=int(weight[on_face].sum()),
        cut=is_cut(box, image),
    )


def on_faces(evaluation: Evaluation, pixels: Pixels, sigma: Array) -> Mask:
    """Return the (n,) mask of pixels well inside the outline whose range agrees with the box: four sigma, 5 mm and 0.4 %."""
    inside = (evaluation.inside > 1) & np.isfinite(pixels.ranges) & ~pixels.other
    return np.asarray(inside & (np.abs(pixels.ranges - evaluation.hits.ranges) < 0.005 + 0.004 * pixels.ranges + 4 * sigma))


def is_cut(box: Box, image: RangeImage) -> bool:
    """Return whether the outline of ``box`` leaves the image or comes within a pixel of its border."""
    if np.any(box.corners()[:, 2] <= 0.02):
        return True
    u, v = image.to_pixels(outline(box).vertices).T
    height, width = image.ranges.shape
    margin = CUT_MARGIN_PX - 0.5
    return bool(np.any((u < margin) | (v < margin) | (u > width - 1 - margin) | (v > height - 1 - margin)))


def flags(quality: Quality, *, is_open: bool, touching: bool) -> tuple[str, ...]:
    """Return the names of everything a user should know about a measured box, in a fixed order."""
    named = {
        "cut": quality.cut,
        "open": is_open,
        "grazing": any(face.incidence > GRAZING for face in quality.faces),
        "bent": any(abs(face.bend) > BENT_M for face in quality.faces),
        "few_points": quality.returns < FEW_POINTS,
        "touching": touching,
    }
    return tuple(name for name, holds in named.items() if holds)


def face_views(box: Box, evaluation: Evaluation, pixels: Pixels, on_face: Mask) -> tuple[FaceView, ...]:
    """Return the faces of ``box`` that are turned towards the camera, with their returns among ``on_face`` (n,)."""
    rotation, origin = box.box_to_camera[:3, :3], box.box_to_camera[:3, 3]
    views = []
    for index in range(FLOOR):
        normal = PLANE_NORMALS[index]
        local = normal * box.extents / 2 + np.array([0, 0, box.extents[2] / 2])
        centre = rotation @ local + origin
        cosine = -float(rotation @ normal @ centre) / float(np.linalg.norm(centre))
        if cosine <= 0:
            continue
        mine = on_face & (evaluation.hits.planes == index)
        views.append(
            FaceView(
                FACES[index], float(np.arccos(min(cosine, 1.0))), int(pixels.weight[mine].sum()), _bend(evaluation, pixels, mine)
            )
        )
    return tuple(views)


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

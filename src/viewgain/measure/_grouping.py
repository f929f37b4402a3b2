"""Which patches make one box: a top and the sides that hang from its edges, or sides that meet at a convex corner.

A side hangs from a top that lies wholly behind the side's plane and reaches it. Compared are planes in space, not pixels, so
something in front may hide the crease. All in the frame of the floor, z up (ours).
"""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Indices, Mask, Points
from viewgain.measure._patches import Facing, Patch
from viewgain.measure._range_image import RangeImage
from viewgain.measure._steps import seam_height

_STEP = 0.012
_MIN_GROUP = 60
_MAX_CURVED = 0.25
_REACH = 0.02
_THROUGH = 0.01
_LINES = 120
_STEPS = 80
_GAP_PX = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """The patches of one box."""

    pixels: Indices
    """(n,) row-major pixel indices into the image."""
    points: Points
    """(n, 3) points in the frame of the floor."""
    has_top: bool
    """Whether a lying patch is among them, or a seam shows where its top is."""
    tilted: bool = False
    """Whether it is a patch that neither lies nor stands upright."""
    curved: bool = False
    """Whether over a quarter of it bends as no carton does."""

    @property
    def top(self) -> float:
        """Height of its upper end above the floor, metres."""
        return float(np.quantile(self.points[:, 2], 0.98))

    @property
    def bottom(self) -> float:
        """Height of its lowest points, metres."""
        return float(np.quantile(self.points[:, 2], 0.05))

    def mask(self, shape: tuple[int, ...]) -> Mask:
        """Return its (h, w) pixels."""
        mask = np.zeros(shape, dtype=bool)
        mask.ravel()[self.pixels] = True
        return mask


def groups(found: list[Patch], image: RangeImage, noise: float) -> list[Group]:
    """Return the boxes-to-be among patches: those with a top first, lowest first.

    Args:
        found: The patches of the object.
        image: The scan: a gap between two tops that something nearer hides is no gap.
        noise: Standard deviation of one pixel's range, metres.
    """
    tolerance = _STEP + noise
    lying = _united([patch for patch in found if patch.facing is Facing.LYING], image, tolerance)
    upright = _united([patch for patch in found if patch.facing is Facing.UPRIGHT], image, tolerance)
    hung, loose = _hung(lying, upright, tolerance)
    made = [part for top, sides in zip(lying, hung, strict=True) for part in _storeys(top, sides)]
    made += [_group(sides, has_top=False) for sides in _cornered(loose, tolerance)]
    made += [_group([patch], has_top=False, tilted=True) for patch in found if patch.facing is Facing.TILTED]
    made = [group for group in made if len(group.pixels) >= _MIN_GROUP]
    return sorted(made, key=lambda group: (group.tilted, not group.has_top, group.top))


def _group(members: list[Patch], *, has_top: bool, tilted: bool = False) -> Group:
    pixels, points = (np.concatenate(parts) for parts in zip(*((p.pixels, p.points) for p in members), strict=True))
    curved = sum(len(p.pixels) for p in members if len(p.pixels) >= _MIN_GROUP and p.is_curved())
    return Group(pixels, points, has_top, tilted, curved > _MAX_CURVED * len(pixels))


def _storeys(top: Patch, sides: list[Patch]) -> list[Group]:
    """Return the box of a top and its sides, or where the sides step outwards, the box above the seam and the one beneath."""
    seam = seam_height(sides)
    if seam is None:
        return [_group([top, *sides], has_top=True)]
    upper = [side.points[:, 2] > seam for side in sides]
    above = [_part(side, chosen) for side, chosen in zip(sides, upper, strict=True) if np.any(chosen)]
    below = [_part(side, ~chosen) for side, chosen in zip(sides, upper, strict=True) if not np.all(chosen)]
    return [_group([top, *above], has_top=True), _group(below, has_top=True)]


def _hung(lying: list[Patch], upright: list[Patch], tolerance: float) -> tuple[list[list[Patch]], list[Patch]]:
    """Return the sides of each top, and the sides without one.

    Of a side that several tops may carry (the flush front of a stack or a row) each pixel goes to the lowest top above it whose
    width it lies within.
    """
    hung: list[list[Patch]] = [[] for _ in lying]
    loose = []
    for side in upright:
        owner = np.full(len(side.pixels), -1)
        for k in sorted(range(len(lying)), key=lambda k: -lying[k].height):
            owner[_carried(lying[k], side, tolerance)] = k
        for k in range(len(lying)):
            if np.any(owner == k):
                hung[k].append(_part(side, owner == k))
        if np.sum(owner < 0) >= _MIN_GROUP:
            loose.append(_part(side, owner < 0))
    return hung, loose


def _carried(top: Patch, side: Patch, tolerance: float) -> Mask:
    """Return the (n,) mask of a side's pixels that hang from a top; none where the top is not at its plane."""
    none = np.zeros(len(side.pixels), dtype=bool)
    along = np.array([-side.normal[1], side.normal[0], 0.0])
    place = side.points @ along
    level = top.points @ along
    low, high = np.quantile(level, [0.01, 0.99])
    below = (side.points[:, 2] < top.height + tolerance) & (place > low - tolerance) & (place < high + tolerance)
    if below.sum() < 0.2 * len(below) and below.sum() < _MIN_GROUP:
        return none
    if not np.any(below) or np.quantile(side.points[below, 2], 0.98) < top.height - 2 * tolerance:
        return none
    start, end = np.quantile(place[below], [0.02, 0.98])
    beside = (level > start) & (level < end)
    if beside.sum() < 20:
        return none
    ahead = side.beyond(top.points[beside])
    reach = np.quantile(ahead, 0.98)
    return np.asarray(below) if -_REACH - tolerance < reach < tolerance else none


def _cornered(sides: list[Patch], tolerance: float) -> list[list[Patch]]:
    """Return groups of topless sides: two that meet at a convex right angle belong together."""
    made: list[list[Patch]] = []
    for side in sides:
        for group in made:
            if len(group) < 2 and _convex(group[0], side, tolerance):
                group.append(side)
                break
        else:
            made.append([side])
    return made


def _convex(first: Patch, second: Patch, tolerance: float) -> bool:
    if abs(first.normal @ second.normal) > 0.3:
        return False
    one, two = np.quantile(first.beyond(second.points), 0.97), np.quantile(second.beyond(first.points), 0.97)
    return bool(max(one, two) < tolerance and min(one, two) > -_REACH - tolerance)


def _united(parts: list[Patch], image: RangeImage, tolerance: float) -> list[Patch]:
    """Return the patches, those joined that lie in one plane with no gap between them but a nearer object."""
    kept: list[Patch] = []
    for part in parts:
        for k, other in enumerate(kept):
            if _one_plane(other, part, tolerance) and _bridged(other, part, image):
                kept[k] = Patch(
                    np.concatenate([other.pixels, part.pixels]),
                    np.concatenate([other.points, part.points]),
                    other.normal,
                    other.offset,
                    other.facing,
                )
                break
        else:
            kept.append(part)
    return kept


def _one_plane(first: Patch, second: Patch, tolerance: float) -> bool:
    """Return whether two patches face one way with no step between.

    The second must lie in the plane of the first, the larger; or each be as far before the other's: a bend, no step.
    """
    ahead, behind = (float(np.median(one.beyond(two.points))) for one, two in ((first, second), (second, first)))
    step = min(abs(ahead), abs(ahead - behind) / 2)
    return bool(first.normal @ second.normal > 0.9 and step < tolerance / 2 + 0.002)


def _bridged(first: Patch, second: Patch, image: RangeImage) -> bool:
    """Return whether nothing shows a gap between two patches of one plane.

    Of straight lines in the image from one patch to the other, those that something nearer hides tell nothing; of the others
    at most one in ten may show something behind the plane for longer than a speck. Where all are hidden they are one patch.
    """
    ranges, width = image.ranges, image.ranges.shape[1]
    one, two = (patch.pixels[np.linspace(0, len(patch.pixels) - 1, _LINES).astype(int)] for patch in (first, second))
    start, end = (np.stack(np.divmod(pixels, width), axis=1) for pixels in (one, two[::-1]))
    steps = np.linspace(0, 1, _STEPS)[:, None]
    lines = np.round(start[:, None] + steps * (end - start)[:, None]).astype(int)
    near, far = ranges.ravel()[one][:, None], ranges.ravel()[two[::-1]][:, None]
    expected = 1 / ((1 - steps.T) / near + steps.T / far)
    other = ~np.isin(lines @ (width, 1), np.concatenate([first.pixels, second.pixels]))
    length = np.linalg.norm(end - start, axis=1)
    with np.errstate(invalid="ignore"):
        apart = ranges[lines[..., 0], lines[..., 1]] - expected
        gap, hidden = (np.mean(other & seen, axis=1) * length > _GAP_PX for seen in (apart > _THROUGH, apart < -_THROUGH))
    telling = gap | ~hidden
    return bool(gap.sum() <= 0.1 * telling.sum())


def _part(patch: Patch, chosen: Mask) -> Patch:
    return Patch(patch.pixels[chosen], patch.points[chosen], patch.normal, patch.offset, patch.facing)

"""Where did the cameras stand, if nobody says so? Told by the boxes themselves: their sizes and how they stand on the floor.

One box that two scans share places one camera relative to the other, up to the box's own symmetry; further shared boxes must
then fall onto each other, which settles the symmetry too. Ours.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from viewgain.arrays import Pose
from viewgain.box import Box
from viewgain.geometry import inverse
from viewgain.measure._match import SAME_BOX, Extents, extents_of, grown, pooled, quarter_turn
from viewgain.measure._result import BoxEstimate, Measurement

REACH = (0.03, 0.04)
"""How far apart two sightings of one box may lie on the floor: metres, and per metre from the box that ties the scans together
(2 degrees of yaw)."""
_YAW = np.deg2rad(8.0)


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """One box as one scan saw it, and where that puts it."""

    estimate: BoxEstimate
    """What the scan alone says."""
    extents: Extents
    """Its extents along its own axes."""
    placed: Box
    """The box in the map's frame."""
    quarters: int
    """Quarter-turns from its axes to those of the group's first sighting."""


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """One way to lay a scan onto the map."""

    camera_to_map: Pose
    """(4, 4) pose of its camera."""
    pairs: tuple[tuple[int, int, int], ...]
    """Group, box of the scan, and quarter-turns between their axes: which boxes fall onto each other."""
    score: float
    """Over zero: how far the chi-squares of the extents stay below what would be refused, summed over the pairs."""


@dataclass(frozen=True, slots=True, eq=False)
class Registration:
    """Which boxes of several scans are the same, and where the cameras stood: in the frame of one of them."""

    groups: tuple[dict[int, Sighting], ...]
    """One box each: its sighting in every scan that shows it."""
    camera_to_map: dict[int, Pose]
    """(4, 4) pose of each scan's camera; scans that share no box with the others are missing."""
    settled: frozenset[int]
    """Scans whose quarter-turns are settled by more than one box."""


def register(results: list[Measurement]) -> Registration:
    """Return which boxes of at least one scan are the same, and how the cameras stood to each other.

    It starts from the scan that knows most and adds the one that fits best, then the next; so the order of scans does not
    matter. A scan without a box, or with none that fits, is left out.
    """
    sights = {k: [_sighted(box, np.eye(4)) for box in result.candidates] for k, result in enumerate(results) if result.candidates}
    if not sights:
        return Registration((), {}, frozenset())
    anchor = max(sights, key=lambda k: _worth(sights[k]))
    groups = [{anchor: sight} for sight in sights.pop(anchor)]
    cameras, settled = {anchor: np.eye(4)}, {anchor}
    while links := {k: link for k in sights if (link := best_link(groups, sights[k])) is not None}:
        k = max(links, key=lambda scan: links[scan].score)
        cameras[k] = links[k].camera_to_map
        settled |= {k} if len(links[k].pairs) > 1 else set()
        _add(groups, k, sights.pop(k), links[k])
    return Registration(tuple(groups), cameras, frozenset(settled))


def best_link(groups: list[dict[int, Sighting]], sights: list[Sighting]) -> Link | None:
    """Return the best way to lay a scan's boxes onto the map's; None if there is none without contradiction."""
    return max(_links(groups, sights), key=lambda link: link.score, default=None)


def _links(groups: list[dict[int, Sighting]], sights: list[Sighting]) -> Iterator[Link]:
    known = [next(iter(group.values())) for group in groups]
    for g, there in enumerate(known):
        for b, here in enumerate(sights):
            for quarters in range(4):
                both = pooled([there.extents, here.extents.turned(quarters)])
                common = _common(there.extents, here.extents.turned(quarters))
                if both.misfit <= SAME_BOX and common >= (1 if len(sights) == len(groups) == 1 else 2):
                    own = grown(here.estimate, both.values[[1, 0, 2]] if quarters % 2 else both.values)
                    stands = grown(replace(there.estimate, box=there.placed), both.values)
                    motion = stands.box_to_camera @ quarter_turn(quarters) @ inverse(own.box_to_camera)
                    link = _checked(
                        known, sights, motion, Link(motion, ((g, b, quarters),), (SAME_BOX - both.misfit) * common / 3)
                    )
                    if link is not None:
                        yield link


def _checked(known: list[Sighting], sights: list[Sighting], motion: Pose, link: Link) -> Link | None:
    """Return a link with the further boxes that fall onto each other; None if two different boxes would share a place."""
    pairs, score = link.pairs, link.score
    ((g, b, _),) = link.pairs
    hub = known[g].placed.centre
    for other, here in enumerate(sights):
        if other == b:
            continue
        moved = here.estimate.box.in_frame(motion)
        for k, there in enumerate(known):
            gap = float(np.linalg.norm(moved.centre - there.placed.centre))
            overlapping = gap < 0.4 * float(min(*moved.extents[:2], *there.placed.extents[:2]))
            reach = REACH[0] + REACH[1] * float(np.linalg.norm(moved.centre - hub)) + _slack(here) + _slack(there)
            quarters = _quarters(moved, there.placed)
            taken = any(k == pair[0] for pair in pairs)
            if gap < reach and quarters is not None and not taken:
                turned = here.extents.turned(quarters)
                misfit = pooled([there.extents, turned]).misfit
                if misfit <= SAME_BOX:
                    pairs = (*pairs, (k, other, quarters))
                    score += (SAME_BOX - misfit) * _common(there.extents, turned) / 3
                    break
            if overlapping:
                return None
    return Link(motion, pairs, score)


def _common(one: Extents, other: Extents) -> int:
    """Return how many extents both bound: only those tell whether it is the same box."""
    return int(np.sum(one.is_closed & other.is_closed))


def _slack(sight: Sighting) -> float:
    """Return how far the centre of a box that is open may lie from where it is given."""
    return float(np.max(sight.estimate.box.extents)) if any(sight.estimate.is_open) else 0.0


def _quarters(moved: Box, there: Box) -> int | None:
    """Return the quarter-turns from the axes of one box to those of another; None where they are not nearly quarter-turns."""
    forward = there.box_to_camera[:3, :3].T @ moved.box_to_camera[:3, 0]
    yaw = float(np.arctan2(forward[1], forward[0]))
    quarters = round(yaw / (np.pi / 2))
    return quarters % 4 if abs(yaw - quarters * np.pi / 2) < _YAW else None


def _add(groups: list[dict[int, Sighting]], scan: int, sights: list[Sighting], link: Link) -> None:
    """Add a scan's boxes to the groups they belong to, or as new groups."""
    paired = {b: (g, quarters) for g, b, quarters in link.pairs}
    for b, sight in enumerate(sights):
        placed = _sighted(sight.estimate, link.camera_to_map)
        if b in paired:
            g, quarters = paired[b]
            groups[g][scan] = replace(placed, quarters=quarters)
        else:
            groups.append({scan: placed})


def _sighted(estimate: BoxEstimate, camera_to_map: Pose) -> Sighting:
    return Sighting(estimate, extents_of(estimate), estimate.box.in_frame(camera_to_map), 0)


def _worth(sights: list[Sighting]) -> tuple[int, float]:
    """Return how many closed boxes a scan shows, then how precisely it knows their sizes."""
    return sum(not any(s.estimate.is_open) for s in sights), sum(float(np.linalg.slogdet(s.extents.precision)[1]) for s in sights)

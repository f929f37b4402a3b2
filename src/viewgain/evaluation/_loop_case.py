"""One box measured view after view: every scan that any policy may take of it, and what any of them say together."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from viewgain.errors import ConfigError, ViewgainError
from viewgain.evaluation._volume_case import VolumeCase, VolumeSettings, volume_case
from viewgain.gain import MISS, believed_scan, costs, measured_volume
from viewgain.measure import POSE_SIGMA, Measurement, fuse_measurements, measure
from viewgain.plan import Seen, believe, certainty, unique
from viewgain.scans import Scan

Positions = tuple[int, ...]
"""Where scans were taken, in order; the first is where the camera stood at the beginning."""
_Visits = tuple[tuple[int, int], ...]
"""Scans: position and number of the visit to it, from 0 on."""
_OF_BOXES = ("seed", "rig", "camera", "side", "distance", "elevation_deg", "off_centre")
"""What of the question about boxes the loop depends on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LoopSettings:
    """What is asked: boxes, rig, camera, and when to stop. Two of equal settings are about the same boxes and the same scans."""

    boxes: VolumeSettings
    """Boxes, rig and camera; ``fused``, so that measured by the default estimator. Its captures are not looked at."""
    most_views: int = 4
    """Scans that are taken of each box, 2 or more."""
    tolerance: float = 0.02
    """Relative volume error asked for, between 0 and 1."""
    confidence: float = 0.95
    """Probability asked for: the rule says stop when P(error < tolerance) exceeds it."""

    def __post_init__(self) -> None:
        if not self.boxes.fused:
            raise ConfigError("evaluate loop: got boxes that are measured scan by scan, wanted fused=True")
        if self.most_views < 2:
            raise ConfigError(f"evaluate loop: got {self.most_views} views at most, wanted 2 or more")
        if not 0 < self.tolerance < 1 or not 0 < self.confidence < 1:
            raise ConfigError(
                f"evaluate loop: got tolerance {self.tolerance} and confidence {self.confidence}, wanted both between 0 and 1"
            )

    def to_dict(self) -> dict[str, Any]:
        """Return the question as plain values for JSON."""
        asked = self.boxes.to_dict()
        return {
            **{name: asked[name] for name in _OF_BOXES if name in asked},
            "most_views": self.most_views,
            "tolerance": self.tolerance,
            "confidence": self.confidence,
        }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Known:
    """What some scans say together, held against the truth."""

    error: float
    """|V / V* - 1|, at most 1; 1 without a volume."""
    chance: float
    """Probability that the planner gives the error to be within the tolerance; 0 where it believes nothing."""
    enough: bool
    """Whether its rule says stop."""


class Loop:
    """A box of a seed. Scan k of a position is the same whoever takes it and whenever, and is made and measured once.

    What is known is fused in the order of the positions and not in that of taking, so it depends on the scans alone: policies
    that took the same ones know the same, and so does whoever tries all sets of them. What a policy plans from has the present
    camera last.
    """

    def __init__(self, settings: LoopSettings, number: int) -> None:
        """Draw box ``number``; raises ConfigError as :func:`viewgain.evaluation.volume_case`."""
        self.settings = settings
        self.case: VolumeCase = volume_case(settings.boxes, number)
        self._scans: dict[tuple[int, int], Scan | None] = {}
        self._measured: dict[tuple[int, int], Measurement | None] = {}
        self._fused: dict[_Visits, Measurement | None] = {}
        self._known: dict[Positions, Known] = {}

    @cached_property
    def reachable(self) -> Positions:
        """Positions where the camera can stand, in rig order."""
        return tuple(np.flatnonzero(self.case.reachable).tolist())

    @property
    def start(self) -> Positions:
        """Where the first scan is taken."""
        return (self.case.present,)

    def known(self, positions: Positions) -> Known:
        """Return what the scans from these positions say together; of one named twice there are two scans."""
        key = tuple(sorted(positions))
        if key not in self._known:
            self._known[key] = self._judged(key)
        return self._known[key]

    def seen(self, positions: Positions) -> Seen:
        """Return what a policy knows after scans from these positions, in this order."""
        visits = _visits(positions)
        scans = [self._scan(*each) for each in visits]
        placed = [self.case.stations[place] for place in positions]
        stands = [
            stand if scan is None or scan.camera_to_world is None else scan.camera_to_world
            for stand, scan in zip(placed, scans, strict=True)
        ]
        return Seen(
            tuple(scan for scan in scans if scan is not None),
            np.stack(stands),
            self.case.stations,
            unique(positions),
            self.case.camera.intrinsics,
            self._together((*sorted(visits[:-1]), visits[-1])),
        )

    def around(self, positions: Positions) -> int:
        """Return the next reachable position after the last one, round and round."""
        return next((place for place in self.reachable if place > positions[-1]), self.reachable[0])

    def _judged(self, positions: Positions) -> Known:
        asked, measured = self.settings, self._together(_visits(positions))
        if measured is None:
            return Known(error=MISS, chance=0.0, enough=False)
        belief = believe(measured, self.case.camera)
        sure = None if belief is None else certainty(belief, tolerance=asked.tolerance, confidence=asked.confidence)
        return Known(
            error=float(costs(measured_volume(measured) / self.case.box.volume - 1)),
            chance=0.0 if sure is None else sure.within_tolerance,
            enough=sure is not None and sure.enough,
        )

    def _together(self, visits: _Visits) -> Measurement | None:
        """Return what scans say together, in the frame of the last that can be measured; None if none can."""
        if visits not in self._fused:
            each = [self._one(*visit) for visit in visits]
            scans = [measured for measured in each if measured is not None]
            try:
                self._fused[visits] = fuse_measurements(scans) if scans else None
            except (ViewgainError, np.linalg.LinAlgError):  # a miss is a miss, whatever its name
                self._fused[visits] = None
        return self._fused[visits]

    def _one(self, position: int, visit: int) -> Measurement | None:
        key = (position, visit)
        if key not in self._measured:
            scan = self._scan(position, visit)
            try:
                self._measured[key] = None if scan is None else measure(scan, camera=self.case.camera)
            except (ViewgainError, np.linalg.LinAlgError):
                self._measured[key] = None
        return self._measured[key]

    def _scan(self, position: int, visit: int) -> Scan | None:
        key = (position, visit)
        if key not in self._scans:
            self._scans[key] = believed_scan(self.case.scans, position, visit, POSE_SIGMA)
        return self._scans[key]


def _visits(positions: Positions) -> _Visits:
    """Return each position with the number of earlier scans from it."""
    return tuple((place, positions[:index].count(place)) for index, place in enumerate(positions))

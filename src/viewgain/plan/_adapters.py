"""The two kinds of policy in each other's place: a general one where a box is planned for, one about a box in any episode."""

from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from viewgain.arrays import Poses, Vector
from viewgain.camera import Intrinsics, Sensor
from viewgain.geometry import inverse
from viewgain.measure import POSE_SIGMA, Measurement, fuse, measure
from viewgain.plan._belief import Belief
from viewgain.plan._believed import believe
from viewgain.plan._place import place_amid
from viewgain.plan._policy import Assessment, Policy
from viewgain.plan._views import Seen, ViewPolicy, visited_among
from viewgain.scans import Scan

PolicyT_co = TypeVar("PolicyT_co", bound=Policy, covariant=True)
"""Which policy about a box."""


@dataclass(frozen=True, slots=True, eq=False)
class OnScans:
    """A general policy as one about a box: asked with a belief, it looks at the scans instead.

    Its scores come out as places, 0 for the best, -1 for the next, -2, ... (of equal ones the lower index is the better), so that
    what :func:`viewgain.plan.next_view` makes of nearly equal scores does not overrule it.
    """

    policy: ViewPolicy
    """Who decides."""
    scans: tuple[Scan, ...]
    """The scans so far, each with its pose; the last is the camera as it stands."""
    camera: Intrinsics
    """The camera's image."""

    @property
    def name(self) -> str:
        """The policy's."""
        return self.policy.name

    def assess(self, belief: Belief, candidates: Poses, tolerance: float) -> tuple[Assessment, ...]:
        """Return one assessment per candidate, (v, 4, 4) ``camera_to_current``."""
        del belief, tolerance
        stands = np.stack([scan.camera_to_world for scan in self.scans if scan.camera_to_world is not None])
        there = stands[-1] @ candidates
        seen = Seen(self.scans, stands, there, visited_among(there, stands), self.camera)
        scores = np.nan_to_num(self.policy.scores(seen), nan=-np.inf, posinf=np.inf, neginf=-np.inf)
        places = np.empty(len(scores))
        places[np.argsort(-scores, kind="stable")] = np.arange(len(scores))
        return tuple(Assessment(-float(place), None, None) for place in places)


@dataclass(frozen=True, slots=True, eq=False)
class OnBelief(Generic[PolicyT_co]):
    """A policy about a box as a general one: it measures the scans so far and asks the policy what it believes.

    It measures all scans anew at every question, but where it is told what they say together. Told that the candidates were put
    up around the box, it takes what they look at for the box's place, and has a belief where nothing could be measured, too.
    """

    policy: PolicyT_co
    """Who decides."""
    sensor: Sensor
    """The camera."""
    tolerance: float = 0.05
    """Relative volume error asked for."""
    pose_sigma: tuple[float, float] = POSE_SIGMA
    """Standard deviation of camera poses, metres and radians per axis."""
    around: float | None = None
    """How far the point that all candidates look at may lie from the box's centre, standard deviation per axis, metres; None:
    that they look at the box is no news, for they were put up around what was measured."""

    @property
    def name(self) -> str:
        """The policy's."""
        return self.policy.name

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) scores; NaN where nothing is believed, or no scan showed anything."""
        known = self.measuring(seen)
        return self.scored(self.belief(known), known)

    def scored(self, belief: Belief | None, known: Seen) -> Vector:
        """Return the same from what is believed after :meth:`measuring`."""
        here = None if known.measured is None else known.measured.camera_to_world
        if belief is None or here is None:
            return np.full(len(known.candidates), np.nan)
        assessed = self.policy.assess(belief, inverse(here) @ known.candidates, self.tolerance)
        return np.array([assessment.score for assessment in assessed])

    def measuring(self, seen: Seen) -> Seen:
        """Return what was seen, with what the scans say together; without scans as it is."""
        if seen.measured is not None or not seen.scans:
            return seen
        return replace(seen, measured=self._measured(list(seen.scans)))

    def belief(self, seen: Seen) -> Belief | None:
        """Return what is believed after :meth:`measuring`; None without a scan, and where nobody knows of a box."""
        if seen.measured is None:
            return None
        here = seen.measured.camera_to_world
        place = None if self.around is None or here is None else place_amid(inverse(here) @ seen.candidates, self.around)
        return believe(seen.measured, self.sensor, place, seen.scans)

    def _measured(self, scans: list[Scan]) -> Measurement:
        if len(scans) == 1:
            return measure(scans[0], camera=self.sensor)
        return fuse(scans, camera=self.sensor, pose_sigma=self.pose_sigma)

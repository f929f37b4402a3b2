"""Greedy oracles: policies that know the truth and take the view that helps most at once. The ceiling of greedy policies."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Pose, Vector
from viewgain.episodes._coverage import CoverageWorld
from viewgain.episodes._episode import World, volume_error
from viewgain.errors import ScanError
from viewgain.gain import CoverageGain, Rule, TakenViews
from viewgain.measure import Measurement, fuse_measurements, measure
from viewgain.plan import Seen


@dataclass(frozen=True, slots=True, eq=False)
class CoverageOracle:
    """Takes the view that covers the most samples not covered yet."""

    world: CoverageWorld
    """The world it is asked about; candidates are its views, in its order."""
    rule: Rule = "union"
    """How what a view adds is counted."""
    name: str = "oracle"

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) shares of the surface that each view adds."""
        return CoverageGain(self.rule).gains(TakenViews(self.world.covered, seen.visited))


@dataclass(frozen=True, slots=True, eq=False)
class VolumeOracle:
    """Takes the view after which the box's volume is measured with the least error, by simulating every one of them.

    The camera's true place is not known exactly even to it: it simulates from where the camera believes to be.
    """

    world: World
    """The truth."""
    rng: np.random.Generator
    """Source of the noise of the simulated scans, which is not that of the scans to come."""
    draws: int = 1
    """Scans simulated per candidate; the error is their mean."""
    name: str = "oracle"

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) minus the relative volume error after each candidate; NaN where it would see nothing."""
        known = [measure(scan, camera=self.world.sensor) for scan in seen.scans]
        return np.array([-self._error_after(known, candidate) for candidate in seen.candidates])

    def _error_after(self, known: list[Measurement], candidate: Pose) -> float:
        errors = []
        for rng in self.rng.spawn(self.draws):
            try:
                scan = self.world.scan(candidate, candidate, rng)
            except ScanError:
                return float("nan")
            single = measure(scan, camera=self.world.sensor)
            fused = fuse_measurements([*known, single], pose_sigma=self.world.pose_sigma)
            errors.append(volume_error(fused, self.world.box))
        return float(np.mean(errors))

"""Coverage as an objective: what each view would add to the views that were taken."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Vector
from viewgain.errors import ConfigError
from viewgain.gain._bits import size
from viewgain.gain._cover import Cover
from viewgain.gain._coverage import NewPoints, Rule


@dataclass(frozen=True, slots=True, eq=False)
class TakenViews:
    """The true surface, what every view covers of it, and which views were taken."""

    cover: Cover
    """What the views cover."""
    taken: tuple[int, ...] = ()
    """The views taken so far, in order; the published rule hangs on the order."""

    def __post_init__(self) -> None:
        if any(not 0 <= view < self.cover.views for view in self.taken):
            raise ConfigError(f"taken views: got {self.taken}, wanted numbers from 0 to {self.cover.views - 1}")


@dataclass(frozen=True, slots=True)
class CoverageGain:
    """Share of the surface that each view adds, by the published rule or by set union."""

    rule: Rule = "published"
    """Which rule."""

    @property
    def name(self) -> str:
        """Says the rule."""
        return f"coverage_{self.rule}"

    def gains(self, known: TakenViews) -> Vector:
        """Return the (V,) shares; 0 for a view that was taken."""
        covered = known.cover
        if self.rule == "union":
            seen = np.bitwise_or.reduce(covered.masks[list(known.taken)], axis=0, initial=0)
            return size(covered.masks & ~seen) / covered.surface_count
        fresh = NewPoints(covered)
        for view in known.taken:
            fresh.accumulate(view)
        return fresh.gains / covered.surface_count

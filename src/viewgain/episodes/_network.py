"""A trained network as a policy of coverage episodes: it sees the cloud of all views so far."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Points, Vector
from viewgain.errors import ConfigError
from viewgain.geometry import inverse, transform
from viewgain.inference import Scorer
from viewgain.plan import Seen

_DRAWN = 4096
"""Points that are drawn from the cloud before the network's own thinning, which looks for places given twice."""


@dataclass(frozen=True, slots=True, eq=False)
class NetworkExplorer:
    """Takes the view of the highest score, in a world whose object is normalised: its box at the origin, of diagonal 1.

    A network with view state is told all visited views and scores in the order of the rig. One without knows the cloud alone;
    its scores come with the present view first and are rolled to where that view stands. Who asks rules the visited views out.
    """

    scorer: Scorer
    """The network; of the object frame, or of the camera's, then the present one's."""
    name: str = "network"
    seed: int = 0
    """Of the thinning."""

    def scores(self, seen: Seen) -> Vector:
        """Return (V,) predicted gains of coverage; NaN as long as nothing was seen.

        Raises:
            ConfigError: If there are other candidates than the network's own number of views, or no view was taken.
        """
        card = self.scorer.card
        if len(seen.candidates) != card.views or not seen.visited:
            raise ConfigError(
                f"network {card.name}: got {len(seen.candidates)} candidates, {len(seen.visited)} visited; wanted the"
                f" {card.views} of its rig {card.rig}, one or more visited"
            )
        if not seen.scans:
            return np.full(card.views, np.nan)
        points, present = self._cloud(seen), seen.visited[-1]
        if not card.with_view_state:
            return np.roll(self.scorer.scores(points, seed=self.seed), present)
        return self.scorer.scores(points, ~seen.unvisited, seed=self.seed)

    def _cloud(self, seen: Seen) -> Points:
        """Return (n, 3) points of all scans in the network's frame, drawn without repetition where there are many."""
        poses = [np.eye(4) if scan.camera_to_world is None else scan.camera_to_world for scan in seen.scans]
        ends = np.cumsum([len(scan.points) for scan in seen.scans])
        rng = np.random.default_rng([self.seed, len(seen.visited), seen.visited[-1]])
        chosen = np.sort(rng.choice(ends[-1], _DRAWN, replace=False)) if ends[-1] > _DRAWN else np.arange(ends[-1])
        starts = ends - [len(scan.points) for scan in seen.scans]
        parts = [
            transform(pose, scan.points[chosen[(chosen >= start) & (chosen < end)] - start])
            for scan, pose, start, end in zip(seen.scans, poses, starts, ends, strict=True)
        ]
        points = np.concatenate(parts)
        return points if self.scorer.card.frame == "object" else transform(inverse(seen.stands[-1]), points)

"""Who says how likely a view that was chosen for the volume is nearly the best in reach, whoever chose it."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Mask, Poses
from viewgain.errors import ConfigError
from viewgain.inference import volume_scorer
from viewgain.measure import POSE_SIGMA
from viewgain.plan._belief import Belief
from viewgain.plan._confidence import decision_numbers, shipped_confidence
from viewgain.plan._expected import ExpectedErrorPolicy
from viewgain.plan._nearly_best import NEARLY
from viewgain.plan._opinions import Opinions
from viewgain.plan._volume_network import trust
from viewgain.scans import Scan


@dataclass(frozen=True, slots=True, eq=False)
class VolumeJudge:
    """Asks the expected error and the shipped network about all candidates of :func:`viewgain.plan.next_view`."""

    scan: Scan
    """The camera as it stands."""
    abstain_below: float = 0.0
    """A choice with less chance is not stood by; 0 for none."""
    pose_sigma: tuple[float, float] = POSE_SIGMA
    """Standard deviation of a camera pose, metres and radians per axis."""

    def __post_init__(self) -> None:
        if not 0 <= self.abstain_below <= 1:
            raise ConfigError(f"volume: got {self.abstain_below} to abstain below, wanted a probability of 0 to 1")

    def chance(self, belief: Belief, candidates: Poses, reachable: Mask, chosen: int) -> float:
        """Return the chance that no other candidate in reach is better by two points of expected volume error.

        Args:
            belief: What the scans so far say.
            candidates: (V, 4, 4) ``camera_to_current``.
            reachable: (V,) which of them can be reached.
            chosen: One of those.

        Raises:
            ModelError: If the shipped network or confidence cannot be read.
        """
        by_model = ExpectedErrorPolicy(pose_sigma=self.pose_sigma).assess(belief, candidates, NEARLY)
        by_network = volume_scorer().assessed(self.scan.points, candidates).scores
        model = np.array([1 - each.score for each in by_model])
        opinions = Opinions(model, -by_network, trust(belief, fused=True), np.asarray(reachable, dtype=bool))
        return shipped_confidence().chance(decision_numbers(opinions, chosen))

    def abstention(self, chance: float, chosen: int) -> str | None:
        """Return in words why a choice of this chance is not stood by; None where it is."""
        if chance >= self.abstain_below:
            return None
        return (
            f"view {chosen} would be chosen, and the chance that no other view is better by {100 * NEARLY:g} points of volume"
            f" error is {chance:.2f}, under the {self.abstain_below:.2f} asked for"
        )

"""Who decides for the volume where nobody is named: certainty where the box is measured, experience where it is not."""

from dataclasses import dataclass

from viewgain.arrays import Poses
from viewgain.inference import volume_scorer
from viewgain.measure import POSE_SIGMA
from viewgain.plan._belief import Belief
from viewgain.plan._expected import ExpectedErrorPolicy
from viewgain.plan._policy import Assessment, CovariancePolicy, Policy
from viewgain.plan._volume_network import VolumeNetworkAboutBox
from viewgain.scans import Scan


@dataclass(frozen=True, slots=True, eq=False)
class AutomaticPolicy:
    """The policy ``model`` where every dimension is bounded, else ``combined`` with the shipped network.

    Where the box is measured all good views err alike, and what is left to win is certainty. Where a dimension is open, or
    nothing could be measured, what matters is to have a volume at all (docs/results.md).
    """

    scan: Scan
    """The camera as it stands."""
    pose_sigma: tuple[float, float] = POSE_SIGMA
    """Standard deviation of a camera pose, metres and radians per axis."""
    name: str = "auto"

    def deciding(self, belief: Belief) -> Policy:
        """Return who decides; raises ModelError if the shipped network cannot be read."""
        if belief.bounded:
            return CovariancePolicy(self.pose_sigma)
        return VolumeNetworkAboutBox(volume_scorer(), self.scan, ExpectedErrorPolicy(pose_sigma=self.pose_sigma))

    def assess(self, belief: Belief, candidates: Poses, tolerance: float) -> tuple[Assessment, ...]:
        """Return the assessments of who decides."""
        return self.deciding(belief).assess(belief, candidates, tolerance)

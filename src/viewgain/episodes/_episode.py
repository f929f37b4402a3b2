"""The closed loop in simulation: scan, measure, choose the next view, move, measure again, until the volume is certain.

The camera arrives a little off from where it was sent and does not know it; fusing must live with that.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from viewgain.arrays import Pose
from viewgain.box import Box
from viewgain.camera import Sensor
from viewgain.errors import ScanError
from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.measure import POSE_SIGMA, Measurement, fuse_measurements, measure
from viewgain.plan import CovariancePolicy, NextView, OnScans, Policy, ViewPolicy, next_view
from viewgain.rigs import Rig
from viewgain.scans import Scan
from viewgain.scenes import Scene
from viewgain.simulate import ALL_EFFECTS, Effects, RangeError, capture

MODELLED = ALL_EFFECTS.without("multipath")
"""Everything but multipath, which the estimator has no model of; what that costs it: docs/simulating.md."""


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """A scene and the camera in it, with everything that is true but not known to the planner."""

    scene: Scene
    """Boxes on the floor; the first is the one to measure."""
    sensor: Sensor
    """The camera."""
    scale: float = 0.0
    """Its relative range error."""
    offset: float = 0.0
    """Its constant range error, metres."""
    effects: Effects = MODELLED
    """What the camera does to the truth."""
    pose_sigma: tuple[float, float] = POSE_SIGMA
    """How far it arrives from where it was sent, standard deviation per axis, metres and radians."""

    @property
    def box(self) -> Box:
        """The box to measure."""
        return self.scene.boxes[0]

    def scan(self, camera_to_world: Pose, believed: Pose, rng: np.random.Generator) -> Scan:
        """Return what the camera sees from ``camera_to_world``, labelled with the pose it believes to be at."""
        error = RangeError(self.scale, self.offset)
        return capture(self.scene, camera_to_world, self.sensor, rng=rng, error=error, effects=self.effects).posed(believed)

    def arrive(self, sent_to: Pose, rng: np.random.Generator) -> Pose:
        """Return where a camera sent to a pose really ends up."""
        metres, radians = self.pose_sigma
        return sent_to @ pose(rotation_from_rotvec(rng.normal(0, radians, 3)), rng.normal(0, metres, 3))


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One scan of an episode and what followed from it."""

    scan: Scan
    """The scan, with the pose the camera believes to be at."""
    single: Measurement
    """This scan measured alone."""
    fused: Measurement
    """All scans so far together, in this camera's frame."""
    plan: NextView
    """The ranking made after it."""


@dataclass(frozen=True, slots=True, eq=False)
class Episode:
    """A whole run."""

    world: World
    """The truth."""
    steps: tuple[Step, ...]
    """One per scan."""

    @property
    def errors(self) -> tuple[float, ...]:
        """Relative volume error |V / V* - 1| after each step; 1 where there is no volume."""
        return tuple(volume_error(step.fused, self.world.box) for step in self.steps)

    @property
    def stopped(self) -> bool:
        """Whether the stop rule ended it (rather than the limit of views)."""
        return self.steps[-1].plan.stop


def run_episode(
    world: World,
    first_view: Pose,
    *,
    rng: np.random.Generator,
    rig: str | Rig = "ring8",
    policy: ViewPolicy | Policy | Callable[[Scan], Policy] | None = None,
    tolerance: float = 0.05,
    confidence: float = 0.95,
    max_views: int = 5,
    stop_early: bool = True,
) -> Episode:
    """Run the loop from a first view until the stop rule fires or ``max_views`` scans are taken.

    Args:
        world: The truth.
        first_view: (4, 4) camera_to_world of the first scan.
        rng: Source of sensor noise and pose errors.
        rig: Where the camera may go, anchored at each present pose.
        policy: Who decides: any policy, one about a box, or what gives one for the last scan (such as ``AutomaticPolicy``);
            default model-based.
        tolerance: Relative volume error asked for.
        confidence: Probability asked for.
        max_views: Most scans to take, at least 1.
        stop_early: Whether the stop rule may end the episode.

    Returns:
        At least one step. It also ends where no candidate is reachable or a further scan shows nothing at all.

    Raises:
        ScanError: If the first scan shows nothing at all.
    """
    decider = policy or CovariancePolicy(world.pose_sigma)
    camera, believed = first_view, first_view
    steps: list[Step] = []
    while True:
        try:
            scan = replace(world.scan(camera, believed, rng), source=f"view {len(steps) + 1}")
        except ScanError:
            if not steps:
                raise
            return Episode(world, tuple(steps))
        single = measure(scan, camera=world.sensor)
        fused = fuse_measurements([*(step.single for step in steps), single], pose_sigma=world.pose_sigma)
        plan = next_view(
            fused,
            rig,
            policy=_about_a_box(decider, [*(step.scan for step in steps), scan], world.sensor),
            camera=world.sensor,
            tolerance=tolerance,
            confidence=confidence,
            pose_sigma=world.pose_sigma,
        )
        steps.append(Step(scan, single, fused, plan))
        if len(steps) >= max_views or plan.best is None or (plan.stop and stop_early):
            return Episode(world, tuple(steps))
        believed = believed @ plan.candidates[plan.best].camera_to_current
        camera = world.arrive(believed, rng)


def _about_a_box(policy: ViewPolicy | Policy | Callable[[Scan], Policy], scans: list[Scan], sensor: Sensor) -> Policy:
    """Return a policy as :func:`viewgain.plan.next_view` asks it."""
    if isinstance(policy, type) or not isinstance(policy, Policy | ViewPolicy):
        return policy(scans[-1])
    return policy if isinstance(policy, Policy) else OnScans(policy, tuple(scans), sensor.intrinsics)


def volume_error(measured: Measurement, box: Box) -> float:
    """Return |V / V* - 1| of the box that is largest in the image; 1 (all of it) if there is none."""
    return abs(measured.boxes[0].volume / box.volume - 1) if measured.boxes else 1.0

"""A trained network as a policy: the object is cut from the floor and brought into the network's frame, then come the scores."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Points, Pose, Poses, Vector3
from viewgain.errors import ConfigError, ScanError
from viewgain.geometry import inverse, pose, rotation_from_rotvec, transform
from viewgain.inference import Bounds, CloudScorer, FrameName
from viewgain.measure import find_floors, range_image, sensor_of
from viewgain.plan._belief import Belief, floor_pose
from viewgain.plan._doubt import chances_of_best
from viewgain.plan._policy import Assessment
from viewgain.rigs import Rig, rig
from viewgain.scans import Scan

NEAR = float(np.deg2rad(20.0))
"""A station further than this from the present direction is not where the camera stands: half the least gap of published rigs."""


@dataclass(frozen=True, slots=True, eq=False)
class NetworkPolicy:
    """Ranks the candidates of a network's own rig from one scan, by the coverage that each would add.

    A network of the object frame needs a scan with a pose. Its axes are then those that the stations are counted in: z up, x the
    direction of azimuth 0, so that every station is where the network knows it; how the object itself is turned about the
    vertical stays unknown. The whole object's box is the believed one, from the floor up.

    Source: Pop and Tamas 2022, section 3: without the view state scores come with the present view first, so the present view is
    the station nearest to the camera's direction.
    """

    scorer: CloudScorer
    """The network, or several."""
    scan: Scan
    """The camera as it stands."""
    rig: str
    """Name of the rig that the candidates are of."""
    name: str = "network"
    abstain_below: float = 0.0
    """Abstain where the probability that the chosen view is the best of those in reach is under this (:meth:`abstention`)."""

    def __post_init__(self) -> None:
        if not 0 <= self.abstain_below <= 1:
            raise ConfigError(f"network: got {self.abstain_below} to abstain below, wanted a probability")
        if self.abstain_below and not self.scorer.card.uncertainty:
            raise ConfigError(
                f"network {self.scorer.card.name}: gives no standard deviations, so nobody knows when to abstain; wanted one"
                " with uncertainty, or several networks"
            )

    def assess(self, belief: Belief, candidates: Poses, tolerance: float) -> tuple[Assessment, ...]:
        """Return one assessment per candidate; the score is the predicted gain of coverage.

        Raises:
            ConfigError: If the network is of another rig or frame, or the camera stands near none of the stations.
            ScanError: If nothing stands on the floor.
        """
        del tolerance
        given: FrameName = "camera" if self.scan.camera_to_world is None else "object"
        frame: FrameName = "camera" if self.scorer.card.frame == "camera" else given
        reason = self.scorer.refusal(frame=frame, rig=self.rig)
        if reason:
            raise ConfigError(reason)
        points = object_points(self.scan, belief.mean.centre)
        to_frame = np.eye(4) if frame == "camera" else station_axes(belief, candidates, rig(self.rig))
        bounds = Bounds(transform(to_frame, belief.mean.centre), float(np.linalg.norm(belief.mean.extents)))
        present = standing_at(candidates, belief.mean.centre)
        told = self.scorer.card.with_view_state
        state = np.arange(len(candidates)) == present if told else None
        said = self.scorer.assessed(transform(to_frame, points), state, bounds=bounds, frame=frame)
        shift = 0 if told else present
        scores = np.roll(said.scores, shift).tolist()
        sigmas = [None] * len(scores) if said.sigma is None else np.roll(said.sigma, shift).tolist()
        return tuple(Assessment(score, None, None, sigma) for score, sigma in zip(scores, sigmas, strict=True))

    def abstention(self, assessments: tuple[Assessment, ...], reachable: NDArray[np.bool_], best: int) -> str | None:
        """Return why the network stands by no choice, or None: the probability that the view is the best is too low.

        Scores count as independent and normal (:func:`viewgain.plan.chances_of_best`). A network without standard deviations
        never abstains.

        Args:
            assessments: (V,) its own, of all candidates.
            reachable: (V,) which of them can be reached.
            best: The one with the highest score of those.
        """
        scores = np.array([each.score for each in assessments])
        sigmas = np.array([np.nan if each.sigma is None else each.sigma for each in assessments])
        if not self.abstain_below or np.any(np.isnan(sigmas)):
            return None
        places = np.flatnonzero(reachable)
        chances = dict(zip(places.tolist(), chances_of_best(scores[places], sigmas[places]).tolist(), strict=True))
        if chances[best] >= self.abstain_below:
            return None
        return (
            f"the network prefers view {best}, and the probability that it is the best of {len(places)} in reach is"
            f" {chances[best]:.2f}, under the {self.abstain_below:.2f} asked for"
        )


def object_points(scan: Scan, near: Vector3) -> Points:
    """Return (n, 3) the returns of the object on the floor that is nearest to a point, both in the camera's frame.

    Raises:
        ScanError: If there is no floor, or nothing on it.
    """
    from viewgain.parcels import find_objects  # plain measuring loads the planner's words, and need not load this

    sensor, image = sensor_of(None), range_image(scan)
    for floor in find_floors(image, sensor):
        objects = find_objects(image, floor, sensor)
        if objects:
            clouds = [transform(each.floor_frame, each.points) for each in objects]
            return min(clouds, key=lambda cloud: float(np.linalg.norm(cloud.mean(axis=0) - near)))
    raise ScanError(f"{scan.source}: got no object on a floor, wanted one for the network")


def station_axes(belief: Belief, candidates: Poses, stations: Rig) -> Pose:
    """Return (4, 4) the motion from the present camera to the axes that the stations' azimuths count in: z up, x azimuth 0."""
    to_floor = inverse(floor_pose(belief))
    offsets = transform(to_floor, candidates[:, :3, 3]) - transform(to_floor, belief.mean.centre)
    surest = int(np.argmax(np.hypot(offsets[:, 0], offsets[:, 1])))
    turn = stations.stations[surest].azimuth - float(np.arctan2(offsets[surest, 1], offsets[surest, 0]))
    return np.asarray(pose(rotation_from_rotvec(np.array([0.0, 0.0, turn])), np.zeros(3)) @ to_floor)


def standing_at(candidates: Poses, centre: Vector3) -> int:
    """Return the station in whose direction from the target the present camera stands.

    Args:
        candidates: (V, 4, 4) poses ``camera_to_current``.
        centre: (3,) what they look at, present camera's frame.

    Raises:
        ConfigError: If every station is more than 20 degrees away.
    """
    offsets = candidates[:, :3, 3] - centre
    cosines = offsets @ -centre / np.maximum(np.linalg.norm(offsets, axis=1) * np.linalg.norm(centre), 1e-12)
    best = int(np.argmax(cosines))
    apart = float(np.arccos(np.clip(cosines[best], -1.0, 1.0)))
    if apart > NEAR:
        raise ConfigError(
            f"network: the camera stands {np.rad2deg(apart):.0f} degrees from the nearest station of the rig, wanted under"
            f" {np.rad2deg(NEAR):.0f}; move it there first"
        )
    return best

"""Coverage episodes: an object, a rig of views around it, and a policy that collects as much of its surface as it can.

What every view would see is worked out before, so an episode is a matter of the policy's time. Poses are exact.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Indices, Points, Pose, Poses, Vector
from viewgain.camera import Intrinsics
from viewgain.errors import ConfigError
from viewgain.gain import Cover, CoverageProtocol, NewPoints, cover, coverage_auc, model_clouds, normalised, size, surface_samples
from viewgain.geometry import inverse, transform
from viewgain.meshes import TriangleMesh
from viewgain.plan import Seen, ViewPolicy, choose, unique
from viewgain.rigs import Target, rig
from viewgain.rigs import poses as rig_poses
from viewgain.scans import MIN_POINTS, Scan


@dataclass(frozen=True, slots=True, eq=False)
class CoverageWorld:
    """An object as every view of a rig sees it, and which of its surface each view covers."""

    scans: tuple[Scan | None, ...]
    """Per view what it sees, with its pose; None where that is too little for a scan (under 100 points)."""
    poses: Poses
    """(V, 4, 4) ``camera_to_world`` of the views."""
    camera: Intrinsics
    """The camera's image."""
    covered: Cover
    """The truth: what each view covers of the surface."""

    @classmethod
    def from_clouds(
        cls, clouds: Sequence[Points], surface: Points, *, reach: float, poses: Poses, camera: Intrinsics
    ) -> "CoverageWorld":
        """Return the world of given clouds.

        Args:
            clouds: One (n, 3) cloud per view, world frame; n may be 0. Clouds with one point per pixel at most become images.
            surface: (m, 3) samples of the object's surface, world frame.
            reach: A point covers the samples nearer than this, metres.
            poses: (V, 4, 4) ``camera_to_world`` of the views.
            camera: The camera's image.

        Raises:
            ConfigError: If there is not one pose per cloud, or the reach is not positive.
            ScanError: If there is no cloud or no surface, or their points are not finite (n, 3).
        """
        if len(clouds) != len(poses):
            raise ConfigError(f"coverage world: got {len(clouds)} clouds and {len(poses)} poses, wanted one pose per cloud")
        covered = cover(clouds, surface, reach)
        scans = tuple(
            _scan(cloud, pose, camera, f"view {view}") for view, (cloud, pose) in enumerate(zip(clouds, poses, strict=True))
        )
        return cls(scans, np.asarray(poses, dtype=float), camera, covered)

    @classmethod
    def from_mesh(cls, mesh: TriangleMesh, protocol: CoverageProtocol, *, rng: np.random.Generator) -> "CoverageWorld":
        """Return the world of a mesh under a protocol, in the frame of the normalised mesh; ``rng`` draws the surface samples."""
        surface = surface_samples(normalised(mesh, protocol), protocol.surface_points, rng=rng)
        poses = rig_poses(rig(protocol.rig), Target.at(np.zeros(3)), distance=protocol.distance)
        return cls.from_clouds(model_clouds(mesh, protocol), surface, reach=protocol.reach, poses=poses, camera=protocol.camera)

    def seen(self, order: Sequence[int]) -> Seen:
        """Return what a policy knows after the views in ``order``, at least one."""
        scans = tuple(scan for scan in (self.scans[view] for view in order) if scan is not None)
        return Seen(scans, self.poses[list(order)], self.poses, unique(order), self.camera)


@dataclass(frozen=True, slots=True, eq=False)
class CoverageEpisode:
    """The views that a policy took, and what they covered."""

    policy: str
    """Its name."""
    order: Indices
    """(n,) the views, the first one included."""
    covered: Cover
    """The truth they are judged by."""

    @property
    def union(self) -> Vector:
        """(n,) share of the surface covered with 1, 2, ... n views, each sample counted once."""
        known = np.bitwise_or.accumulate(self.covered.masks[self.order], axis=0)
        return np.asarray(size(known) / self.covered.surface_count)

    @property
    def published(self) -> Vector:
        """(n,) coverage by PC-NBV's published rule, which counts some samples twice (:class:`viewgain.gain.CoverageGain`)."""
        fresh, gained = NewPoints(self.covered), []
        for view in self.order:
            gained.append(fresh.gains[view])
            fresh.accumulate(int(view))
        return np.cumsum(gained) / self.covered.surface_count

    @property
    def auc(self) -> float:
        """Area under :attr:`union` per view (:func:`viewgain.gain.coverage_auc`)."""
        return coverage_auc(self.union)


def run_coverage_episode(world: CoverageWorld, policy: ViewPolicy, *, first: int, views: int) -> CoverageEpisode:
    """Take ``views`` views, the first given and each further one the policy's best among those not yet taken.

    Args:
        world: The object; the policy sees its scans, never its surface.
        policy: Who decides.
        first: The view that is there from the start.
        views: How many views in all, the first included; PC-NBV's figures are of 10.

    Returns:
        The episode; shorter where every view has been taken.

    Raises:
        ConfigError: If there is no such first view, or no view to take.
    """
    if not 0 <= first < len(world.poses) or views < 1:
        raise ConfigError(
            f"coverage episode: got first view {first} of {len(world.poses)} and {views} views, wanted one of them and at least 1"
        )
    order = [first]
    while len(order) < views:
        seen = world.seen(order)
        following = choose(policy.scores(seen), seen.unvisited)
        if following is None:
            break
        order.append(following)
    return CoverageEpisode(policy.name, np.array(order, dtype=np.intp), world.covered)


def _scan(cloud: Points, camera_to_world: Pose, camera: Intrinsics, source: str) -> Scan | None:
    """Return a cloud as a scan, an image where every point has a pixel of its own; None if it has too few points."""
    if len(cloud) < MIN_POINTS:
        return None
    points = transform(inverse(camera_to_world), np.asarray(cloud, dtype=float))
    if np.all(points[:, 2] > 0):
        u, v = np.rint(camera.project(points)).astype(np.int64).T
        pixels = v * camera.width + u
        inside = (u >= 0) & (v >= 0) & (u < camera.width) & (v < camera.height)
        if np.all(inside) and len(np.unique(pixels)) == len(pixels):
            shape = (camera.height, camera.width)
            return Scan(
                points=points, pixels=pixels, shape=shape, intrinsics=camera, camera_to_world=camera_to_world, source=source
            )
    return Scan(points=points, camera_to_world=camera_to_world, source=source)

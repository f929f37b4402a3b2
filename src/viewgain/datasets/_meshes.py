"""Meshes on a floor, scanned by a real camera from an irregular rig; the label is the exact coverage that each station adds."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from viewgain.arrays import Array, Points, Poses
from viewgain.camera import Intrinsics
from viewgain.datasets._coverage import PUBLISHED, UNION, masks_of
from viewgain.datasets._mesh_units import mesh_of, mesh_units
from viewgain.datasets._points import kept
from viewgain.datasets._sample import UNKNOWN_DIMS, Sample
from viewgain.datasets._seeds import SCAN, SPLIT, SURFACE, generator
from viewgain.datasets._settings import MeshSettings, Recipe
from viewgain.datasets._station import Setup, noisy_camera, only_first, seen_from
from viewgain.datasets._unit import Made, Skipped, Unit
from viewgain.errors import ConfigError, ScanError
from viewgain.gain import Cover, CoverageLabels, cover, greedy_labels, surface_samples
from viewgain.geometry import inverse, pose, rotation_from_rotvec, transform
from viewgain.rays import SceneCaster, as_rows, pixel_rays
from viewgain.rigs import Target, irregular_rig
from viewgain.scans import MIN_POINTS, Scan
from viewgain.scenes import Scene
from viewgain.simulate import Effects, capture

WIDTH, HEIGHT = 640, 480
"""Image on which coverage is counted, over the camera's own field of view: finer than the camera's, so that no gaps are left."""


class MeshMaker:
    """Scans meshes that stand on a floor."""

    def __init__(self, recipe: Recipe, content: MeshSettings, folder: Path | None) -> None:
        """Read nothing yet.

        Args:
            recipe: The recipe.
            content: Its table.
            folder: Meshes; None for procedural ones. They stand upright if their files have z up.
        """
        self._recipe, self._content, self._folder = recipe, content, folder

    def units(self) -> Iterator[Unit]:
        """Yield one unit per mesh."""
        return mesh_units(self._recipe.seed, self._folder, self._content)

    def make(self, unit: Unit) -> Made:
        """Return one sample per station; raises MeshError for a bad mesh, which is then skipped whole."""
        rules, rng = self._content, generator(self._recipe.seed, (unit.object, SPLIT, 0, 0))
        size = float(rng.uniform(*rules.diagonal))
        turn = pose(rotation_from_rotvec(np.array([0.0, 0.0, rng.uniform(0, 2 * np.pi)])), np.zeros(3))
        mesh = mesh_of(unit, self._recipe.seed).normalised(size).moved(turn).standing()
        camera, noise = noisy_camera(rules.cameras, rules.noise, rng=rng)
        setup = Setup(
            caster=SceneCaster(Scene(meshes=(mesh,))),
            target=Target.at(mesh.bounds.mean(axis=0), mesh.extents),
            rig=irregular_rig(int(rng.integers(rules.views[0], rules.views[1], endpoint=True)), rng=rng),
            camera=camera,
            noise=noise,
            effects=Effects().without(*rules.without),
        )
        alone = SceneCaster(Scene(meshes=(mesh,), planes=()))
        clouds = [_exact(alone, _fine(camera.intrinsics), station) for station in setup.stations()]
        surface = surface_samples(mesh, rules.surface_points, rng=generator(self._recipe.seed, (unit.object, SURFACE, 0, 0)))
        covered = cover(clouds, surface, rules.reach * size)
        results = [self._sample(unit, setup, covered, view) for view in range(len(clouds))]
        return Made(
            samples=tuple(result for result in results if isinstance(result, Sample)),
            skipped=tuple(result for result in results if isinstance(result, Skipped)),
            masks=masks_of(unit, covered) if rules.masks else {},
        )

    def scans(self, unit: Unit) -> Iterator[tuple[Sample | Skipped, Scan | None]]:
        """Refuse: these are no scans of boxes."""
        raise ConfigError(f"recipe {self._recipe.name}: volume errors are of boxes, and this recipe has none")

    def _sample(self, unit: Unit, setup: Setup, covered: Cover, view: int) -> Sample | Skipped:
        """Return the noisy scan from one station, with what every station would add to what this one covers exactly."""
        key = (unit.object, SCAN, view, 0)
        rng = generator(self._recipe.seed, key)
        stations, present = setup.stations(), setup.stations(rng)[view]
        (reason,) = setup.reasons(present[None])
        try:
            scan = None if reason else capture(setup.caster, present, setup.camera, rng=rng, effects=setup.effects)
        except ScanError:
            reason = f"fewer than {MIN_POINTS} returns"
        if reason is not None or scan is None:
            return Skipped(unit=unit.number, name=f"{unit.name}/view{view:02d}", reason=reason or "no scan")
        labels = greedy_labels(covered, first=view, steps=1)
        sample = Sample(
            points=kept(scan.points, self._recipe.points, rng=rng),
            frame="camera",
            view=view,
            state=only_first(len(stations)),
            candidates=seen_from(view, present, stations),
            reachable=np.roll([each is None for each in setup.reasons(stations)], -view),
            camera=setup.camera.name,
            noise=setup.noise,
            object=unit.object,
            category=unit.category,
            dims=UNKNOWN_DIMS,
            object_to_camera=inverse(present) @ setup.target.target_to_world,
            coverage=float(labels.coverage_union[0]),
            step=0,
            capture=0,
            seed=key,
            splits=unit.splits,
            targets=_targets(labels, view),
        )
        return sample if self._recipe.points.frame == "camera" else sample.in_frame("object")


def _targets(labels: CoverageLabels, view: int) -> dict[str, Array]:
    return {PUBLISHED: np.roll(labels.gains_published[0], -view), UNION: np.roll(labels.gains_union[0], -view)}


def _fine(camera: Intrinsics) -> Intrinsics:
    """Return a pinhole of the same field of view with more pixels."""
    horizontal, vertical = 2 * np.arctan(camera.width / 2 / camera.fx), 2 * np.arctan(camera.height / 2 / camera.fy)
    return Intrinsics.from_field_of_view(WIDTH, HEIGHT, float(horizontal), float(vertical))


def _exact(caster: SceneCaster, camera: Intrinsics, station: Poses) -> Points:
    """Return the (n, 3) points that a perfect camera sees, world frame."""
    ranges = caster.pixels(camera, station).ranges
    met = np.isfinite(ranges)
    return transform(station, as_rows(pixel_rays(camera))[met] * ranges[met, None])

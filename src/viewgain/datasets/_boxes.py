"""Boxes on a floor: each is scanned many times from each station, so that the spread of a station's volume errors can be seen."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from viewgain.arrays import Array, Points, Pose
from viewgain.camera import Sensor
from viewgain.datasets._expected import ALONE, FUSED, volume_alone, volume_fused
from viewgain.datasets._points import kept
from viewgain.datasets._sample import Sample
from viewgain.datasets._seeds import SCAN, SCENE, generator
from viewgain.datasets._settings import BoxSettings, Recipe
from viewgain.datasets._station import Setup, noisy_camera, only_first, seen_from
from viewgain.datasets._unit import Made, Skipped, Unit
from viewgain.errors import ScanError
from viewgain.geometry import inverse, transform
from viewgain.rays import SceneCaster
from viewgain.rigs import Rig, Target, irregular_rig, rig
from viewgain.scans import MIN_POINTS, Scan
from viewgain.scenes import Scene, SceneRanges, Surroundings, random_scene, standing_box
from viewgain.simulate import NO_ERROR, Effects, RangeError, capture, draw_range_error

SPLITS = ("same_box", "other_box")
"""``same_box`` is the published one: scans of one box lie on both sides. ``other_box`` keeps whole boxes apart."""


class BoxMaker:
    """Scans boxes."""

    def __init__(self, recipe: Recipe, content: BoxSettings) -> None:
        """Check the names; a scene is made with its first scan.

        Raises:
            ConfigError: If a camera, rig or effect is not known.
        """
        Effects().without(*content.without)
        self._recipe, self._content = recipe, content
        self._setup = lru_cache(maxsize=2)(self._made_setup)
        self._alone = lru_cache(maxsize=2)(self._made_alone)

    def units(self) -> Iterator[Unit]:
        """Yield units of up to ``captures_per_unit`` scans of one station of one box."""
        number, rules = 0, self._content
        for box in range(rules.number):
            part = "test" if box >= rules.number - rules.test_boxes else "train"
            for view in range(len(self._viewer(box).rig.stations)):
                for first in range(0, rules.captures, rules.captures_per_unit):
                    captures = range(first, min(first + rules.captures_per_unit, rules.captures))
                    name = f"box{box:05d}/view{view:02d}/{first:04d}"
                    yield Unit(number=number, object=box, name=name, category="box", splits={"other_box": part},
                               source=(view, captures))  # fmt: skip
                    number += 1

    def make(self, unit: Unit) -> Made:
        """Return one sample per scan; a camera that cannot stand where jitter put it, or sees nothing, is skipped."""
        results = [result for result, _ in self.scans(unit)]
        skipped = tuple(result for result in results if isinstance(result, Skipped))
        return Made(samples=tuple(result for result in results if isinstance(result, Sample)), skipped=skipped)

    def scans(self, unit: Unit) -> Iterator[tuple[Sample | Skipped, Scan | None]]:
        """Yield each sample with its whole scan."""
        view, captures = unit.source
        setup = self._setup(unit.object)
        stations = setup.stations()
        reachable = np.array([reason is None for reason in setup.reasons(stations)])
        for number in captures:
            rng = generator(self._recipe.seed, (unit.object, SCAN, view, number))
            present = setup.stations(rng)[view]
            scan = _scan(setup, present, rng)
            if isinstance(scan, str):
                yield Skipped(unit=unit.number, name=f"{unit.name.rpartition('/')[0]}/{number:04d}", reason=scan), None
                continue
            points = kept(scan.points, self._recipe.points, rng=rng)
            sample = self._sample(unit, setup, points, present, number)
            candidates = seen_from(view, present, stations)
            targets = self._targets(unit.object, view, present) if self._content.expected else {}
            yield replace(sample, candidates=candidates, reachable=np.roll(reachable, -view), targets=targets), scan

    def _targets(self, box: int, view: int, present: Pose) -> dict[str, Array]:
        """Return what each station is expected to be worth, the present view first."""
        setup = self._setup(box)
        after = volume_fused(setup.caster.scene.boxes[0], present, setup.stations(), setup.camera)
        return {ALONE: np.roll(self._alone(box), -view), FUSED: np.roll(after, -view)}

    def _made_alone(self, box: int) -> Array:
        setup = self._setup(box)
        return volume_alone(setup.caster.scene.boxes[0], setup.stations(), setup.camera)

    def _sample(self, unit: Unit, setup: Setup, points: Points, present: Pose, number: int) -> Sample:
        """Return what a scan from a pose is a sample of; the candidates are still to be filled in."""
        view, count = unit.source[0], len(setup.rig.stations)
        box = setup.caster.scene.boxes[0].in_frame(inverse(present))
        in_object = self._recipe.points.frame == "object"
        return Sample(
            points=transform(inverse(box.box_to_camera), points) if in_object else points,
            frame=self._recipe.points.frame,
            view=view,
            state=only_first(count),
            candidates=np.zeros((count, 4, 4)),
            reachable=np.zeros(count, dtype=bool),
            camera=setup.camera.name,
            noise=setup.noise,
            object=unit.object,
            category=unit.category,
            dims=box.extents,
            object_to_camera=box.box_to_camera,
            coverage=np.nan,
            step=0,
            capture=number,
            seed=(unit.object, SCAN, view, number),
            splits={"same_box": "train" if number < self._content.train_captures else "test", **unit.splits},
        )

    def _viewer(self, box: int) -> "_Viewer":
        """Return what looks at a box, and the generator that goes on to draw its scene."""
        rules, rng = self._content, generator(self._recipe.seed, (box, SCENE, 0, 0))
        camera, noise = noisy_camera(rules.cameras, rules.noise, rng=rng)
        error = draw_range_error(camera, rng=rng) if rules.systematic else NO_ERROR
        count = int(rng.integers(rules.views[0], rules.views[1], endpoint=True))
        stations = irregular_rig(count, rng=rng) if rules.rig == "irregular" else rig(rules.rig)
        return _Viewer(camera, noise, error, stations, rng)

    def _made_setup(self, box: int) -> Setup:
        """Return the scene of a box and what looks at it; it depends only on the box's number."""
        viewer = self._viewer(box)
        scene = self._scene(box, viewer.rng)
        first = scene.boxes[0]
        return Setup(
            caster=SceneCaster(scene), target=Target(first.box_to_camera, first.extents), rig=viewer.rig, camera=viewer.camera,
            noise=viewer.noise, effects=Effects().without(*self._content.without), error=viewer.error,
        )  # fmt: skip

    def _scene(self, box: int, rng: np.random.Generator) -> Scene:
        rules = self._content
        around = Surroundings(boxes=rules.boxes, clutter=rules.clutter, walls=rules.walls, reflectivity=rules.reflectivity)
        scene = random_scene(rng, SceneRanges(extent=rules.side, yaw_deg=rules.yaw_deg), around)
        if not rules.sizes:
            return scene
        first = standing_box(np.array(rules.sizes[box]), yaw=float(np.deg2rad(rng.uniform(*rules.yaw_deg))))
        return Scene((first, *scene.boxes[1:]), scene.meshes, scene.planes, scene.reflectivity)


@dataclass(frozen=True, slots=True)
class _Viewer:
    """What looks at a box."""

    camera: Sensor
    noise: float
    error: RangeError
    rig: Rig
    rng: np.random.Generator


def _scan(setup: Setup, present: Pose, rng: np.random.Generator) -> Scan | str:
    """Return a scan, or why there is none."""
    (reason,) = setup.reasons(present[None])
    if reason is not None:
        return reason
    try:
        return capture(setup.caster, present, setup.camera, rng=rng, effects=setup.effects, error=setup.error)
    except ScanError:
        return f"fewer than {MIN_POINTS} returns"

"""Meshes seen by a published rig with exact depth: partial clouds, and the coverage that each further view adds.

One ray casting and one search for near points per mesh serve every start and every step.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Mask, Points, Poses
from viewgain.datasets._mesh_units import mesh_of, mesh_units
from viewgain.datasets._points import kept
from viewgain.datasets._sample import UNKNOWN_DIMS, Sample
from viewgain.datasets._seeds import START, SURFACE, WANDER, generator
from viewgain.datasets._settings import CoverageSettings, Recipe
from viewgain.datasets._station import seen_from
from viewgain.datasets._unit import Made, Masks, Skipped, Unit
from viewgain.errors import ConfigError
from viewgain.gain import (
    COVERAGE_PROTOCOLS,
    Cover,
    CoverageLabels,
    cover,
    greedy_labels,
    labels_from,
    model_clouds,
    surface_samples,
)
from viewgain.geometry import inverse
from viewgain.rigs import Target, poses, rig
from viewgain.scans import Scan

PUBLISHED, UNION = "gain_published", "gain_union"
"""Names of the two targets: by the published rule, which may count surface twice, and by plain union."""
EXACT = "exact"
"""The camera of clouds without noise."""
NOTHING_SEEN = "the first view sees nothing of it"
"""Why there is no sample from a start."""


class CoverageMaker:
    """Looks at meshes from all sides."""

    camera = EXACT

    def __init__(self, recipe: Recipe, content: CoverageSettings, folder: Path | None) -> None:
        """Place the rig.

        Args:
            recipe: The recipe.
            content: Its table.
            folder: Meshes; None for procedural ones.

        Raises:
            ConfigError: If there is no such protocol, or more starts or steps than it has.
        """
        if content.protocol not in COVERAGE_PROTOCOLS:
            raise ConfigError(f"coverage: got protocol {content.protocol!r}, wanted one of {', '.join(COVERAGE_PROTOCOLS)}")
        self._recipe, self._content, self._folder = recipe, content, folder
        self._protocol = COVERAGE_PROTOCOLS[content.protocol]
        self._views: Poses = poses(rig(self._protocol.rig), Target.at(np.zeros(3)), distance=self._protocol.distance)
        if not 0 <= content.starts <= len(self._views):
            raise ConfigError(f"coverage: got {content.starts} starts, wanted 0 to {len(self._views)}")
        self._steps = content.steps or self._protocol.steps
        if self._steps > self._protocol.steps:
            raise ConfigError(
                f"coverage: got {content.steps} steps, wanted 0 to {self._protocol.steps}, as {content.protocol} has"
            )

    def units(self) -> Iterator[Unit]:
        """Yield one unit per mesh."""
        return mesh_units(self._recipe.seed, self._folder, self._content)

    def make(self, unit: Unit) -> Made:
        """Return one sample per start and step; raises MeshError for a bad mesh, which is then skipped whole."""
        seed = self._recipe.seed
        mesh = mesh_of(unit, seed)
        clouds = model_clouds(mesh, self._protocol)
        still = mesh.normalised(self._protocol.diagonal)
        surface = surface_samples(still, self._protocol.surface_points, rng=generator(seed, (unit.object, SURFACE, 0, 0)))
        covered = cover(clouds, surface, self._protocol.reach)
        samples: list[Sample] = []
        skipped: list[Skipped] = []
        starts = self._starts(unit)
        for first, labels in zip(starts, self._labels(unit, covered, starts), strict=True):
            if len(clouds[first]):
                samples += self._episode(unit, clouds, labels)
            else:
                skipped.append(Skipped(unit=unit.number, name=f"{unit.name}/start{first:02d}", reason=NOTHING_SEEN))
        return Made(samples=tuple(samples), skipped=tuple(skipped), masks=masks_of(unit, covered) if self._content.masks else {})

    def scans(self, unit: Unit) -> Iterator[tuple[Sample | Skipped, Scan | None]]:
        """Refuse: these are no scans of boxes."""
        raise ConfigError(f"recipe {self._recipe.name}: volume errors are of boxes, and this recipe has none")

    def _starts(self, unit: Unit) -> list[int]:
        if self._content.starts == 0:
            return list(range(len(self._views)))
        rng = generator(self._recipe.seed, (unit.object, START, 0, 0))
        return [int(view) for view in rng.permutation(len(self._views))[: self._content.starts]]

    def _labels(self, unit: Unit, covered: Cover, starts: list[int]) -> Iterable[CoverageLabels]:
        """Return the sequence of views from each start, and what each view would add at its steps."""
        wander, steps = self._content.wander, self._steps
        if not wander:
            return labels_from(covered, starts, steps=steps)
        streams = [generator(self._recipe.seed, (unit.object, WANDER, first, 0)) for first in starts]
        return [
            greedy_labels(covered, first=first, steps=steps, wander=wander, rng=rng)
            for first, rng in zip(starts, streams, strict=True)
        ]

    def _episode(self, unit: Unit, clouds: list[Points], labels: CoverageLabels) -> Iterator[Sample]:
        """Yield what is known and what each view would add, before each step of the sequence from one start."""
        first = labels.first
        state = np.zeros(len(self._views), dtype=bool)
        visited = [first, *labels.order.tolist()]
        seen: list[Points] = []
        for step, view in enumerate(visited[: self._steps]):
            if not state[view]:
                seen.append(clouds[view])
            state[view] = True
            key = (unit.object, START, first, step + 1)
            points = kept(np.concatenate(seen), self._recipe.points, rng=generator(self._recipe.seed, key))
            yield self._sample(unit, labels, step, view, points, state)

    def _sample(self, unit: Unit, labels: CoverageLabels, step: int, view: int, points: Points, state: Mask) -> Sample:
        """Return the sample of one step: its points are in the object's frame until they are placed in the recipe's."""
        gains = {PUBLISHED: labels.gains_published[step], UNION: labels.gains_union[step]}
        return self._placed(
            Sample(
                points=points,
                frame="object",
                view=view,
                state=np.roll(state, -view),
                candidates=seen_from(view, self._views[view], self._views),
                reachable=np.ones(len(self._views), dtype=bool),
                camera=EXACT,
                noise=0.0,
                object=unit.object,
                category=unit.category,
                dims=UNKNOWN_DIMS,
                object_to_camera=inverse(self._views[view]),
                coverage=float(labels.coverage_union[step]),
                step=step,
                capture=labels.first,
                seed=(unit.object, START, labels.first, step + 1),
                splits=unit.splits,
                targets={name: np.roll(each, -view) for name, each in gains.items()},
            )
        )

    def _placed(self, sample: Sample) -> Sample:
        """Return the sample in the recipe's frame."""
        return sample.in_frame(self._recipe.points.frame)


def masks_of(unit: Unit, covered: Cover) -> Masks:
    """Return the bit-packed masks of a unit's views as bytes."""
    packed: NDArray[np.uint8] = np.ascontiguousarray(covered.masks).view(np.uint8)
    return {unit.object: packed}

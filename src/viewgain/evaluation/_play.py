"""Coverage episodes of several policies on one object: a task that any process can work on."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from viewgain.arrays import Array
from viewgain.datasets import Skipped, Unit, mesh_of
from viewgain.episodes import CoverageEpisode, CoverageOracle, CoverageWorld, NetworkExplorer, run_coverage_episode
from viewgain.errors import ConfigError, ViewgainError, one_line
from viewgain.gain import COVERAGE_PROTOCOLS, VOLUMETRIC
from viewgain.inference import Scorer
from viewgain.plan import FarthestPolicy, Mapper, RandomPolicy, UniformPolicy, ViewPolicy, VolumetricPolicy
from viewgain.voxels import CERTAIN, Lattice

ALWAYS = RANDOM_POLICY, FARTHEST, GREEDY = "random", "farthest", "oracle"
"""Policies that every table has: the floor, the rule without learning to beat, and the ceiling."""
POLICIES = (*ALWAYS, "uniform", *VOLUMETRIC)
"""Names of the policies that are no networks."""
RULES = ("union", "published")
"""How coverage is counted."""
_EPISODES = 5
"""Random episodes per object, averaged: one would add its own luck to every comparison."""
_CELLS = 40
"""Voxels along each side of the unit cube around the object, for volumetric policies."""
_PLAY = 0x706C


@dataclass(frozen=True, slots=True, kw_only=True)
class PlayTask:
    """One object, and who plays on it."""

    unit: Unit
    """The mesh."""
    mesh_seed: int
    """Of the plan that the unit is of."""
    protocol: str
    """Key of ``viewgain.gain.COVERAGE_PROTOCOLS``."""
    policies: tuple[str, ...]
    """Of :data:`POLICIES`."""
    networks: tuple[tuple[str, Path], ...]
    """Names and files."""
    steps: int
    """Views in all, the random first one included."""
    seed: int
    """Of the surface samples, the first view and random choices."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Played:
    """What policies covered of an object."""

    number: int
    """The unit's."""
    category: str
    coverage: Mapping[str, Array]
    """By policy, (2, steps) coverage with 1, 2, ... views, by each of :data:`RULES`."""


def play(task: PlayTask) -> Played | Skipped:
    """Return what each policy covers from the same random first view; a mesh that cannot be read is a reason."""
    unit, protocol = task.unit, COVERAGE_PROTOCOLS[task.protocol]
    rng = np.random.default_rng([task.seed, _PLAY, unit.object])
    try:
        world = CoverageWorld.from_mesh(mesh_of(unit, task.mesh_seed), protocol, rng=rng)
    except ViewgainError as error:
        return Skipped(unit=unit.number, name=unit.name, reason=one_line(error))
    first = int(rng.integers(len(world.poses)))
    streams = rng.spawn(_EPISODES)
    coverage = {}
    for name in task.policies:
        players = [RandomPolicy(each) for each in streams] if name == RANDOM_POLICY else [_policy(name, world)]
        coverage[name] = _mean(world, players, first, task.steps)
    for name, path in task.networks:
        coverage[name] = _mean(world, [NetworkExplorer(_opened(path), name, task.seed)], first, task.steps)
    return Played(number=unit.number, category=unit.category, coverage=coverage)


def check_policies(names: Sequence[str]) -> tuple[str, ...]:
    """Return the policies to play, each once, those that are always there first.

    Raises:
        ConfigError: If one is not known.
    """
    unknown = [name for name in names if name not in POLICIES]
    if unknown:
        raise ConfigError(f"policies: got {', '.join(unknown)}, wanted some of {', '.join(POLICIES)}")
    return tuple(dict.fromkeys((*ALWAYS, *names)))


def _policy(name: str, world: CoverageWorld) -> ViewPolicy:
    if name == GREEDY:
        return CoverageOracle(world)
    if name in VOLUMETRIC:
        cube = Lattice(np.full(3, -0.5), 1 / _CELLS, (_CELLS, _CELLS, _CELLS))
        return VolumetricPolicy(VOLUMETRIC[name], Mapper(cube, model=CERTAIN, empty_is_free=True))
    return FarthestPolicy() if name == FARTHEST else UniformPolicy()


def _mean(world: CoverageWorld, players: Sequence[ViewPolicy], first: int, steps: int) -> Array:
    """Return (2, steps) coverage by each rule, mean over the players."""
    episodes = [run_coverage_episode(world, player, first=first, views=steps) for player in players]
    return np.asarray(np.mean([_both(episode) for episode in episodes], axis=0))


def _both(episode: CoverageEpisode) -> Array:
    return np.stack([episode.union, episode.published])


@lru_cache(maxsize=32)
def _opened(path: Path) -> Scorer:
    """Return a network; a process keeps it from object to object."""
    return Scorer.load(path, threads=1)

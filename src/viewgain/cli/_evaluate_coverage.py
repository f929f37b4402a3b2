"""``viewgain evaluate coverage``: the objects, who plays on them, and the tables of what they covered."""

from collections.abc import Sequence
from pathlib import Path

from viewgain.cli._evaluate_commands import EvaluateCoverage, Judging
from viewgain.cli._judging import check_options, named_scorers, note, planned, say_skipped
from viewgain.cli._progress import bar
from viewgain.datasets import Engine, LocalEngine, Plan, Progress, Skipped, read_manifest
from viewgain.errors import ConfigError
from viewgain.evaluation import (
    POLICIES,
    CoverageTable,
    Played,
    PlayTask,
    check_policies,
    coverage_table,
    data_plan,
    play,
    shipped_scorers,
    unit_parts,
)
from viewgain.gain import COVERAGE_PROTOCOLS
from viewgain.inference import find_model
from viewgain.rigs import rig

_KILLED = "killed its process, twice (not enough memory?)"


def covered(command: EvaluateCoverage, *, engine: Engine | None = None) -> list[CoverageTable]:
    """Return the tables, one per part.

    Args:
        command: The command line.
        engine: Who plays; None for as many processes as the command says.

    Raises:
        ConfigError: If the options, steps or policies make no sense, a network is of another rig, or the data is of no coverage.
        DataError: If there is no data set, or nothing to judge.
        ModelError: If there is no such network, or it is damaged.
    """
    options = command.judging
    check_options(options, meshes_of_data=True)
    views = len(rig(command.rig).stations)
    if not 1 <= command.steps <= views:
        raise ConfigError(f"evaluate: got --steps {command.steps}, wanted 1 to {views}, as many as rig {command.rig} has views")
    policies, networks = check_policies(command.policies), _networks(options, command.rig)
    protocol = next(name for name, each in COVERAGE_PROTOCOLS.items() if each.rig == command.rig)
    plan = _plan(options)
    parts = unit_parts(plan, "data" if options.data else "meshes" if options.meshes else "fresh")
    tasks = [
        PlayTask(
            unit=unit, mesh_seed=plan.recipe.seed, protocol=protocol, policies=policies, networks=networks,
            steps=command.steps, seed=options.seed,
        )
        for part in parts
        for unit in part.units
    ]  # fmt: skip
    done = _done(tasks, engine or LocalEngine(options.workers))
    say_skipped([each for each in done.values() if isinstance(each, Skipped)])
    results = [(part, [done[unit.number] for unit in part.units]) for part in parts]
    return [
        coverage_table(
            [each for each in found if isinstance(each, Played)],
            data=plan.recipe.name,
            split=part.name,
            title=part.title,
            protocol=protocol,
            skipped=[each for each in found if isinstance(each, Skipped)],
            seed=options.seed,
        )
        for part, found in results
    ]


def _plan(options: Judging) -> Plan:
    if options.data is not None:
        return data_plan(read_manifest(options.data), options.meshes)
    return planned(options)


def _networks(options: Judging, rig_name: str) -> tuple[tuple[str, Path], ...]:
    """Return names and files of the networks.

    Raises:
        ConfigError: If one is of another rig.
    """
    if options.floors_only:
        return ()
    if not options.models:
        fitting = tuple((name, find_model(name)) for name in shipped_scorers(rig_name))
        if not fitting:
            note(f"no shipped network fits rig {rig_name}: policies without learning alone")
        return fitting
    scorers = named_scorers(options.models, reserved=POLICIES)
    for scorer in scorers.values():
        reason = scorer.refusal(rig=rig_name)
        if reason:
            raise ConfigError(f"evaluate: {reason}; or choose --rig {scorer.card.rig}")
    return tuple((name, find_model(model)) for name, model in zip(scorers, options.models, strict=True))


def _done(tasks: Sequence[PlayTask], engine: Engine) -> dict[int, Played | Skipped]:
    """Return what came of each object, by its number."""
    done: dict[int, Played | Skipped] = {}
    with bar("objects") as watch:
        for task, result in engine.run(play, tasks):
            unit = task.unit
            died = Skipped(unit=unit.number, name=unit.name, reason=_KILLED)
            done[unit.number] = result if isinstance(result, Played | Skipped) else died
            skipped = sum(isinstance(each, Skipped) for each in done.values())
            watch(Progress(units=len(done), total=len(tasks), samples=len(done), skipped=skipped))
    return done

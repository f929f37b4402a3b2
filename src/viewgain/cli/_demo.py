"""``viewgain demo``: the closed loop on one random scene, told step by step, and a report folder."""

import numpy as np

from viewgain.camera import sensor
from viewgain.cli._commands import Demo
from viewgain.cli._text import decider_in_words, decision_in_words, measurement_table, ranking_table, to_stdout
from viewgain.episodes import Step, World, run_episode
from viewgain.plan import AutomaticPolicy
from viewgain.report import write_report
from viewgain.scenes import Scene, SceneRanges, random_box, random_view


def run_demo(command: Demo) -> int:
    """Run, tell and report one episode."""
    camera = sensor(command.camera)
    rng = np.random.default_rng(command.seed)
    box = random_box(rng)
    world = World(Scene((box,)), camera, scale=rng.normal(0, camera.scale_sd), offset=rng.normal(0, camera.offset_sd))
    first = random_view(rng, box, SceneRanges(elevation_deg=(15, 35), aim_sd=0.2))
    episode = run_episode(
        world,
        first,
        rng=rng,
        rig=command.rig,
        policy=AutomaticPolicy,
        tolerance=command.tolerance,
        confidence=command.confidence,
        max_views=command.max_views,
    )
    truth = np.sort(box.extents)[::-1]
    print(f"A box of {' x '.join(f'{1000 * d:.1f}' for d in truth)} mm ({1000 * box.volume:.2f} l) stands on the floor.")
    for number, step in enumerate(episode.steps, 1):
        print(f"\nView {number}")
        _tell(step, episode.errors[number - 1], last=number == len(episode.steps))
    print(f"\nReport: {write_report(episode, command.out)}")
    return 0


def _tell(step: Step, error: float, *, last: bool) -> None:
    to_stdout(measurement_table(step.fused))
    if step.fused.boxes:
        print(f"Against the truth: volume off by {error:.2%}.")
    if not (last and step.plan.stop):
        to_stdout(ranking_table(step.plan))
    if not step.plan.stop:
        print(decider_in_words(step.plan))
    print(decision_in_words(step.plan))

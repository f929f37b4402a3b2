"""``viewgain next``: rank the candidate views and say in words where to go."""

import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from viewgain.cli._commands import Next
from viewgain.cli._exit import NOTHING_MEASURED
from viewgain.cli._files import check, read_floor, read_one
from viewgain.cli._text import decider_in_words, decision_in_words, measurement_table, ranking_table, to_stdout
from viewgain.errors import ConfigError
from viewgain.inference import Ensemble, PoseScorer, find_model, model_name, shipped_models, volume_scorer
from viewgain.measure import POSE_SIGMA, REASONS, fuse, measure
from viewgain.plan import (
    AROUND,
    BESIDE_NETWORK,
    AutomaticPolicy,
    CovariancePolicy,
    ExpectedErrorPolicy,
    NetworkPolicy,
    Place,
    Policy,
    VolumeJudge,
    VolumeNetworkAboutBox,
    next_view,
)
from viewgain.rigs import rig
from viewgain.scans import Scan

WITHOUT_FILE: Mapping[str, Callable[[Scan], Policy]] = {
    "auto": AutomaticPolicy,
    "model": lambda scan: CovariancePolicy(POSE_SIGMA),
    "expected": lambda scan: ExpectedErrorPolicy(),
}
"""Policies for which no network can be named."""


def run_next(command: Next) -> int:
    """Plan and print; exit code 3 if there is nothing to plan for."""
    check(command.scans, command.reading)
    scans = [read_one(path, index, command.reading) for index, path in enumerate(command.scans)]
    camera, floor = command.reading.camera, read_floor(command.reading)
    current = measure(scans[0], camera=camera, floor=floor) if len(scans) == 1 else fuse(scans, camera=camera, floor=floor)
    policy = _policy(command, scans[-1])
    if command.deciding.policy == "rehearsed" and not command.json:
        print(
            "viewgain: note: trying views out in simulation first, unless enough is known or no box could be measured; eight"
            " views take a minute or more",
            file=sys.stderr,
        )
    plan = next_view(
        current,
        command.rig,
        objective=command.objective,
        policy=policy,
        camera=camera,
        tolerance=command.tolerance,
        confidence=command.confidence,
        judge=VolumeJudge(scans[-1], command.deciding.abstain) if command.objective == "volume" else None,
        place=_place(command),
        scan=scans[-1],
    )
    if command.json:
        print(json.dumps(plan.to_dict(), allow_nan=False))
        return 0 if plan.candidates else NOTHING_MEASURED
    for note in current.notes:
        print(f"viewgain: note: {note}", file=sys.stderr)
    to_stdout(measurement_table(current))
    if not plan.candidates:
        print(f"viewgain: {plan.reason}: {REASONS.get(plan.reason or '', 'no candidate view')}", file=sys.stderr)
        return NOTHING_MEASURED
    to_stdout(ranking_table(plan))
    if command.deciding.policy == "auto" and not plan.stop:
        print(decider_in_words(plan))
    print(decision_in_words(plan))
    return 0


def _place(command: Next) -> Place | None:
    """Return where the box is said to stand, if anybody says so."""
    if command.place is not None:
        return Place(np.array(command.place), AROUND if command.place_sigma is None else command.place_sigma)
    if command.place_sigma is not None:
        raise ConfigError(f"--place-sigma: got {command.place_sigma:g} and no place, wanted --place X Y Z, which it is said of")
    return None


def _policy(command: Next, scan: Scan) -> Policy:
    """Return who decides."""
    deciding = command.deciding
    if command.objective == "coverage" and deciding.policy != "network":
        raise ConfigError(f"--objective coverage: got --policy {deciding.policy}, which knows boxes only; add --policy network")
    if deciding.policy in WITHOUT_FILE:
        if deciding.model:
            raise ConfigError(
                f"--model: got {deciding.model[0]}, and --policy {deciding.policy} asks none that is named; add --policy network"
            )
        return WITHOUT_FILE[deciding.policy](scan)
    if command.objective != "coverage":
        return _for_volume(command, scan)
    name = rig(command.rig).name
    models = deciding.model or (_shipped(name, posed=scan.camera_to_world is not None),)
    return NetworkPolicy(Ensemble.load(models), scan, name, abstain_below=deciding.abstain)


def _for_volume(command: Next, scan: Scan) -> Policy:
    deciding = command.deciding
    if len(deciding.model) > 1:
        raise ConfigError(
            f"--policy {deciding.policy}: got {len(deciding.model)} networks for --objective {command.objective}, wanted one that"
            " was trained for volumes; name it with --model, or none for the shipped one"
        )
    network = PoseScorer.load(deciding.model[0]) if deciding.model else volume_scorer()
    return VolumeNetworkAboutBox(network, scan, BESIDE_NETWORK[deciding.policy])


def _shipped(rig_name: str, *, posed: bool) -> Path:
    """Return the shipped network for a rig, of those without the view state the one that chooses best: compact before full size.

    Raises:
        ModelError: If there is none.
    """
    frames = ("object", "camera") if posed else ("camera", "object")
    names = [model_name(kind, rig_name, frame) for frame in frames for kind in ("compact", "pc_nbv_noview")]
    return find_model(next((name for name in names if name in shipped_models()), names[0]))

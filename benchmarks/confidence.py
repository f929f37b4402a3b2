"""Fit the confidence of decisions for the volume to boxes of which the truth is kept, and judge it on boxes it was not fitted to.

The boxes are those of ``viewgain evaluate volume --out FOLDER``; the decisions are taken again.
"""

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks._logistic import logistic
from benchmarks._tables import markdown
from viewgain.arrays import Vector
from viewgain.datasets import write_whole
from viewgain.evaluation import (
    Selective,
    VolumeRun,
    VolumeSettings,
    judged,
    position_scores,
    run_boxes,
    selective,
    selective_markdown,
)
from viewgain.evaluation._box_results import box_file
from viewgain.evaluation._claim import SETTINGS
from viewgain.evaluation._volume_confidence import ASKED
from viewgain.plan import NUMBERS, Confidence
from viewgain.report import write_confidence_picture

FOLDS = 10
RIDGE = 1.0
"""Holds back the weights of scaled numbers."""
LEAST_SCALE = 1e-3
"""Of a number that hardly varies."""


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """A folder of boxes."""

    settings: VolumeSettings
    """What was asked."""
    runs: Sequence[VolumeRun]
    """What came of each box, and of each policy's decision."""

    @property
    def words(self) -> str:
        """Which boxes these are."""
        asked = self.settings
        fused = ", fused" if asked.fused else ""
        return f"{len(self.runs)} boxes of seed {asked.seed}, {asked.rig}, {asked.camera}, {asked.captures} captures{fused}"


@dataclass(frozen=True, slots=True)
class Decision:
    """One decision on a box of which the truth is known."""

    owner: tuple[int, int]
    """Which folder, and which box of it."""
    policy: str
    """Who chose."""
    numbers: Vector | None
    """(F,) what was known; None where nothing was."""
    found: float
    """1 where the choice was within two points of the best, by all scans that are kept."""


def run(options: argparse.Namespace) -> None:
    """Print the tables of every folder that ``--data`` names; write the fit to all of them where ``--out`` says."""
    if not options.data:
        print("confidence: name folders of viewgain evaluate volume --out FOLDER with --data FOLDER ...\n")
        return
    folders = [_evidence(folder, options.workers) for folder in options.data]
    decisions = [each for place, folder in enumerate(folders) for each in _decisions(place, folder)]
    said = out_of_fold(decisions, folders)
    print("## Confidence of decisions for the volume\n")
    print(f"Fitted to {len(decisions)} decisions, of every policy on every box; {FOLDS} folds by box.\n")
    for place, folder in enumerate(folders):
        rows = {policy: _judged(folder, policy, place, said) for policy in folder.runs[0].choices}
        print(f"### {folder.words}")
        print("\n".join(selective_markdown(rows)) + "\n")
        if options.pictures is not None:
            options.pictures.mkdir(parents=True, exist_ok=True)
            name, first = next(iter(rows.items()))
            picture = options.pictures / f"confidence-{folder.settings.seed}{'-fused' * folder.settings.fused}.png"
            write_confidence_picture(first, f"{name.partition(':')[0]}, out of fold, {folder.words}", picture)
    whole = fitted(decisions, tuple(folder.words for folder in folders))
    print(markdown(("number", "mean", "scale", "weight"), [
        (name, *(f"{value:.3f}" for value in row))
        for name, row in zip(NUMBERS, zip(whole.mean, whole.scale, whole.weights, strict=True), strict=True)
    ]) + f"\n\nBias {whole.bias:.3f}.\n")  # fmt: skip
    if options.out is not None:
        write_whole(options.out, (json.dumps(whole.to_dict()) + "\n").encode())


def fitted(decisions: Sequence[Decision], words: tuple[str, ...]) -> Confidence:
    """Return the confidence that makes what was found likeliest; decisions that rest on nothing do not count."""
    known = [each for each in decisions if each.numbers is not None]
    numbers, found = np.array([each.numbers for each in known]), np.array([each.found for each in known])
    mean, scale = np.round(numbers.mean(axis=0), 5), np.round(numbers.std(axis=0) + LEAST_SCALE, 5)
    weights, bias = logistic((numbers - mean) / scale, found, RIDGE)
    return Confidence(mean, scale, np.round(weights, 5), round(bias, 5), words)


def out_of_fold(decisions: Sequence[Decision], folders: Sequence[Evidence]) -> dict[tuple[int, int, str], float]:
    """Return the chance of every decision, by folder, box and policy, each by a fit that saw no decision on its box."""
    owners = [(place, run.number) for place, folder in enumerate(folders) for run in folder.runs]
    order = np.random.default_rng(0).permutation(len(owners))
    fold = {owners[at]: place % FOLDS for place, at in enumerate(order)}
    fits = [fitted([each for each in decisions if fold[each.owner] != k], ()) for k in range(FOLDS)]
    return {(*each.owner, each.policy): fits[fold[each.owner]].chance(each.numbers) for each in decisions}


def _evidence(folder: Path, workers: int) -> Evidence:
    content = json.loads((folder / SETTINGS).read_text(encoding="utf-8"))
    asked = {key: value for key, value in content.items() if key not in ("viewgain", "rig_stations")}
    settings = VolumeSettings(**{**asked, "side": tuple(asked["side"])})
    boxes = next(number for number in range(10**6) if not box_file(folder, number).exists())
    network = ASKED[settings.fused]
    policies = (f"combined:{network}", "expected", f"network:{network}", "covariance")
    return Evidence(settings, run_boxes(settings, boxes, policies, workers=workers, folder=folder))


def _decisions(place: int, folder: Evidence) -> list[Decision]:
    decisions: list[Decision] = []
    for each in folder.runs:
        scores = [position_scores(each.errors, each.reachable)]
        for policy, made in each.choices.items():
            found = judged(scores, [made.position])[0, 1]
            decisions.append(Decision((place, each.number), policy, each.numbers[policy], float(found)))
    return decisions


def _judged(folder: Evidence, policy: str, place: int, said: dict[tuple[int, int, str], float]) -> Selective:
    """Return what a policy's confidence is worth, judged as the tables are: by half of the scans, the others are the oracle's."""
    half = folder.settings.captures
    scoring = [position_scores(each.errors[:, :half], each.reachable) for each in folder.runs]
    apart = [position_scores(each.errors[:, half:], each.reachable) for each in folder.runs]
    values = judged(scoring, [each.choices[policy].position for each in folder.runs])
    oracle = judged(scoring, [other.least for other in apart])
    chances = [said[(place, each.number, policy)] for each in folder.runs]
    margins = [each.choices[policy].margin for each in folder.runs]
    return selective(chances, margins, values[:, 1], values[:, 2], oracle[:, 2], rng=np.random.default_rng(0))

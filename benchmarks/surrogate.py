"""Is the expected error of a view, worked out from the true box without a scan, that of the real estimator?"""

import argparse
from collections.abc import Sequence

import numpy as np
from scipy.stats import spearmanr

from benchmarks._tables import bootstrap, markdown, percent
from viewgain.datasets import volume_alone, volume_fused
from viewgain.evaluation import (
    VolumeRun,
    VolumeSettings,
    best_positions,
    position_scores,
    rank_correlation,
    run_boxes,
    volume_case,
    worth,
)

CAPTURES = 4
"""Scans per position and half; both halves count here."""
BOXES = 160
"""About 5,000 measurements on the four irregular positions."""
SETTINGS = (
    VolumeSettings(seed=700, captures=CAPTURES),
    VolumeSettings(seed=701, captures=CAPTURES, camera="kinect_v2"),
    VolumeSettings(seed=702, captures=2, rig="ring8", fused=True),
)
"""What is compared; of the third an eighth of the boxes, for each takes several times as long."""

_SETTING = """\
Random boxes of 0.05 to 1.2 m, random yaw, positions that can be reached. Expected: from the true box and the position without
jitter, no scan. Real: mean |relative volume error| of the scans, a miss counts as 100 %.
"""


def run(options: argparse.Namespace) -> None:
    """Print the table."""
    boxes = options.scenes or BOXES
    print("## Expected error of a view against the default estimator\n")
    print(_SETTING)
    header = ("rig, camera", "boxes", "runs", "real mean", "expected mean", "rank correlation of all positions",
              "of one box's, mean", "its best is a best", "within 2 points", "error of its best over the least")  # fmt: skip
    rows = []
    for settings in SETTINGS:
        count = max(boxes // 8, 2) if settings.fused else boxes
        runs = run_boxes(settings, count, (), workers=options.workers)
        rows.append(_row(settings, runs))
    print(markdown(header, rows) + "\n")


def _row(settings: VolumeSettings, runs: Sequence[VolumeRun]) -> tuple[str, ...]:
    scores = [position_scores(each.errors, each.reachable) for each in runs]
    expected = [_expected(settings, each.number) for each in runs]
    chosen = [int(np.argmin(np.where(box.allowed, each, np.inf))) for box, each in zip(scores, expected, strict=True)]
    real = np.concatenate([box.mean[box.allowed] for box in scores])
    said = np.concatenate([each[box.allowed] for box, each in zip(scores, expected, strict=True)])
    correlations = [rank_correlation(box.mean, each, box.allowed) for box, each in zip(scores, expected, strict=True)]
    within = [correlation for correlation in correlations if correlation is not None]
    best = [float(best_positions(box)[place]) for box, place in zip(scores, chosen, strict=True)]
    near = [float(worth(box)[place, 1]) for box, place in zip(scores, chosen, strict=True)]
    above = [float(box.mean[place] - box.mean[box.least]) for box, place in zip(scores, chosen, strict=True)]
    total = sum(int(each.reachable.sum()) * each.errors.shape[1] for each in runs)
    kind = ", fused with the present scan" if settings.fused else ""
    return (
        f"{settings.rig}, {settings.camera}{kind}", str(len(runs)), f"{total:,}", percent(float(real.mean())),
        percent(float(said.mean())), f"{spearmanr(said, real).statistic:.3f}", _with_interval(within, 1.0),
        _with_interval(best), _with_interval(near), _with_interval(above),
    )  # fmt: skip


def _expected(settings: VolumeSettings, number: int) -> np.ndarray:
    """Return (V,) expected errors of a case's positions."""
    case = volume_case(settings, number)
    if settings.fused:
        return -volume_fused(case.box, case.stations[case.present], case.stations, case.camera)
    return -volume_alone(case.box, case.stations, case.camera)


def _with_interval(values: Sequence[float], scale: float = 100.0) -> str:
    if not values:
        return "none"
    low, high = bootstrap(values)
    unit = " %" if scale == 100.0 else ""
    return f"{scale * float(np.mean(values)):.3g}{unit} ({scale * low:.3g} to {scale * high:.3g})"

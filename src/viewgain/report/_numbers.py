"""The numbers of an episode as one JSON document."""

import numpy as np

from viewgain.episodes import Episode, Step
from viewgain.report._truth import true_dimensions, true_of_reported

SCHEMA = 1
"""Version of the JSON form; it grows by new keys only."""


def numbers(episode: Episode) -> dict[str, object]:
    """Return the truth, and per step what was measured, what was planned and how far off it is (metres, cubic metres)."""
    truth = episode.world.box
    return {
        "schema": SCHEMA,
        "truth": {
            "dimensions_m": [round(float(side), 6) for side in true_dimensions(truth)],
            "volume_m3": round(truth.volume, 9),
            "box_to_world": np.round(truth.box_to_camera, 6).tolist(),
        },
        "camera": episode.world.sensor.name,
        "range_error": {"scale": episode.world.scale, "offset_m": episode.world.offset},
        "stopped": episode.stopped,
        "volume_errors": [round(error, 6) for error in episode.errors],
        "steps": [_step(episode, step) for step in episode.steps],
    }


def _step(episode: Episode, step: Step) -> dict[str, object]:
    return {
        "scan": step.scan.source,
        "single": step.single.to_dict(),
        "fused": step.fused.to_dict(),
        "next": step.plan.to_dict(),
        "against_truth": _against_truth(episode, step),
    }


def _against_truth(episode: Episode, step: Step) -> dict[str, object] | None:
    """Return signed relative errors of the first box, each dimension against the true side that it runs along."""
    if not step.fused.boxes:
        return None
    estimate, truth = step.fused.boxes[0], episode.world.box
    true = true_of_reported(estimate, step.fused.world, truth)
    return {
        "true_dimensions_m": [round(float(side), 6) for side in true],
        "relative_errors": [round(float(error), 6) for error in estimate.dimensions / true - 1],
        "relative_volume_error": round(estimate.volume / truth.volume - 1, 6),
    }

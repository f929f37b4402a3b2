"""A network's scores of a data set's samples, and how long they take."""

from dataclasses import dataclass
from time import process_time

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array, Vector
from viewgain.datasets import Dataset, Frame, Sample, rig_of
from viewgain.errors import ConfigError
from viewgain.inference import Scorer


@dataclass(frozen=True, slots=True, eq=False)
class Scored:
    """What a network says of some samples."""

    scores: Array
    """(N, V) the higher the better, present view first."""
    milliseconds: Vector
    """(N,) CPU time from each cloud to its scores, thinning included."""


def scored(data: Dataset, rows: NDArray[np.intp], scorer: Scorer, *, frame: Frame | None = None) -> Scored:
    """Return a network's scores of some samples, one cloud at a time; clouds are thinned by the sample's index as the seed.

    Args:
        data: The data set; its clouds are normalised already.
        rows: (N,) indices.
        scorer: Opened with one thread, so that CPU time is the time that it takes.
        frame: Frame that the points are brought into first; None for the data's own.

    Raises:
        ConfigError: If the network is of another rig or frame, or points cannot be brought there: poses are not known.
        ScanError: If a sample has no points.
    """
    frame = frame or data.manifest.frame
    reason = scorer.refusal(frame=frame, rig=rig_of(data.manifest))
    if reason:
        raise ConfigError(f"{data.manifest.recipe['name']}: {reason}")
    scores, spent = np.zeros((len(rows), scorer.card.views)), np.zeros(len(rows))
    for place, index in enumerate(rows.tolist()):
        sample = data[index].in_frame(frame)
        start = process_time()
        scores[place] = _scores_of(sample, scorer, index)
        spent[place] = 1e3 * (process_time() - start)
    return Scored(scores, spent)


def _scores_of(sample: Sample, scorer: Scorer, seed: int) -> Vector:
    """Return (V,) scores, present view first."""
    if not scorer.card.with_view_state:
        return scorer.scores(sample.points, seed=seed)
    state = np.roll(sample.state, sample.view)
    return np.roll(scorer.scores(sample.points, state, seed=seed), -sample.view)

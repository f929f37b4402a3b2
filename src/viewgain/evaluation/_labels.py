"""What labels choose: the best position of each box by some targets, and what is measured from there."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array
from viewgain.datasets import Dataset, box_views, knows_poses, object_errors, rig_of, with_target
from viewgain.errors import ConfigError, DataError
from viewgain.evaluation._bootstrap import Shares, difference_by_object, shares_by_object
from viewgain.gain import TERMS, ErrorHistogram, NearZero, costs

RANDOM, ALWAYS, LEAST = "a position at random", "always position {}", "the position of least mean error"
"""Names of what chooses without a label; the last two know the errors that they are judged by."""
_STREAM = 0x6C62


@dataclass(frozen=True, slots=True, kw_only=True)
class LabelRow:
    """One way to choose a position for each box."""

    name: str
    """The target, or what chooses without one."""
    best: tuple[int, ...] | None
    """The position of each box, in the order of the table's boxes; None where it is drawn."""
    other_boxes: int | None
    """Boxes with another position than the first target gives them; None where it is drawn."""
    other_scans: int | None
    """Scans of those boxes."""
    outcomes: Shares
    """Mean cost of a scan from the chosen positions, share near zero error, share without an estimate: means over boxes."""
    difference: Shares | None
    """The same minus those of the first target, box by box; None in its own row."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChoiceRow:
    """Something that labels choose by, without a weight."""

    name: str
    """The share of scans near zero error, or a term."""
    by_position: tuple[float, ...]
    """Mean over boxes."""
    widest: float
    """The largest difference between two positions of one box."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LabelTable:
    """One table."""

    data: str
    """Name of the data set's recipe."""
    rig: str
    estimator: str
    """Whose errors say what a position is worth."""
    boxes: tuple[int, ...]
    """Numbers of the boxes."""
    positions: int
    """Of each box."""
    scans: int
    """Of all boxes from all positions."""
    rows: tuple[LabelRow, ...]
    """The targets in the order asked for, then what needs no label."""
    chosen_by: tuple[ChoiceRow, ...]
    """What labels weigh against each other; of recordings without the terms, which nobody knows there."""

    def to_dict(self) -> dict[str, Any]:
        """Return the table as plain values for JSON."""
        return dataclasses.asdict(self)


def best_by_box(data: Dataset, target: str) -> dict[int, int]:
    """Return the best position of each box, in rig order, by a target that is the same for all its scans; of equals the first.

    Raises:
        ConfigError: As of :func:`viewgain.datasets.with_target`.
        DataError: As there.
    """
    scored, best = with_target(data, target), {}
    for number, row in zip(*np.unique(data.column("object"), return_index=True), strict=True):
        sample = scored[int(row)]
        best[int(number)] = int(np.argmax(sample.in_rig_order(sample.targets[target])))
    return best


def label_table(data: Dataset, targets: Sequence[str], *, estimator: str = "lines_published", seed: int = 0) -> LabelTable:
    """Return what each target chooses, and what all scans from the chosen positions measure.

    A scan costs min(|V / V* - 1|, 1), and 1 without an estimate. Every box counts alike. The scans are those that the targets are
    counted from, so a target is flattered a little in what it counts.

    Args:
        data: Boxes scanned from the same number of positions each, with the volume errors of the estimator.
        targets: As in training (:func:`viewgain.datasets.with_target`), each once; the others are held against the first.
        estimator: Whose errors are the outcomes.
        seed: Of the bootstrap.

    Raises:
        ConfigError: If no target is named, or one twice, or one is unknown.
        DataError: If errors are missing, or boxes have different numbers of positions.
    """
    if not targets or len(set(targets)) < len(targets):
        raise ConfigError(f"labels: got the targets {', '.join(targets) or 'none'}, wanted one or more, each once")
    boxes, scans = np.unique(data.column("object").astype(np.int64), return_counts=True)
    worth = _outcomes(data, estimator)
    constant = int(np.argmin(worth[:, :, 0].mean(axis=0)))
    chosen = {target: np.array(list(best_by_box(data, target).values())) for target in targets}
    known = _Known(boxes, scans, worth, chosen[targets[0]], seed)
    choices = [*chosen.items(), (RANDOM, None), (ALWAYS.format(constant), np.full(len(boxes), constant)),
               (LEAST, worth[:, :, 0].argmin(axis=1))]  # fmt: skip
    return LabelTable(
        data=str(data.manifest.recipe["name"]),
        rig=rig_of(data.manifest),
        estimator=estimator,
        boxes=tuple(boxes.tolist()),
        positions=worth.shape[1],
        scans=len(data),
        rows=tuple(_row(name, best, known) for name, best in choices),
        chosen_by=_chosen_by(data, worth[:, :, 1]),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Known:
    """What choices are judged by."""

    boxes: NDArray[np.int64]
    """(B,) numbers."""
    scans: NDArray[np.int64]
    """(B,) how many there are of each box."""
    worth: Array
    """(B, V, 3) outcomes."""
    first: NDArray[np.int64]
    """(B,) positions by the first target."""
    seed: int
    """Of the draws of boxes, the same ones for every row."""

    @property
    def rng(self) -> np.random.Generator:
        """A generator at its beginning."""
        return np.random.default_rng([self.seed, _STREAM])


def _row(name: str, best: NDArray[np.int64] | None, known: _Known) -> LabelRow:
    """Return the row of (B,) chosen positions, or of drawn ones."""
    first = known.worth[np.arange(len(known.boxes)), known.first]
    found = known.worth.mean(axis=1) if best is None else known.worth[np.arange(len(known.boxes)), best]
    moved = None if best is None else best != known.first
    return LabelRow(
        name=name,
        best=None if best is None else tuple(best.tolist()),
        other_boxes=None if moved is None else int(moved.sum()),
        other_scans=None if moved is None else int(known.scans[moved].sum()),
        outcomes=shares_by_object(found, known.boxes, rng=known.rng),
        difference=None if best is known.first else difference_by_object(found, first, known.boxes, rng=known.rng),
    )


def _chosen_by(data: Dataset, near_zero: Array) -> tuple[ChoiceRow, ...]:
    values = {"near zero error": near_zero}
    if knows_poses(data):
        views = box_views(data)
        values |= {name: np.stack([term.gains(each) for each in views.values()]) for name, term in TERMS.items()}
    return tuple(
        ChoiceRow(name=name, by_position=tuple(each.mean(axis=0).tolist()), widest=float(np.ptp(each, axis=1).max()))
        for name, each in values.items()
    )


def _outcomes(data: Dataset, estimator: str) -> Array:
    """Return (B, V, 3): mean cost, share near zero and share missed of each box and position."""
    errors = object_errors(data, estimator)
    counts = sorted({len(each) for each in errors.values()})
    if len(counts) != 1:
        raise DataError(f"{data.folder}: got boxes of {counts} positions, wanted the same number for all; name data of one rig")
    return np.stack([_of_box(each) for each in errors.values()])


def _of_box(errors: Array) -> Array:
    histogram = ErrorHistogram.from_errors(errors)
    return np.column_stack([costs(errors).mean(axis=1), NearZero().gains(histogram), histogram.missed / histogram.scans])

"""The paper's Table 2: how often a network names the best position of a box, on boxes that it was trained on and on others."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array
from viewgain.datasets import Dataset, rig_of
from viewgain.errors import ConfigError, DataError
from viewgain.evaluation._bootstrap import Shares, shares_by_object
from viewgain.evaluation._labels import best_by_box
from viewgain.evaluation._markdown import markdown_table
from viewgain.inference import Scorer

UNIFORM2, RELATIVE, ABSOLUTE = "uniform guess", "constant relative answer", "constant absolute position"
"""Names of the floors."""
SAME, OTHER = "same boxes", "other boxes"
"""What is judged: test scans of boxes that train, and test scans of boxes that do not."""
_STREAM = 0x7432


@dataclass(frozen=True, slots=True, kw_only=True)
class Row2:
    """One way to choose."""

    name: str
    """What chooses."""
    same: Shares | None
    """Share of the same boxes' test scans where it names the best position, 95 % interval by box."""
    other: Shares | None
    """The same of other boxes' test scans."""
    milliseconds: float | None = None
    """Median CPU time from a scan to its scores, one thread; None where nothing is computed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table2:
    """One table."""

    data: str
    """Name of the data set's recipe."""
    rig: str
    target: str
    """What says which position is best."""
    labels: dict[int, int]
    """The best position of each box."""
    same_boxes: tuple[int, ...]
    other_boxes: tuple[int, ...]
    captures: int
    """Test scans per box and position, at most."""
    rows: tuple[Row2, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return the table as plain values for JSON."""
        return dataclasses.asdict(self)


def table2(
    data: Dataset,
    scorers: Mapping[str, Scorer],
    *,
    target: str = "histogram:lines_published:soft",
    captures: int = 50,
    other: Sequence[int] | None = None,
    seed: int = 0,
) -> Table2:
    """Return the table of a built ``boxes_paper`` set, or of recordings.

    Args:
        data: Scans of boxes from the positions of one rig, with volume errors where the target wants them.
        scorers: Networks of whole scans by name, each opened with one thread; none for the floors alone.
        target: As in training (``viewgain.datasets.with_target``).
        captures: Test scans of each box and position that are judged, at most.
        other: Numbers of the boxes that count as others; None for those that the division ``other_box`` keeps apart.
        seed: Of the bootstrap.

    Raises:
        DataError: If nothing is to be judged, or errors are missing.
        ConfigError: If a network is of another rig, or scores coverage.
    """
    best = best_by_box(data, target)
    objects = data.column("object").astype(np.int64)
    apart = set(objects[data.part("other_box", "test")].tolist()) if other is None else set(other)
    away = np.isin(objects, list(apart))
    test = np.zeros(len(data), dtype=bool)
    test[data.part("same_box", "test")] = True
    rows = {SAME: _few(data, np.flatnonzero(test & ~away), captures), OTHER: _few(data, np.flatnonzero(test & away), captures)}
    if not sum(map(len, rows.values())):
        raise DataError(f"{data.folder}: got no test scan in division same_box; build more captures than train")
    learned = sorted(set(objects.tolist()) - apart)
    hits: dict[str, dict[str, Array]] = {}
    times: dict[str, float] = {}
    for name, scorer in scorers.items():
        reason = scorer.refusal(frame=data.manifest.frame, rig=rig_of(data.manifest))
        if reason or scorer.card.normalisation != "metres":
            raise ConfigError(reason or f"network {name}: scores coverage and not volumes; name a network trained for volumes")
        answers = {part: _answers(data, each, scorer, best) for part, each in rows.items()}
        hits[name] = {part: right for part, (right, _) in answers.items()}
        times[name] = float(np.median(np.concatenate([spent for _, spent in answers.values()])))
    hits |= _floors(data, rows, best, learned)
    rng = np.random.default_rng([seed, _STREAM])
    shares = {
        name: {
            part: shares_by_object(right[:, None], objects[rows[part]], rng=rng) if len(right) else None
            for part, right in parts.items()
        }
        for name, parts in hits.items()
    }
    return Table2(
        data=str(data.manifest.recipe["name"]),
        rig=rig_of(data.manifest),
        target=target,
        labels=best,
        same_boxes=tuple(learned),
        other_boxes=tuple(sorted(apart)),
        captures=captures,
        rows=tuple(
            Row2(name=name, same=parts[SAME], other=parts[OTHER], milliseconds=times.get(name)) for name, parts in shares.items()
        ),
    )


def _few(data: Dataset, rows: NDArray[np.intp], captures: int) -> NDArray[np.intp]:
    """Return at most so many of the rows of each object and view, the first ones."""
    kept: dict[tuple[int, int], int] = {}
    chosen = []
    objects, views = data.column("object"), data.column("view")
    for row in rows.tolist():
        key = (int(objects[row]), int(views[row]))
        if kept.get(key, 0) < captures:
            kept[key] = kept.get(key, 0) + 1
            chosen.append(row)
    return np.array(chosen, dtype=np.intp)


def _answers(data: Dataset, rows: NDArray[np.intp], scorer: Scorer, best: Mapping[int, int]) -> tuple[Array, Array]:
    """Return (N,) whether the best position is named, and (N,) milliseconds."""
    right, spent = np.zeros(len(rows)), np.zeros(len(rows))
    for place, row in enumerate(rows.tolist()):
        sample = data[row]
        start = process_time()
        scores = scorer.scores(sample.points, frame=data.manifest.frame, seed=row)
        spent[place] = 1e3 * (process_time() - start)
        right[place] = int(np.argmax(sample.in_rig_order(scores))) == best[sample.object]
    return right, spent


def _floors(
    data: Dataset, rows: Mapping[str, NDArray[np.intp]], best: Mapping[int, int], learned: Sequence[int]
) -> dict[str, dict[str, Array]]:
    """Return what answers without learning get.

    A constant is chosen on the boxes that train: the position, or the offset from the present one, that is best most often there;
    of equals the lowest.
    """
    objects, views = data.column("object").astype(int), data.column("view").astype(int)
    count = len(data[0].candidates)
    position = int(np.bincount([best[number] for number in learned], minlength=count).argmax())
    # Every box is scanned from every position alike, so each offset is best equally often: the lowest is as good as any.
    offsets = [(best[number] - view) % count for number in learned for view in range(count)]
    offset = int(np.bincount(offsets, minlength=count).argmax())
    truth = {part: np.array([best[number] for number in objects[each]], dtype=int) for part, each in rows.items()}
    return {
        UNIFORM2: {part: np.full(len(each), 1 / count) for part, each in rows.items()},
        RELATIVE: {part: ((views[each] + offset) % count == truth[part]).astype(float) for part, each in rows.items()},
        ABSOLUTE: {part: (truth[part] == position).astype(float) for part in rows},
    }


def table2_markdown(table: Table2) -> str:
    """Return the table as Markdown."""
    labels = ", ".join(f"{number}: {place}" for number, place in table.labels.items())
    header = ("", f"{SAME}, %", f"{OTHER}, %", "ms")
    rows = [
        (row.name, _cell(row.same), _cell(row.other), "" if row.milliseconds is None else f"{row.milliseconds:.1f}")
        for row in table.rows
    ]
    return "\n".join([
        f"## Table 2: the best position, target {table.target}", "",
        f"Data {table.data}, rig {table.rig}; test scans, {table.captures} per box and position at most. Best position by box:"
        f" {labels}. Trained on boxes {_list(table.same_boxes)}; others {_list(table.other_boxes)}. 95 % intervals by box; of"
        " so few boxes they are too narrow.", "", *markdown_table(header, rows),
    ]) + "\n"  # fmt: skip


def _cell(shares: Shares | None) -> str:
    if shares is None:
        return "none"
    return f"{100 * shares.mean[0]:.2f} ({100 * shares.low[0]:.1f} to {100 * shares.high[0]:.1f})"


def _list(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers)) or "none"

"""PC-NBV's own protocol as a table: coverage view after view, its area, and the gap to the greedy oracle that is closed."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from viewgain.arrays import Vector
from viewgain.datasets import Skipped
from viewgain.errors import DataError
from viewgain.evaluation._bootstrap import Shares, difference_by_object, ratio_by_object, shares_by_object
from viewgain.evaluation._play import FARTHEST, GREEDY, RANDOM_POLICY, RULES, Played
from viewgain.gain import COVERAGE_PROTOCOLS, coverage_auc
from viewgain.rigs import rig

_INTERVALS = 0x6376


@dataclass(frozen=True, slots=True, kw_only=True)
class CoverageRow:
    """One policy, by one rule of counting."""

    policy: str
    rule: str
    """``union``, or ``published``, which counts some surface twice and may pass 1 (docs/gain.md)."""
    coverage: tuple[float, ...]
    """Mean coverage with 1, 2, ... views."""
    auc: Shares
    """Area under coverage by views, mean over objects: (c1 + ... + c9 + c10 / 2) / 10 for ten views."""
    auc_by_category: float
    """The same, mean over the means of the categories."""
    closed: Shares | None
    """Share of the gap between random and the greedy oracle that is closed; None if there is no gap."""
    over_farthest: Shares
    """AUC minus that of the farthest-view rule, paired by object."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CoverageTable:
    """One table."""

    data: str
    """Where the objects are from."""
    split: str
    """Which part is judged."""
    title: str
    """The same in words."""
    rig: str
    views: int
    """Candidates."""
    steps: int
    """Views taken, the random first one included."""
    objects: int
    categories: int
    skipped: tuple[Skipped, ...]
    """What could not be made."""
    rows: tuple[CoverageRow, ...]
    """By rule, then in ascending order of the AUC."""

    def to_dict(self) -> dict[str, Any]:
        """Return the table as plain values for JSON."""
        return dataclasses.asdict(self)


def coverage_table(
    played: Sequence[Played], *, data: str, split: str, title: str, protocol: str, skipped: Sequence[Skipped] = (), seed: int = 0
) -> CoverageTable:
    """Return the table of some objects; random, farthest and oracle must have played on each.

    Args:
        played: By object, the same policies and steps in each.
        data: Where the objects are from.
        split: Name of the part.
        title: The same in words.
        protocol: Key of ``viewgain.gain.COVERAGE_PROTOCOLS``.
        skipped: What could not be made.
        seed: Of the intervals.

    Raises:
        DataError: If there is no object.
    """
    if not played:
        reason = f"; the first reason: {skipped[0].name}: {skipped[0].reason}" if skipped else ""
        raise DataError(f"{data}: got no object to judge in part {split}{reason}")
    by_number = sorted(played, key=lambda each: each.number)
    categories = np.array([each.category for each in by_number])
    coverage = {name: np.stack([each.coverage[name] for each in by_number]) for name in by_number[0].coverage}
    rng = np.random.default_rng([seed, _INTERVALS])
    rows: list[CoverageRow] = []
    for place, rule in enumerate(RULES):
        auc = {name: np.array([coverage_auc(curve) for curve in each[:, place]]) for name, each in coverage.items()}
        of_rule = [
            _row(name, rule, tuple(coverage[name][:, place].mean(axis=0).tolist()), auc, categories, rng) for name in coverage
        ]
        rows += sorted(of_rule, key=lambda row: row.auc.mean[0])
    return CoverageTable(
        data=data,
        split=split,
        title=title,
        rig=COVERAGE_PROTOCOLS[protocol].rig,
        views=len(rig(COVERAGE_PROTOCOLS[protocol].rig).stations),
        steps=len(rows[0].coverage),
        objects=len(by_number),
        categories=len(np.unique(categories)),
        skipped=tuple(skipped),
        rows=tuple(rows),
    )


def _row(
    name: str, rule: str, coverage: tuple[float, ...], auc: dict[str, Vector], categories: Vector, rng: np.random.Generator
) -> CoverageRow:
    own, floor, objects = auc[name][:, None], auc[RANDOM_POLICY][:, None], np.arange(len(categories))
    means = [own[categories == category].mean() for category in np.unique(categories)]
    return CoverageRow(
        policy=name,
        rule=rule,
        coverage=coverage,
        auc=shares_by_object(own, objects, rng=rng),
        auc_by_category=float(np.mean(means)),
        closed=ratio_by_object(own - floor, auc[GREEDY][:, None] - floor, objects, rng=rng),
        over_farthest=difference_by_object(own, auc[FARTHEST][:, None], objects, rng=rng),
    )

"""Coverage gain of every view at every greedy step, by the exact published rule and by plain set union.

The published rule (Zeng et al. 2020, PC-NBV's public scripts). A view contributes only its new points: those not near any point
accumulated so far. Its gain is the share of surface samples near a new point, whether or not they were covered before; the best
view's new points are accumulated, and its gain is added to the coverage, so a sample on the rim of what is known counts twice.
By union, a view's gain is the share of samples that it covers and no chosen view does.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from viewgain.arrays import Array, Indices, Points
from viewgain.errors import ConfigError
from viewgain.gain._bits import Counts, size
from viewgain.gain._cover import Cover, cover
from viewgain.gain._first_step import MOST_VIEWS, first_gains
from viewgain.gain._greedy import require_start
from viewgain.gain._near import near_any
from viewgain.gain._pairs import tally
from viewgain.gain._protocol import CoverageProtocol

Rule: TypeAlias = Literal["published", "union"]
"""By which gain the next view is chosen."""
TOGETHER = 4
"""First views from which on one pass over all points is faster than one for each."""


@dataclass(frozen=True, slots=True, eq=False)
class CoverageLabels:
    """Gains of V views along one greedy sequence. Gains and coverages are shares of the surface samples."""

    first: int
    """The view that is there from the start."""
    order: Indices
    """(steps,) the view chosen at each step, the one with the highest gain by the rule; of equal ones the lowest."""
    gains_published: Array
    """(steps, V) gain of every view before each choice, by the published rule; 0 for a view that was chosen."""
    gains_union: Array
    """(steps, V) gain of every view before each choice, by set union; 0 for a view that was chosen."""
    coverage_published: Array
    """(steps + 1,) of the first view and after each step, gains added up; may exceed 1."""
    coverage_union: Array
    """(steps + 1,) of the first view and after each step: what is covered, counted once."""

    def gains(self, rule: Rule) -> Array:
        """Return the (steps, V) gains by a rule."""
        return self.gains_published if rule == "published" else self.gains_union


class NewPoints:
    """Which scan points are still new, and how many of them are near each surface sample, as views are accumulated."""

    def __init__(self, covered: Cover) -> None:
        """Start with nothing accumulated: every point of every view is new."""
        self._cover = covered
        self._views = covered.view_of_point
        self._new = np.ones(len(covered.points), dtype=bool)
        self._counts = covered.counts.copy()

    @property
    def gains(self) -> Counts:
        """(V,) number of surface samples near a new point of each view."""
        return np.asarray(np.count_nonzero(self._counts, axis=1))

    def accumulate(self, view: int) -> None:
        """Accumulate the new points of a view: they, and all points near them, are no longer new."""
        whole = self._cover
        own = slice(whole.view_starts[view], whole.view_starts[view + 1])
        remaining, added = np.flatnonzero(self._new), whole.points[own][self._new[own]]
        known = remaining[near_any(whole.points, remaining, added, whole.reach, search=whole.search)]
        self._new[known] = False
        tally(self._counts, whole.pairs, known, self._views, -1, search=whole.search)


def greedy_labels(
    covered: Cover,
    *,
    first: int,
    steps: int,
    rule: Rule = "published",
    wander: float = 0.0,
    rng: np.random.Generator | None = None,
) -> CoverageLabels:
    """Return the gains of every view at every step of one greedy sequence, or of one that strays from it, by both rules.

    Args:
        covered: What the views cover, of :func:`cover`; made once, it serves every first view.
        first: The view that is there from the start.
        steps: How many views follow, >= 1.
        rule: By which gain the next view is chosen.
        wander: Chance at each step that the next view is drawn at random among those not chosen yet (while there is one).
        rng: Source of these chances and views; needed if there are any.

    Raises:
        ConfigError: If there is no such first view, no step, no such rule, no such chance, or one without a source.

    Source:
        Zeng et al. (2020), public scripts. Differs in nothing but the precision: theirs is float32. (Where no view adds anything
        they accumulate the origin, which adds nothing either.)
    """
    require_start(first, steps, covered.views)
    _require_rule(rule)
    if not 0 <= wander <= 1 or (wander > 0 and rng is None):
        raise ConfigError(f"coverage: got wander {wander} and rng {rng}, wanted a chance from 0 to 1, and a generator if over 0")
    fresh, known = NewPoints(covered), np.zeros_like(covered.masks[first])
    order, published, union = [first], [fresh.gains], [size(covered.masks)]
    for _ in range(steps):
        fresh.accumulate(order[-1])
        known |= covered.masks[order[-1]]
        published.append(fresh.gains)
        union.append(size(covered.masks & ~known))
        best = int(np.argmax(published[-1] if rule == "published" else union[-1]))
        order.append(best if rng is None else _strayed(best, np.delete(np.arange(covered.views), order), wander, rng))
    return _labels(covered, order, published, union)


def _strayed(best: int, others: Indices, wander: float, rng: np.random.Generator) -> int:
    """Return the best view or, with a chance of ``wander``, one of those not chosen yet."""
    return int(rng.choice(others)) if rng.random() < wander and len(others) else best


def labels_from(covered: Cover, starts: Sequence[int], *, steps: int, rule: Rule = "published") -> tuple[CoverageLabels, ...]:
    """Return the labels from each of several first views: what :func:`greedy_labels` returns, to the last bit; raises as it does.

    One step from many first views is worked out from one pass over the points, several times as fast as one by one.

    Args:
        covered: What the views cover.
        starts: The first views.
        steps: How many views follow each, >= 1.
        rule: By which gain the next view is chosen.
    """
    if steps != 1 or len(starts) < TOGETHER or covered.views > MOST_VIEWS:
        return tuple(greedy_labels(covered, first=first, steps=steps, rule=rule) for first in starts)
    for first in starts:
        require_start(first, steps, covered.views)
    _require_rule(rule)
    alone, gains, masks = NewPoints(covered).gains, first_gains(covered), covered.masks
    labels = []
    for first in starts:
        published, union = [alone, gains[first]], [size(masks), size(masks & ~masks[first])]
        order = [first, int(np.argmax(published[-1] if rule == "published" else union[-1]))]
        labels.append(_labels(covered, order, published, union))
    return tuple(labels)


def _labels(covered: Cover, order: list[int], published: list[Counts], union: list[Counts]) -> CoverageLabels:
    """Return labels from counted gains: row k of either is what each view adds to the k views before it, in samples."""
    gains = np.array([published, union])  # counted in samples, so that sums are exact
    steps = len(order) - 1
    coverage = np.cumsum(gains[:, np.arange(steps + 1), order], axis=1) / covered.surface_count
    shares = gains[:, 1:] / covered.surface_count
    return CoverageLabels(order[0], np.array(order[1:], dtype=np.intp), shares[0], shares[1], coverage[0], coverage[1])


def _require_rule(rule: Rule) -> None:
    if rule not in ("published", "union"):
        raise ConfigError(f"coverage rule: got {rule!r}, wanted 'published' or 'union'")


def coverage_labels(
    clouds: Sequence[Points], surface: Points, protocol: CoverageProtocol, first: int, *, rule: Rule = "published"
) -> CoverageLabels:
    """Return the labels of a model from one first view: :func:`cover`, then :func:`greedy_labels`; raises as they do.

    Args:
        clouds: One (n, 3) cloud per view of the protocol, as of :func:`viewgain.gain.model_clouds`.
        surface: (m, 3) samples of the same normalised mesh.
        protocol: Reach and number of steps.
        first: The view that is there from the start.
        rule: By which gain the next view is chosen.
    """
    return greedy_labels(cover(clouds, surface, protocol.reach), first=first, steps=protocol.steps, rule=rule)


def coverage_auc(coverage_by_step: Array) -> float:
    """Return the area under coverage against number of views, from 0 views on, per view: (c1 + ... + c(n-1) + cn / 2) / n.

    Args:
        coverage_by_step: (n,) coverage with 1, 2, ... n views, n >= 1. PC-NBV's figure takes the first ten:
            ``coverage_auc(labels.coverage_union[:10])``.

    Raises:
        ConfigError: If it is empty.

    Source:
        The evaluation script of the public PyTorch port of PC-NBV; the trapezoidal rule.
    """
    coverage = np.asarray(coverage_by_step, dtype=float)
    if coverage.ndim != 1 or not len(coverage):
        raise ConfigError(f"coverage AUC: got an array of shape {coverage.shape}, wanted (n,) with n >= 1")
    return float((coverage.sum() - coverage[-1] / 2) / len(coverage))

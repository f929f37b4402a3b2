"""A histogram score together with the terms of a time-of-flight camera: the source paper's choice, with or without them."""

from collections.abc import Sequence
from dataclasses import dataclass

from viewgain.arrays import Vector
from viewgain.errors import ConfigError
from viewgain.gain._histogram import ErrorHistogram
from viewgain.gain._objective import Choice, Objective
from viewgain.gain._tof import BorderTerm, BoxViews, IncidenceTerm

TERMS: dict[str, Objective[BoxViews]] = {"incidence": IncidenceTerm(), "border": BorderTerm(10)}
"""The terms that targets name."""
TERM_WEIGHT = 0.2
"""What a term weighs where nothing else is said, in shares of the scans near zero error. Nobody has measured it."""


@dataclass(frozen=True, slots=True, eq=False)
class ScannedBox:
    """A box whose views were scanned many times, and how the cameras stood to it."""

    histogram: ErrorHistogram
    """The volume errors from each view."""
    views: BoxViews
    """The same views, without jitter."""

    def __post_init__(self) -> None:
        if len(self.histogram.counts) != len(self.views.cameras):
            raise ConfigError(
                f"scanned box: got a histogram of {len(self.histogram.counts)} views and {len(self.views.cameras)} cameras,"
                " wanted as many of each"
            )


@dataclass(frozen=True, slots=True)
class WithTerms:
    """score(histogram) + sum of weight x term(views). A weight of 0 switches a term off; all of them off is the score alone."""

    score: Objective[ErrorHistogram]
    """Any score of a histogram; take :class:`viewgain.gain.NearZero` within a :class:`viewgain.gain.Choice`, not the other way
    round: once a view is chosen, terms no longer change which."""
    terms: tuple[tuple[float, Objective[BoxViews]], ...] = ()
    """Weights, in units of the score, and terms."""

    @property
    def name(self) -> str:
        """The score's name and the terms that count."""
        return " + ".join([self.score.name, *(f"{weight:g} {term.name}" for weight, term in self.terms if weight)])

    def gains(self, known: ScannedBox) -> Vector:
        """Return the (V,) sums."""
        total = self.score.gains(known.histogram)
        for weight, term in self.terms:
            if weight:
                total = total + weight * term.gains(known.views)
        return total


def with_terms(score: Objective[ErrorHistogram], terms: Sequence[tuple[float, Objective[BoxViews]]]) -> Objective[ScannedBox]:
    """Return a score with terms; those of a choice go inside it, where they change which view is chosen.

    Args:
        score: Any score of a histogram, of :data:`viewgain.gain.HISTOGRAM_OBJECTIVES` or your own.
        terms: Weights, in units of the score (of a choice: of what it chooses by), and terms.
    """
    if isinstance(score, Choice):
        return Choice(with_terms(score.objective, terms), score.best, score.others)
    return WithTerms(score, tuple(terms))

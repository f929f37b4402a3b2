"""A histogram score together with the terms of a time-of-flight camera: the source paper's choice, with or without them."""

from dataclasses import dataclass

from viewgain.arrays import Vector
from viewgain.errors import ConfigError
from viewgain.gain._histogram import ErrorHistogram
from viewgain.gain._objective import Objective
from viewgain.gain._tof import BoxViews


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

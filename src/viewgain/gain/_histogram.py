"""How the relative volume error of every view is distributed: the source paper's second information gain, section 3.3."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array, Vector
from viewgain.errors import ConfigError
from viewgain.gain._bits import Counts


@dataclass(frozen=True, slots=True, kw_only=True)
class HistogramRule:
    """How errors are counted. The source paper gives neither bin width nor limit; the defaults are ours."""

    width: float = 0.05
    """Of a bin, relative volume error. One bin is centred on zero: it counts as "near zero"."""
    limit: float = 0.5
    """Errors beyond this, either way, share one bin on each side; expected errors are cut off here, and a miss costs as much."""
    tolerance: float = 0.05
    """Relative volume error that the user accepts."""

    def __post_init__(self) -> None:
        if not (0 < self.width <= 2 * self.limit < np.inf and 0 < self.tolerance < np.inf):
            raise ConfigError(
                f"histogram: got width {self.width}, limit {self.limit} and tolerance {self.tolerance}, wanted positive numbers"
                " and a width of at most twice the limit"
            )
        if self.limit / self.width > 10_000:
            raise ConfigError(f"histogram: {self.limit / self.width:.0f} bins on a side are too many; widen them")

    @property
    def edges(self) -> Vector:
        """(bins + 1,) edges: -inf, odd multiples of half the width as far as the limit reaches, inf. Symmetric about zero."""
        # A limit that is meant to be an edge must not lose it to rounding.
        steps = int(np.floor(self.limit / self.width - 0.5 + 1e-9))
        inner = (np.arange(-steps - 1, steps + 1) + 0.5) * self.width
        return np.concatenate([[-np.inf], inner, [np.inf]])

    @property
    def middle(self) -> int:
        """Index of the bin that is centred on zero."""
        return len(self.edges) // 2 - 1


@dataclass(frozen=True, slots=True, eq=False)
class ErrorHistogram:
    """The errors of n scans from each of V views, counted. Made by :meth:`from_errors`."""

    rule: HistogramRule
    """How they were counted."""
    errors: Array
    """(V, n) relative volume errors V / V* - 1; NaN for a scan without an estimate."""
    counts: Counts
    """(V, bins) scans whose error lies in each bin, low edge included."""
    missed: NDArray[np.int64]
    """(V,) scans without an estimate."""
    before: Vector | None = None
    """(n0,) errors of what is known already (the present view alone), NaN for none; None where nothing is."""

    @classmethod
    def from_errors(cls, errors: Array, rule: HistogramRule | None = None, *, before: Vector | None = None) -> "ErrorHistogram":
        """Count errors.

        Args:
            errors: (V, n) relative volume errors V / V* - 1, n >= 1; what is not finite means that the scan gave no estimate.
            rule: Bins and tolerance; default :class:`HistogramRule`.
            before: (n0,) errors of what is known already, for the entropy reduction; as ``errors``.

        Raises:
            ConfigError: If there is no view or no scan.
        """
        rule = rule or HistogramRule()
        errors = np.array(errors, dtype=float)
        if errors.ndim != 2 or 0 in errors.shape:
            raise ConfigError(f"error histogram: got errors of shape {errors.shape}, wanted (views, scans), one of each or more")
        if before is not None and (np.ndim(before) != 1 or not len(before)):
            raise ConfigError(f"error histogram: got errors before of shape {np.shape(before)}, wanted (n,) with n >= 1")
        errors[~np.isfinite(errors)] = np.nan
        counts = np.stack([bin_counts(row, rule.edges) for row in errors])
        known = None if before is None else np.where(np.isfinite(before), before, np.nan)
        return cls(rule, errors, counts, np.isnan(errors).sum(axis=1), known)

    @property
    def edges(self) -> Vector:
        """(bins + 1,) edges of the bins, the outermost infinite."""
        return self.rule.edges

    @property
    def scans(self) -> int:
        """Number of scans per view, n."""
        return int(self.errors.shape[1])


def bin_counts(errors: Vector, edges: Vector) -> Counts:
    """Return the (bins,) number of errors from each edge up to, not including, the next; NaN is in none."""
    places = np.searchsorted(edges, errors[~np.isnan(errors)], side="right") - 1
    return np.bincount(places, minlength=len(edges) - 1)

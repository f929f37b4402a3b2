"""Markdown tables and bootstrap intervals for the benchmarks."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from viewgain.evaluation import wilson as wilson


def markdown(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return a Markdown table whose columns line up."""
    cells = [list(header), *[[str(cell) for cell in row] for row in rows]]
    widths = [max(len(row[k]) for row in cells) for k in range(len(header))]
    lines = ["| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |" for row in cells]
    return "\n".join([lines[0], "|" + "|".join("-" * (width + 2) for width in widths) + "|", *lines[1:]])


def bootstrap(
    values: ArrayLike, statistic: Callable[..., float] = np.mean, *, seed: int = 0, draws: int = 2000
) -> tuple[float, float]:
    """Return the 95 % bootstrap interval of a statistic of ``values``."""
    values = np.asarray(values, dtype=float)
    rng = np.random.default_rng(seed)
    drawn = [statistic(values[rng.integers(len(values), size=len(values))]) for _ in range(draws)]
    low, high = np.quantile(drawn, [0.025, 0.975])
    return float(low), float(high)


def percent(value: float, digits: int = 2) -> str:
    """Return a share as per cent."""
    return f"{100 * value:.{digits}f} %"

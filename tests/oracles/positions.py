"""Slow twins of the judgement of positions: plain loops over plain numbers."""

import math
from collections.abc import Sequence

import numpy as np


def cost(error: float) -> float:
    """Return what one scan costs."""
    return 1.0 if math.isnan(error) or math.isinf(error) else min(abs(error), 1.0)


def mean_and_error(errors: Sequence[float]) -> tuple[float, float]:
    """Return the mean cost and its standard error."""
    spent = [cost(error) for error in errors]
    mean = sum(spent) / len(spent)
    variance = sum((each - mean) ** 2 for each in spent) / (len(spent) - 1)
    return mean, math.sqrt(variance / len(spent))


def best(errors: np.ndarray, allowed: Sequence[bool]) -> list[int]:
    """Return the positions that count as best."""
    found = {place: mean_and_error(errors[place].tolist()) for place in range(len(errors)) if allowed[place]}
    first = min(found, key=lambda place: (found[place][0], place))
    least, unsure = found[first]
    return [place for place, (mean, error) in found.items() if mean - least <= 2 * math.sqrt(error**2 + unsure**2)]


def constant(means: np.ndarray, box: int, shifts: Sequence[int]) -> int:
    """Return the constant answer for one box, chosen on all others; the best of those that the box allows."""
    views = means.shape[1]
    ranked = []
    for offset in range(views):
        if math.isnan(means[box, (offset + shifts[box]) % views]):
            continue
        others = [means[k, (offset + shifts[k]) % views] for k in range(len(means)) if k != box]
        known = [each for each in others if not math.isnan(each)]
        ranked.append((sum(known) / len(known) if known else math.inf, offset))
    return (min(ranked)[1] + shifts[box]) % views

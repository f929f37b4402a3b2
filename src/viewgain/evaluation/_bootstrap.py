"""Shares with intervals. Samples of one object are kin, so objects are drawn, not samples."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from viewgain.arrays import Array
from viewgain.errors import DataError

DRAWS = 2000
"""How often the objects are drawn anew."""


@dataclass(frozen=True, slots=True)
class Shares:
    """Means over all samples, one per column."""

    mean: tuple[float, ...]
    """(K,) share of the samples, or difference of two."""
    low: tuple[float, ...]
    """(K,) lower ends of the 95 % intervals."""
    high: tuple[float, ...]
    """(K,) upper ends."""


def shares_by_object(values: ArrayLike, objects: ArrayLike, *, rng: np.random.Generator, draws: int = DRAWS) -> Shares:
    """Return the means of (N, K) values with 95 % percentile intervals over objects drawn with repetition.

    Of a single object the interval has no width, which says nothing about other objects.

    Args:
        values: (N, K) hits, or chances of one.
        objects: (N,) number of each sample's object.
        rng: Draws.
        draws: How often.

    Raises:
        DataError: If there are no samples.
    """
    table = np.asarray(values, dtype=float)
    if len(table) == 0:
        raise DataError("evaluation: got no samples, wanted some")
    sums, counts = _per_object(table, np.asarray(objects))
    weights = drawn_weights(len(counts), rng, draws)
    drawn = (weights @ sums) / (weights @ counts)[:, None]
    low, high = np.quantile(drawn, [0.025, 0.975], axis=0)
    return Shares(tuple(table.mean(axis=0).tolist()), tuple(low.tolist()), tuple(high.tolist()))


def difference_by_object(
    first: ArrayLike, second: ArrayLike, objects: ArrayLike, *, rng: np.random.Generator, draws: int = DRAWS
) -> Shares:
    """Return mean and interval of ``first - second`` on the same samples (N, K): paired, so what is hard for both drops out.

    Raises:
        DataError: If there are no samples.
    """
    return shares_by_object(np.asarray(first, dtype=float) - np.asarray(second, dtype=float), objects, rng=rng, draws=draws)


def ratio_by_object(
    part: ArrayLike, whole: ArrayLike, objects: ArrayLike, *, rng: np.random.Generator, draws: int = DRAWS
) -> Shares | None:
    """Return sum of ``part`` / sum of ``whole`` on the same samples (N, K) with its interval, both drawn together.

    Returns:
        None if the whole of a column is 0. Draws in which it happens to be 0 are passed over.

    Raises:
        DataError: If there are no samples.
    """
    parts, wholes = np.asarray(part, dtype=float), np.asarray(whole, dtype=float)
    if len(parts) == 0:
        raise DataError("evaluation: got no samples, wanted some")
    if not np.all(wholes.sum(axis=0)):
        return None
    upper, counts = _per_object(parts, np.asarray(objects))
    lower, _ = _per_object(wholes, np.asarray(objects))
    weights = drawn_weights(len(counts), rng, draws)
    below = weights @ lower
    drawn = np.divide(weights @ upper, below, out=np.full_like(below, np.nan), where=below != 0)
    low, high = np.nanquantile(drawn, [0.025, 0.975], axis=0)
    return Shares(tuple((parts.sum(axis=0) / wholes.sum(axis=0)).tolist()), tuple(low.tolist()), tuple(high.tolist()))


def median_by_object(values: ArrayLike, *, rng: np.random.Generator, draws: int = DRAWS) -> Shares:
    """Return the median of one number per object, (N,), with its interval.

    Raises:
        DataError: If there are no samples.
    """
    numbers = np.asarray(values, dtype=float)
    if len(numbers) == 0:
        raise DataError("evaluation: got no samples, wanted some")
    drawn = np.median(numbers[rng.integers(len(numbers), size=(draws, len(numbers)))], axis=1)
    low, high = np.quantile(drawn, [0.025, 0.975])
    return Shares((float(np.median(numbers)),), (float(low),), (float(high),))


def quotient_of_groups(
    first: tuple[ArrayLike, ArrayLike], second: tuple[ArrayLike, ArrayLike], *, rng: np.random.Generator, draws: int = DRAWS
) -> Shares | None:
    """Return mean of the first / mean of the second group with its interval; the objects of each are drawn by themselves.

    Args:
        first: (N, K) values and (N,) numbers of their objects.
        second: (M, K) values and (M,) numbers of theirs.
        rng: Draws.
        draws: How often.

    Returns:
        None if the second mean of a column is 0. Draws in which it happens to be 0 are passed over.

    Raises:
        DataError: If a group has no samples.
    """
    means, drawn = [], []
    for values, objects in (first, second):
        table = np.asarray(values, dtype=float)
        if len(table) == 0:
            raise DataError("evaluation: got no samples, wanted some")
        sums, counts = _per_object(table, np.asarray(objects))
        weights = drawn_weights(len(counts), rng, draws)
        means.append(table.mean(axis=0))
        drawn.append((weights @ sums) / (weights @ counts)[:, None])
    if not np.all(means[1]):
        return None
    quotients = np.divide(drawn[0], drawn[1], out=np.full_like(drawn[0], np.nan), where=drawn[1] != 0)
    low, high = np.nanquantile(quotients, [0.025, 0.975], axis=0)
    return Shares(tuple((means[0] / means[1]).tolist()), tuple(low.tolist()), tuple(high.tolist()))


def drawn_weights(objects: int, rng: np.random.Generator, draws: int) -> Array:
    """Return (draws, O) how often each object is drawn."""
    return rng.multinomial(objects, np.full(objects, 1 / objects), size=draws).astype(float)


def _per_object(values: Array, objects: NDArray[np.generic]) -> tuple[Array, Array]:
    """Return (O, K) sums and (O,) numbers of samples."""
    numbers, place = np.unique(objects, return_inverse=True)
    sums = np.zeros((len(numbers), values.shape[1]))
    np.add.at(sums, place, values)
    return sums, np.bincount(place).astype(float)

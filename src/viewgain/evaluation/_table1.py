"""The paper's Table 1: how often the best view is chosen, or one nearly as good; beside floors and with intervals."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from viewgain.arrays import Array
from viewgain.datasets import Dataset, Frame, rig_of
from viewgain.evaluation._bootstrap import difference_by_object, quotient_of_groups, ratio_by_object, shares_by_object
from viewgain.evaluation._constant import Constant, constant_answer
from viewgain.evaluation._families import Family, compared, families
from viewgain.evaluation._judged import Judged, read_judged
from viewgain.evaluation._parts import Part
from viewgain.evaluation._records import CONSTANT, ORACLE, RANDOM, UNIFORM, Difference, Kept, Row, Table1
from viewgain.evaluation._scored import scored
from viewgain.gain import choices, hits, shortfall, uniform_hits
from viewgain.inference import Scorer

_INTERVALS, _HALVES, _RANDOM = 0x7431, 0x7432, 0x7433
"""Streams under the seed."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Judgement:
    """A table, and what it was made from."""

    table: Table1
    hits: Mapping[str, Array]
    """(N, 5) of each family."""
    objects: NDArray[np.int64]
    """(N,) number of each sample's object."""


def table1(
    data: Dataset,
    scorers: Mapping[str, Scorer],
    part: Part,
    *,
    target: str = "gain_published",
    frame: Frame | None = None,
    seed: int = 0,
    seen: Judgement | None = None,
) -> Judgement:
    """Return the table of one part of a data set, with what it was made from.

    Everyone chooses among the views that were not visited yet; ties are counted as :func:`viewgain.gain.hits` says.

    Args:
        data: Clouds and what each view adds.
        scorers: Networks by name, each opened with one thread; none for the floors alone.
        part: Which samples.
        target: Which scores of the data set count.
        frame: Frame that the points are brought into; None for the data's own.
        seed: Of intervals, halves and random choices.
        seen: What the same networks did on seen categories, to hold this part against; None for nothing.

    Raises:
        ConfigError: If there is no such target, or a network is of another rig or frame.
    """
    judged, learned = read_judged(data, part.rows, target), read_judged(data, part.learned, target)
    results, times = _network_hits(data, judged, scorers, frame)
    found = families({name: scorer.card for name, scorer in scorers.items()})
    means = {each.name: np.mean([results[name] for name in each.members], axis=0) for each in found}
    times |= {each.name: float(np.mean([times[name] for name in each.members])) for each in found}
    constant = constant_answer(judged, learned, rng=np.random.default_rng([seed, _HALVES]))
    floors = _floor_hits(judged, constant, np.random.default_rng([seed, _RANDOM]))
    rng = np.random.default_rng([seed, _INTERVALS])
    counts = {each.name: len(each.members) for each in found}
    within = {name: each.name for each in found for name in each.members if len(each.members) > 1}
    rows = tuple(
        Row(
            name=name,
            shares=shares_by_object(each, judged.objects, rng=rng),
            seeds=counts.get(name, 1),
            within=within.get(name),
            milliseconds=times.get(name),
        )
        for name, each in (results | means | floors).items()
    )
    table = Table1(
        data=str(data.manifest.recipe["name"]),
        split=part.name,
        title=part.title,
        rig=rig_of(data.manifest),
        views=judged.gains.shape[1],
        frame=frame or data.manifest.frame,
        target=target,
        samples=len(judged.rows),
        objects=len(np.unique(judged.objects)),
        skipped=data.manifest.skipped,
        constant_chosen=constant.chosen if constant else None,
        constant_samples=constant.samples if constant else 0,
        offsets=constant.offsets if constant else (),
        rows=rows,
        differences=_differences(means | floors, found, judged.objects, rng),
        kept=() if seen is None else _kept(means, judged.objects, seen, rng),
    )
    return Judgement(table=table, hits=means, objects=judged.objects)


def _kept(means: Mapping[str, Array], objects: NDArray[np.int64], seen: Judgement, rng: np.random.Generator) -> tuple[Kept, ...]:
    """Return the share of each family's figures that is left; families of which nothing was right there are left out."""
    found = {
        name: quotient_of_groups((each, objects), (seen.hits[name], seen.objects), rng=rng)
        for name, each in means.items()
        if name in seen.hits
    }
    return tuple(Kept(name=name, shares=shares) for name, shares in found.items() if shares is not None)


def _differences(
    results: Mapping[str, Array], found: tuple[Family, ...], objects: NDArray[np.int64], rng: np.random.Generator
) -> tuple[Difference, ...]:
    """Return each family against the constant answer, then against each other by :func:`compared`."""
    floor = results.get(CONSTANT)
    against_floor = () if floor is None else tuple(
        Difference(
            first=each.name,
            second=CONSTANT,
            shares=difference_by_object(results[each.name], floor, objects, rng=rng),
            closed=ratio_by_object(results[each.name] - floor, 1 - floor, objects, rng=rng),
        )
        for each in found
    )  # fmt: skip
    return against_floor + tuple(
        Difference(
            first=one,
            second=two,
            shares=difference_by_object(results[one], results[two], objects, rng=rng),
            share=ratio_by_object(results[one], results[two], objects, rng=rng),
        )
        for one, two in compared(found)
    )


def _network_hits(
    data: Dataset, judged: Judged, scorers: Mapping[str, Scorer], frame: Frame | None
) -> tuple[dict[str, Array], dict[str, float]]:
    """Return (N, 5) hits and the median milliseconds of each network."""
    results, times = {}, {}
    for name, scorer in scorers.items():
        answer = scored(data, judged.rows, scorer, frame=frame)
        chosen = choices(answer.scores, judged.free)
        results[name] = hits(shortfall(judged.gains, chosen, judged.free)).astype(float)
        times[name] = float(np.median(answer.milliseconds))
    return results, times


def _floor_hits(judged: Judged, constant: Constant | None, rng: np.random.Generator) -> dict[str, Array]:
    """Return (N, 5) hits, or chances of one, of what has learned nothing; and of the best view, which is what all are held to."""
    gains, free = judged.gains, judged.free
    drawn, best = choices(rng.random(gains.shape), free), choices(gains, free)
    floors = {UNIFORM: uniform_hits(gains, free), RANDOM: hits(shortfall(gains, drawn, free)).astype(float)}
    if constant is not None:
        floors[CONSTANT] = constant.hits
    return {**floors, ORACLE: hits(shortfall(gains, best, free)).astype(float)}

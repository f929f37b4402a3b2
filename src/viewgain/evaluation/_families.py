"""Which networks differ by their seed alone, and which are the same with and without the view state."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from viewgain.inference import ModelCard

WITHOUT_AND_WITH = (("pc_nbv_noview", "pc_nbv"), ("compact", "compact_view"))
"""Kinds that differ by the view state alone: without it, with it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Family:
    """Networks of one training recipe and several seeds, or a single one."""

    name: str
    """What it is called: of a single network, that one's name."""
    members: tuple[str, ...]
    """The networks."""
    card: ModelCard
    """Of the first."""


def families(cards: Mapping[str, ModelCard]) -> tuple[Family, ...]:
    """Return networks by family, in the order of their first members.

    Of one family are those of the same kind and training recipe that agree in all of :func:`_terms`, if each of them states a
    seed of its own.

    Args:
        cards: By the networks' names.
    """
    groups: dict[tuple[str, ...], list[str]] = {}
    for name, card in cards.items():
        groups.setdefault(_key(card), []).append(name)
    found: list[Family] = []
    for members in groups.values():
        seeds = [cards[name].training.get("seed") for name in members]
        if len(members) > 1 and None not in seeds and len(set(seeds)) == len(seeds):
            found.append(Family(name=_called(cards[members[0]], len(members)), members=tuple(members), card=cards[members[0]]))
        else:
            found += [Family(name=name, members=(name,), card=cards[name]) for name in members]
    return _named_apart(found)


def without_and_with(found: Sequence[Family]) -> tuple[tuple[Family, Family], ...]:
    """Return the pairs of families that differ by the view state alone, the one without it first; see :func:`_terms`."""
    return tuple(
        (one, two)
        for one in found
        for two in found
        if (one.card.kind, two.card.kind) in WITHOUT_AND_WITH and _terms(one.card) == _terms(two.card)
    )


def compared(found: Sequence[Family]) -> list[tuple[str, str]]:
    """Return who is held against whom, no two of them twice.

    Those of :func:`without_and_with`; then each against the first that is told as much, the view state or not. The first that is
    told it, or is not, stands against the first of all.
    """
    pairs = [(one.name, two.name) for one, two in without_and_with(found)]
    for place, each in enumerate(found[1:], start=1):
        earlier = [other for other in found[:place] if other.card.with_view_state == each.card.with_view_state]
        pair = (each.name, (earlier or found)[0].name)
        if pair not in pairs and pair[::-1] not in pairs:
            pairs.append(pair)
    return pairs


def _key(card: ModelCard) -> tuple[str, ...]:
    return (card.kind, card.training.get("recipe", ""), *_terms(card))


def _terms(card: ModelCard) -> tuple[str, ...]:
    """Return what networks must agree in to be held against each other: else more than seed or view state tells them apart.

    Rig, frame, points and how they are normalised, planned steps, data by its plan where that is stated, target and teacher.
    """
    told = card.training
    planned, data = told.get("steps", "").partition(" of ")[2], told.get("data", "")
    plan = data.partition(", plan ")[2] or data  # older cards do not note the seed, which the plan is made from
    shared = card.rig, card.frame, str(card.points), card.normalisation, planned, plan
    return *shared, told.get("target", ""), told.get("teacher", "")


def _called(card: ModelCard, count: int) -> str:
    return f"{card.training.get('recipe') or card.kind}, mean of {count} seeds"


def _named_apart(found: Sequence[Family]) -> tuple[Family, ...]:
    """Return the families with a number after a name that an earlier one has."""
    taken: set[str] = set()
    apart = []
    for family in found:
        name, number = family.name, 2
        while name in taken:
            name, number = f"{family.name} ({number})", number + 1
        taken.add(name)
        apart.append(Family(name=name, members=family.members, card=family.card))
    return tuple(apart)

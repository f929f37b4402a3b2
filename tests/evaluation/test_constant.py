"""The constant answer: chosen on what trains, or on the other half of the objects."""

import numpy as np

from viewgain.evaluation import Judged, constant_answer


def judged(best: list[int], objects: list[int]) -> Judged:
    """Return samples in which one view is worth 0.5 and the others nothing."""
    gains = np.zeros((len(best), 5))
    gains[np.arange(len(best)), best] = 0.5
    free = np.ones_like(gains, dtype=bool)
    free[:, 0] = False
    return Judged(np.arange(len(best)), np.array(objects), gains, free)


NONE = Judged(np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.int64), np.zeros((0, 5)), np.zeros((0, 5), dtype=bool))


def test_where_there_are_training_samples_they_decide() -> None:
    found = constant_answer(judged([1, 1, 2], [0, 1, 2]), judged([2, 2, 1], [7, 8, 9]), rng=np.random.default_rng(0))
    assert found is not None
    assert (found.chosen, found.offsets, found.samples) == ("training", (2,), 3)
    assert found.hits[:, 0].tolist() == [0.0, 0.0, 1.0]


def test_without_any_each_half_of_the_objects_is_judged_by_the_other() -> None:
    """Two objects that want different views: each is given the other's, so both are wrong throughout."""
    found = constant_answer(judged([1, 1, 3, 3, 3], [4, 4, 9, 9, 9]), NONE, rng=np.random.default_rng(0))
    assert found is not None
    assert found.chosen == "two_fold"
    assert sorted(found.offsets) == [1, 3]
    assert not found.hits[:, 0].any()
    same = constant_answer(judged([2] * 6, [0, 0, 1, 1, 2, 2]), NONE, rng=np.random.default_rng(0))
    assert same is not None
    assert same.offsets == (2, 2)
    assert same.hits.all()


def test_a_single_object_has_no_other_half() -> None:
    assert constant_answer(judged([1, 1], [3, 3]), NONE, rng=np.random.default_rng(0)) is None

"""Tensors, batches, and an order that can be left and taken up again."""

import pickle

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch.utils.data import DataLoader

from viewgain.datasets import Augmentation, Dataset, ShuffledOrder, TorchDataset, collated
from viewgain.errors import ConfigError
from viewgain.geometry import inverse, transform


@given(st.integers(1, 30), st.integers(0, 2**31), st.integers(0, 100))
def test_each_epoch_has_every_sample_once_and_can_be_resumed_anywhere(count: int, seed: int, consumed: int) -> None:
    order = ShuffledOrder(count, seed=seed)
    whole = [place for epoch in range(consumed // count + 1) for place in order.after(epoch * count)]
    for epoch in range(consumed // count + 1):
        places = whole[epoch * count : (epoch + 1) * count]
        assert sorted(place % count for place in places) == list(range(count))
        assert {place // count for place in places} == {epoch}
    rest = order.after(consumed)
    assert list(rest) == whole[consumed : (consumed // count + 1) * count]
    assert len(rest) == len(list(rest))


def test_epochs_and_seeds_differ() -> None:
    order = ShuffledOrder(50, seed=1)
    assert order.epoch(0).tolist() != order.epoch(1).tolist() != ShuffledOrder(50, seed=2).epoch(1).tolist()
    for count, consumed in ((0, 0), (5, -1)):
        with pytest.raises(ConfigError):
            ShuffledOrder(count, consumed=consumed)


def test_what_a_place_holds_depends_on_no_worker_and_no_history(random_boxes: Dataset) -> None:
    data = TorchDataset(random_boxes, points=64, augmentation=Augmentation(turn_deg=90, jitter=0.01, dropout=0.3), seed=3)
    order = ShuffledOrder(len(data), seed=5)
    alone = {place: data[place] for place in order}
    sent = pickle.loads(pickle.dumps(data))  # what a worker process gets
    for place in list(order)[::-1]:
        for name, tensor in sent[place].items():
            torch.testing.assert_close(tensor, alone[place][name], rtol=0, atol=0)
    again = {place: data[place] for place in order.after(len(data))}
    assert any(not torch.equal(again[place]["points"], alone[place % len(data)]["points"]) for place in again)


def test_batches_pad_what_varies_and_say_so(random_boxes: Dataset) -> None:
    data = TorchDataset(random_boxes, points=0)
    (batch,) = DataLoader(data, batch_size=len(data), sampler=ShuffledOrder(len(data)), collate_fn=collated)
    counts = [len(random_boxes[int(index)].candidates) for index in batch["index"]]
    assert len(set(counts)) > 1
    assert batch["candidates_mask"].sum(dim=1).tolist() == counts
    assert batch["candidates"].shape == (len(data), max(counts), 4, 4)
    for row, index in enumerate(batch["index"].tolist()):
        sample = random_boxes[index]
        np.testing.assert_array_equal(batch["points"][row][batch["points_mask"][row]], sample.points)
        assert not batch["candidates"][row][~batch["candidates_mask"][row]].any()


def test_targets_come_with_the_present_view_first(coverage: Dataset) -> None:
    data = TorchDataset(coverage, indices=coverage.part("same_category", "train"), points=32)
    row = data[0]
    sample = coverage[int(row["index"])]
    assert row["points"].shape == (32, 3)
    np.testing.assert_array_equal(row["target_gain_union"], sample.targets["gain_union"])
    assert row["target_gain_union"].dtype == torch.float32


@pytest.mark.parametrize("kind", ["random_boxes", "coverage"])
def test_a_turn_changes_no_answer(kind: str, request: pytest.FixtureRequest) -> None:
    """Where the points lie on the object, and where the candidates stand about it, is the same before and after."""
    data: Dataset = request.getfixturevalue(kind)
    sample = data[3]
    turned = Augmentation(turn_deg=180).apply(sample, rng=np.random.default_rng(1))
    assert not np.allclose(turned.points, sample.points)
    for one, two in ((sample, turned),):
        a, b = (inverse(each.object_to_camera.astype(float)) @ each.candidates for each in (one, two))
        if kind == "random_boxes":
            np.testing.assert_allclose(a, b, atol=1e-5)
            places = [transform(inverse(each.object_to_camera.astype(float)), each.points.astype(float)) for each in (one, two)]
            np.testing.assert_allclose(*places, atol=1e-5)
        else:
            np.testing.assert_allclose(one.in_frame("camera").points, two.in_frame("camera").points, atol=1e-5)
            np.testing.assert_array_equal(one.candidates, two.candidates)


def test_noise_and_dropout_are_what_they_say(boxes: Dataset) -> None:
    sample, rng = boxes[0], np.random.default_rng(0)
    noisy = Augmentation(jitter=0.02).apply(sample, rng=rng)
    assert np.std(noisy.points - sample.points) == pytest.approx(0.02, rel=0.1)
    shares = [len(Augmentation(dropout=0.5).apply(sample, rng=rng).points) / len(sample.points) for _ in range(200)]
    assert min(shares) >= 0.45
    assert np.mean(shares) == pytest.approx(0.75, abs=0.04)
    for wrong in ({"turn_deg": -1}, {"jitter": -1}, {"dropout": 1.0}):
        with pytest.raises(ConfigError):
            Augmentation(**wrong)

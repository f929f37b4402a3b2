import numpy as np
import pytest
import torch

from viewgain.datasets import Dataset
from viewgain.errors import ConfigError, DataError
from viewgain.training import Batches, DataSettings, Examples, held_out, in_order, load_examples, present_first, symmetries
from viewgain.training._symmetry import LOST

PLAIN = DataSettings(rig="pcnbv16", resident=64)


@pytest.fixture(scope="module")
def examples(data: Dataset) -> Examples:
    return load_examples(data, PLAIN, views=16, seed=0)


def batches(examples: Examples, settings: DataSettings = PLAIN, *, uses_state: bool = False, points: int = 20) -> Batches:
    turned = symmetries(examples.poses, "object", vacant=settings.vacant) if settings.symmetry else None
    rows = np.arange(len(examples))
    return Batches(
        examples, settings, rows=rows, batch=8, points=points, uses_state=uses_state, seed=3, symmetries=turned
    )  # fmt: skip


def test_what_is_held_is_what_the_data_set_says(data: Dataset, examples: Examples) -> None:
    for row in (0, 5, 31):
        sample = data[row]
        count = int(examples.counts[row])
        assert count == min(64, len(sample.points))
        stored = {tuple(point) for point in sample.points.astype(np.float16)}
        assert all(tuple(point) in stored for point in examples.points[row, :count].numpy())
        assert not examples.points[row, count:].any()
        np.testing.assert_array_equal(present_first(examples.targets, examples.views)[row], sample.targets["gain_published"])
        np.testing.assert_array_equal(np.roll(examples.states[row].numpy(), -sample.view), sample.state)


def test_an_epoch_shows_every_sample_once_and_the_next_in_another_order(examples: Examples) -> None:
    source = batches(examples, uses_state=True)
    seen = torch.cat([source.at(step).targets for step in range(4)])
    again = torch.cat([source.at(step).targets for step in range(4, 8)])
    wanted = sorted(map(tuple, examples.targets.tolist()))
    assert sorted(map(tuple, seen.tolist())) == wanted
    assert sorted(map(tuple, again.tolist())) == wanted
    assert not torch.equal(seen, again)


def test_a_batch_depends_on_seed_and_step_alone(examples: Examples) -> None:
    first, second = batches(examples).at(5), batches(examples)
    second.at(0)
    assert torch.equal(first.points, second.at(5).points)
    assert not torch.equal(first.points, second.at(6).points)


def test_the_parts_of_two_processes_make_the_batch(examples: Examples) -> None:
    source = batches(examples, DataSettings(symmetry=True, jitter=0.01, dropout=0.5, resident=64))
    whole, even, odd = source.at(2), source.at(2, part=slice(0, None, 2)), source.at(2, part=slice(1, None, 2))
    for name in ("points", "mask", "targets"):
        assert torch.equal(getattr(whole, name)[0::2], getattr(even, name))
        assert torch.equal(getattr(whole, name)[1::2], getattr(odd, name))


@pytest.mark.parametrize("uses_state", [False, True])
def test_of_a_place_left_vacant_nothing_is_learned_and_all_other_scores_move_with_their_views(
    examples: Examples, uses_state: bool
) -> None:
    whole, moving = DataSettings(resident=64), DataSettings(symmetry=True, vacant=1, resident=64)
    motions = symmetries(examples.poses, "object", vacant=1)
    vacant = 0
    for step in range(4):
        plain = batches(examples, whole, uses_state=True, points=64).at(step)
        moved = batches(examples, moving, uses_state=uses_state, points=64).at(step)
        assert moved.valid is not None
        vacant += int((~moved.valid).sum())
        for row in range(8):
            valid, targets = moved.valid[row], moved.targets[row]
            if not uses_state:
                valid, targets = (each.roll(int(moved.views[row])) for each in (valid, targets))
            # The cloud says by which motion it was moved: the points are the same, whatever their order.
            order = torch.argsort(plain.points[row, :, 2]), torch.argsort(moved.points[row, :, 2])
            before, after = plain.points[row][order[0]], moved.points[row][order[1]]
            apart = [float((before @ torch.from_numpy(each[0]).float().T - after).abs().max()) for each in motions.maps]
            carried = motions.carried[int(np.argmin(apart))]
            assert moved.views[row] == carried[plain.views[row]] != LOST
            for view, place in enumerate(carried.tolist()):
                if place != LOST:
                    assert valid[place]
                    assert targets[place] == plain.targets[row, view]
            assert valid.sum() == (carried != LOST).sum()
    assert vacant > 8


def test_points_are_drawn_without_repetition_and_anew(examples: Examples) -> None:
    source = batches(examples)
    first, other = source.at(0), source.at(4)
    for cloud, mask in zip(first.points, first.mask, strict=True):
        assert mask.all()  # every cloud of this data set has more than 20 points
        held = {tuple(point) for row in examples.points.float() for point in row.tolist()}
        assert {tuple(point) for point in cloud.tolist()} <= held
    assert not torch.equal(first.points.sort(1).values, other.points.sort(1).values)


def test_a_cloud_of_few_points_is_masked(examples: Examples) -> None:
    few = Examples(
        points=examples.points,
        counts=torch.full_like(examples.counts, 7),
        views=examples.views,
        states=examples.states,
        targets=examples.targets,
        objects=examples.objects,
        poses=examples.poses,
    )
    batch = batches(few).at(0)
    assert (batch.mask.sum(1) == 7).all()
    assert not batch.points[~batch.mask].any()


def test_noise_and_hidden_points_leave_the_scores_alone(examples: Examples) -> None:
    plain, disturbed = batches(examples).at(1), batches(examples, DataSettings(jitter=0.01, dropout=0.9, resident=64)).at(1)
    assert torch.equal(plain.targets, disturbed.targets)
    assert disturbed.mask.any(1).all()
    assert disturbed.mask.sum() < plain.mask.sum()
    moved = (disturbed.points - plain.points)[disturbed.mask]
    assert 0.007 < float(moved.std()) < 0.013


def test_validation_batches_are_all_rows_in_order_always_the_same(examples: Examples) -> None:
    rows = np.array([4, 9, 2, 30, 11])
    for _ in range(2):
        found = list(in_order(examples, rows, batch=2, points=20, uses_state=True))
        assert np.concatenate([chosen for chosen, _ in found]).tolist() == rows.tolist()
        assert torch.equal(torch.cat([batch.points for _, batch in found]), examples.points[rows, :20].float())


def test_whole_objects_are_held_out() -> None:
    objects = np.repeat(np.arange(10), 5)
    aside = held_out(objects, 0.3, seed=0)
    assert len(np.unique(objects[aside])) == 3
    assert not set(objects[aside]) & set(objects[~aside])
    assert not np.array_equal(aside, held_out(objects, 0.3, seed=1))
    with pytest.raises(DataError, match="1 object"):
        held_out(np.zeros(4, dtype=np.int64), 0.3, seed=0)


@pytest.mark.parametrize(
    ("settings", "views", "word"),
    [
        (DataSettings(rig="pcnbv33"), 33, "pcnbv16"),
        (DataSettings(), 33, "16 views"),
        (DataSettings(target="beauty"), 16, "gain_union"),
    ],
)
def test_data_of_another_kind_is_refused(data: Dataset, settings: DataSettings, views: int, word: str) -> None:
    with pytest.raises(DataError, match=word):
        load_examples(data, settings, views=views, seed=0)


def test_only_what_trains_in_every_division_is_learned_from(data: Dataset) -> None:
    chosen = load_examples(data, DataSettings(divisions=("other_category",)), views=16, seed=0)
    assert 0 < len(chosen) < len(data)
    with pytest.raises(ConfigError, match="division"):
        load_examples(data, DataSettings(divisions=("nonsense",)), views=16, seed=0)


def test_points_are_shown_in_the_frame_that_is_asked_for(data: Dataset) -> None:
    """The same draws, moved: an object's centre lies one unit before every camera of the rig."""
    seen, own = (load_examples(data, DataSettings(frame=frame), views=16, seed=0) for frame in ("camera", "object"))
    assert torch.equal(seen.counts, own.counts)
    assert torch.equal(seen.targets, own.targets)
    to_camera = torch.from_numpy(np.linalg.inv(own.poses)).float()[own.views]
    moved = own.points.float() @ to_camera[:, :3, :3].transpose(1, 2) + to_camera[:, None, :3, 3]
    real = torch.arange(own.points.shape[1])[None] < own.counts[:, None]
    assert (seen.points.float() - moved)[real].abs().max() < 2e-3  # half floats about a distance of 1
    assert seen.points[real][:, 2].min() > 0.4

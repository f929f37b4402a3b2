"""The networks: their size, their slow twins, and the laws of points, clouds and padding."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from torch import Tensor

from tests.oracles import network as oracle
from viewgain.errors import ConfigError
from viewgain.network import Kind, NetworkSettings, ScoreNetwork, build, parameters_of, scores_of, sigma_of, stations_of
from viewgain.network._compact import mean_present_first
from viewgain.network._neighbours import DIRECTION, in_order
from viewgain.rigs import Target, poses, rig

KINDS = tuple(kind for kind in get_args(Kind) if kind != "pose_scores")  # that one: test_pose_scores.py


@pytest.fixture(autouse=True)
def _one_thread() -> None:
    torch.set_num_threads(1)


def seeded(seed: int) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def small(kind: Kind, *, seed: int = 0, uncertainty: str = "none", views: int = 5, rig: str = "") -> ScoreNetwork:
    """A narrow network in double precision whose attention is at work."""
    settings = NetworkSettings(
        kind=kind, views=views, neighbours=6, growth=4, shared=(24, 20), head=(16, 12), width=8, uncertainty=uncertainty, rig=rig
    )  # fmt: skip
    network = build(settings, generator=seeded(seed)).double()
    with torch.no_grad():
        for name, parameter in network.named_parameters():
            if name.endswith("bias"):
                parameter.uniform_(-0.3, 0.3, generator=seeded(seed + 1))
            if name.endswith("gamma"):
                parameter.fill_(0.7)
    return network


def cloud(number: int, *, seed: int = 0, batch: int = 1) -> Tensor:
    return torch.rand(batch, number, 3, generator=seeded(seed), dtype=torch.double) - 0.5


def state_for(network: ScoreNetwork, batch: int, *, seed: int = 0) -> Tensor | None:
    if not network.settings.with_view_state:
        return None
    return (torch.rand(batch, network.settings.views, generator=seeded(seed)) < 0.4).double()


@pytest.mark.parametrize(
    ("kind", "views", "parameters"),
    [("pc_nbv", 33, 3828956), ("pc_nbv_noview", 33, 3741490), ("pc_nbv", 16, 3779257), ("pc_nbv_noview", 16, 3737121)],
)
def test_the_paper_size_networks_have_about_3_7_million_parameters(kind: Kind, views: int, parameters: int) -> None:
    """Counted by hand: lift 96, edges 6,480, between them 10,440, attention, 1024-1024, 1024-512-256-V."""
    width = 528 + (views if kind == "pc_nbv" else 0)
    quarter = width // 4
    attention = 2 * (width + 1) * quarter + (width + 1) * width + 1
    shared = (width + 1) * 1024 + 1025 * 1024
    head = 1025 * 1024 + 1025 * 512 + 513 * 256 + 257 * views
    assert 96 + 4 * (49 + 37 + 49) * 12 + (85 + 145 + 205) * 24 + attention + shared + head == parameters
    network = build(NetworkSettings(kind=kind, views=views), generator=seeded(0))
    assert parameters_of(network) == parameters
    assert network.features.channels == 264


@pytest.mark.parametrize("kind", KINDS)
def test_offset_and_scale_are_taken_off_the_points_and_change_nothing_else(kind: Kind) -> None:
    plain = small(kind)
    moved = build(replace(plain.settings, offset=(0.3, -0.2, 2.0), scale=0.25)).double()
    moved.load_state_dict(plain.state_dict())
    points, state = cloud(30, batch=2), state_for(plain, 2)
    mask = torch.arange(30)[None] < torch.tensor([[30], [21]])
    far = 0.25 * points + points.new_tensor([0.3, -0.2, 2.0])
    torch.testing.assert_close(moved(far, mask, state), plain(points, mask, state), rtol=0, atol=1e-9)
    assert (moved(points, mask, state) - plain(points, mask, state)).abs().max() > 1e-3


def test_the_compact_networks_are_a_quarter_of_the_size() -> None:
    assert parameters_of(build(NetworkSettings(kind="compact"), generator=seeded(0))) < 3_741_490 / 4


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("number", [1, 2, 5, 7, 40])
def test_the_fast_network_equals_its_textbook_twin_forward_and_gradient(kind: Kind, number: int) -> None:
    assert_equals_its_twin(small(kind), number)


@pytest.mark.parametrize("kind", ["compact", "compact_view"])
@pytest.mark.parametrize("number", [1, 30])
def test_views_that_look_see_what_the_textbook_sees(kind: Kind, number: int) -> None:
    assert_equals_its_twin(small(kind, views=16, rig="pcnbv16"), number)


def assert_equals_its_twin(network: ScoreNetwork, number: int) -> None:
    points, kind = cloud(number, seed=number), network.settings.kind
    state = state_for(network, 1)
    slow = oracle.pc_nbv if kind.startswith("pc_nbv") else oracle.compact
    weights = torch.rand(network.settings.views, generator=seeded(3), dtype=torch.double)
    results = []
    for forward in (
        lambda: network(points, None, state)[0],
        lambda: slow(network, points[0], None if state is None else state[0]),
    ):
        network.zero_grad()
        output = forward()
        (output * weights).sum().backward()
        results.append((output.detach().clone(), {n: p.grad.clone() for n, p in network.named_parameters()}))
    (fast, fast_gradient), (textbook, textbook_gradient) = results
    torch.testing.assert_close(fast, textbook, rtol=0, atol=1e-12)
    for name, gradient in fast_gradient.items():
        torch.testing.assert_close(gradient, textbook_gradient[name], rtol=0, atol=1e-11, msg=name)


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=10)
@given(number=st.integers(2, 30), seed=st.integers(0, 1000))
def test_the_order_of_points_changes_nothing(kind: Kind, number: int, seed: int) -> None:
    network, points = small(kind), cloud(number, seed=seed)
    order, state = torch.randperm(number, generator=seeded(seed)), state_for(network, 1, seed=seed)
    torch.testing.assert_close(network(points[:, order], None, state), network(points, None, state), rtol=0, atol=1e-11)


@pytest.mark.parametrize("kind", KINDS)
def test_clouds_of_a_batch_do_not_know_each_other(kind: Kind) -> None:
    network, points = small(kind), cloud(20, batch=4)
    state = state_for(network, 4)
    together = network(points, None, state)
    alone = [network(points[i : i + 1], None, None if state is None else state[i : i + 1]) for i in range(4)]
    torch.testing.assert_close(together, torch.cat(alone), rtol=0, atol=1e-12)
    assert (together[0] - together[1]).abs().max() > 1e-6  # else the above says nothing


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=10)
@given(number=st.integers(1, 25), padding=st.integers(1, 20), seed=st.integers(0, 1000))
def test_padding_changes_nothing(kind: Kind, number: int, padding: int, seed: int) -> None:
    network, points = small(kind), cloud(number, seed=seed)
    state = state_for(network, 1, seed=seed)
    filled = torch.cat((points, 100 * cloud(padding, seed=seed + 1)), dim=1)
    mask = torch.arange(number + padding)[None] < number
    torch.testing.assert_close(network(filled, mask, state), network(points, None, state), rtol=0, atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_padding_gets_no_gradient(kind: Kind) -> None:
    network, points = small(kind), cloud(30).requires_grad_()
    mask = torch.arange(30)[None] < 18
    network(points, mask, state_for(network, 1)).sum().backward()
    assert points.grad[:, 18:].abs().max() == 0
    assert points.grad[:, :18].abs().max() > 0


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=10)
@given(number=st.integers(1, 20), seed=st.integers(0, 1000))
def test_a_repeated_point_counts_once(kind: Kind, number: int, seed: int) -> None:
    network, points = small(kind), cloud(number, seed=seed)
    again = torch.randint(number, (15,), generator=seeded(seed))
    state = state_for(network, 1, seed=seed)
    filled = torch.cat((points, points[:, again]), dim=1)
    torch.testing.assert_close(network(filled, None, state), network(points, None, state), rtol=0, atol=1e-11)


@pytest.mark.parametrize("kind", ["pc_nbv", "compact_view"])
def test_the_view_state_counts(kind: Kind) -> None:
    network, points = small(kind), cloud(20)
    states = torch.eye(5, dtype=torch.double)
    outputs = torch.cat([network(points, None, state[None]) for state in states])
    assert torch.cdist(outputs, outputs).fill_diagonal_(1.0).min() > 1e-6


def test_the_same_generator_builds_the_same_network_and_the_global_one_stays() -> None:
    settings = NetworkSettings(kind="compact", views=4, width=8)
    before = torch.get_rng_state()
    first, second = (build(settings, generator=seeded(5)) for _ in range(2))
    assert torch.equal(before, torch.get_rng_state())
    for one, other in zip(first.parameters(), second.parameters(), strict=True):
        assert torch.equal(one, other)
    assert any(not torch.equal(a, b) for a, b in zip(first.parameters(), build(settings).parameters(), strict=True))


@pytest.mark.parametrize(("uncertainty", "numbers"), [("gaussian", 2), ("evidential", 4)])
@pytest.mark.parametrize("kind", KINDS)
def test_uncertainty_gives_a_positive_number_per_view_and_leaves_the_shape_of_scores(
    kind: Kind, uncertainty: str, numbers: int
) -> None:
    network, points = small(kind, uncertainty=uncertainty), cloud(20, batch=3)
    output = network(points, None, state_for(network, 3))
    assert output.shape == (3, 5, numbers)
    assert scores_of(output).shape == (3, 5)
    assert sigma_of(output).min() > 0
    plain = small(kind)(points, None, state_for(network, 3))
    assert scores_of(plain) is plain
    assert sigma_of(plain) is None


def test_what_does_not_fit_is_refused_in_one_line() -> None:
    network, told = small("compact"), small("pc_nbv")
    points, mask = cloud(8), torch.ones(1, 8, dtype=torch.bool)
    for act in (
        lambda: network(points[0]),
        lambda: network(points[..., :2]),
        lambda: network(points, mask[:, :7]),
        lambda: network(points, mask.double()),
        lambda: network(points, mask, torch.zeros(1, 5)),
        lambda: told(points, mask),
        lambda: told(points, mask, torch.zeros(1, 4)),
        lambda: told(points, mask, torch.zeros(2, 5)),
        lambda: NetworkSettings(kind="transformer"),
        lambda: NetworkSettings(uncertainty="some"),
        lambda: NetworkSettings(views=0),
        lambda: NetworkSettings(shared=()),
        lambda: NetworkSettings(head=(16, 0)),
        lambda: NetworkSettings(scale=0.0),
        lambda: NetworkSettings(offset=(0.0, float("nan"), 0.0)),
        lambda: NetworkSettings(kind="pose_scores", scale=2.0),
        lambda: NetworkSettings(kind="compact", views=16, rig="pcnbv16", offset=(0.0, 0.0, 1.0)),
    ):
        with pytest.raises(ConfigError) as caught:
            act()
        assert "\n" not in str(caught.value)


@settings(max_examples=10)
@given(first=st.integers(0, 15), second=st.integers(0, 15), seed=st.integers(0, 1000))
def test_what_lies_before_a_view_as_it_lay_before_another_looks_the_same(first: int, second: int, seed: int) -> None:
    """A cloud is turned so that it lies in the axes of the second camera as it lay in those of the first."""
    network, places, features = small("compact", views=16, rig="pcnbv16"), cloud(9, seed=seed), cloud(9, seed=seed + 1)
    features = features @ torch.rand(3, 32, generator=seeded(seed), dtype=torch.double)
    stations = poses(rig("pcnbv16"), Target.at(np.zeros(3)), distance=3.0)[:, :3, :3]
    turned = places @ torch.from_numpy((stations[second] @ stations[first].T).T)
    turns = torch.from_numpy(stations_of("pcnbv16")[:, :3, :3])
    before, after = (network.look(features, each[:, None] @ turns)[0] for each in (places, turned))
    torch.testing.assert_close(after[second], before[first], rtol=0, atol=1e-12)


@pytest.mark.parametrize("present", [0, 3])
def test_without_the_view_state_it_answers_as_if_it_had_been_told_what_it_guesses(present: int) -> None:
    blind, told = small("compact"), small("compact_view")
    told.load_state_dict({name: value for name, value in blind.state_dict().items() if not name.startswith("guess")})
    sure = torch.full((3, 5), -400.0, dtype=torch.double)
    sure[:, present] = 400.0
    blind.guess.forward = lambda cloud: sure
    points, state = cloud(12, batch=3), torch.eye(5, dtype=torch.double)[[present] * 3]
    torch.testing.assert_close(blind(points), torch.roll(told(points, None, state), -present, dims=1), rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({"kind": "pc_nbv", "rig": "pcnbv33"}, "do not look"),
        ({"kind": "compact", "rig": "pcnbv16"}, "16"),
        ({"kind": "compact", "rig": "no_such"}, "no_such"),
    ],
)
def test_a_rig_that_does_not_fit_is_refused(changes: dict[str, str], word: str) -> None:
    with pytest.raises(ConfigError, match=word):
        NetworkSettings(**changes)  # 33 views


@settings(max_examples=20)
@given(views=st.integers(1, 9), present=st.integers(0, 8), seed=st.integers(0, 1000))
def test_answers_are_rolled_to_the_view_that_is_surely_the_present_one(views: int, present: int, seed: int) -> None:
    present %= views
    answers = torch.rand(2, views, 3, generator=seeded(seed), dtype=torch.double)
    presence = torch.zeros(2, views, dtype=torch.double)
    presence[:, present] = 800.0
    torch.testing.assert_close(mean_present_first(answers, presence), torch.roll(answers, -present, dims=1), rtol=0, atol=1e-12)
    # No idea at all: every place gets the mean.
    mean = answers.mean(1, keepdim=True).expand_as(answers)
    torch.testing.assert_close(mean_present_first(answers, torch.zeros_like(presence)), mean, rtol=0, atol=1e-12)


@settings(max_examples=20)
@given(number=st.integers(1, 30), padding=st.integers(0, 10), seed=st.integers(0, 1000))
def test_real_points_come_first_and_none_is_lost(number: int, padding: int, seed: int) -> None:
    points = cloud(number + padding, seed=seed)
    mask = torch.zeros(1, number + padding, dtype=torch.bool)
    mask[0, torch.randperm(number + padding, generator=seeded(seed))[:number]] = True
    ordered, count = in_order(points, mask)
    assert count.tolist() == [number]
    assert sorted(ordered[0, :number].tolist()) == sorted(points[mask].tolist())


def test_points_side_by_side_have_one_order_whatever_order_they_are_given_in() -> None:
    """On a grid of half floats many points lie equally far along a direction of two decimals: to the bit, in any precision."""
    steps = torch.arange(16, dtype=torch.float32) / 64
    grid = torch.cartesian_prod(steps, steps, steps)
    in_hundredths = (100 * torch.tensor(DIRECTION, dtype=torch.double)).round()
    assert ((grid.double() @ in_hundredths).sort().values.diff() == 0).sum() > 900  # such as those (3, 8, -7) steps apart
    mask = torch.ones(1, len(grid), dtype=torch.bool)
    first, _ = in_order(grid[None], mask)
    for seed in range(3):
        again, _ = in_order(grid[torch.randperm(len(grid), generator=seeded(seed))][None], mask)
        assert torch.equal(again, first)

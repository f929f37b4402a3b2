"""Points that lie where an earlier one lies are left out: against a search by hand."""

import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from viewgain.network._neighbours import unrepeated

COORDINATES = st.sampled_from([-1.0, -0.0, 0.0, 1e-30, 1.0])
"""Few places, so that many points meet; zero with either sign is one place."""
CLOUDS = st.lists(st.tuples(COORDINATES, COORDINATES, COORDINATES, st.booleans()), min_size=1, max_size=24)


def by_hand(points: list[tuple[float, float, float]], real: list[bool]) -> list[bool]:
    met: list[tuple[float, float, float]] = []
    kept = []
    for point, is_real in zip(points, real, strict=True):
        kept.append(is_real and point not in met)
        met += [point] if is_real else []
    return kept


@settings(max_examples=300)
@given(st.lists(CLOUDS, min_size=1, max_size=3))
def test_the_first_real_point_of_each_place_is_kept_and_no_other(clouds: list[list[tuple[float, float, float, bool]]]) -> None:
    number = min(len(cloud) for cloud in clouds)
    points = [[row[:3] for row in cloud[:number]] for cloud in clouds]
    real = [[row[3] for row in cloud[:number]] for cloud in clouds]
    kept = unrepeated(torch.tensor(points), torch.tensor(real))
    assert kept.tolist() == [by_hand(*each) for each in zip(points, real, strict=True)]


def test_a_cloud_without_repetition_is_kept_whole_and_one_of_a_single_place_has_one_point() -> None:
    points = torch.randn(2, 300, 3, generator=torch.Generator().manual_seed(0))
    mask = torch.arange(300) < torch.tensor([[300], [7]])
    assert torch.equal(unrepeated(points, mask), mask)
    assert unrepeated(torch.zeros(1, 50, 3), torch.ones(1, 50, dtype=torch.bool)).sum() == 1

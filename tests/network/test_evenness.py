"""How evenly a cloud lies in the image of each view: against a slow twin, and whether it says from where a scan was taken."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.oracles import network as oracle
from viewgain.arrays import Points
from viewgain.gain import COVERAGE_PROTOCOLS, model_clouds
from viewgain.network import STATISTICS, evenness, in_order, stations_of
from viewgain.network._evenness import images, spacings
from viewgain.rigs import Target, poses, rig
from viewgain.shapes import procedural
from viewgain.training._symmetry import symmetries

STATIONS = torch.from_numpy(stations_of("pcnbv16"))


def ordered(points: Points, *, filled_to: int = 0) -> tuple[torch.Tensor, torch.Tensor]:
    """Return a batch of one cloud as networks have it, its padding anything."""
    padding = np.full((max(filled_to - len(points), 0), 3), 0.3)
    real = torch.arange(len(points) + len(padding))[None] < len(points)
    return in_order(torch.from_numpy(np.concatenate([points, padding])[None]), real)


@settings(max_examples=15, deadline=None)
@given(number=st.integers(1, 40), padding=st.integers(0, 9), seed=st.integers(0, 999))
def test_spacings_are_those_found_pair_by_pair(number: int, padding: int, seed: int) -> None:
    image = np.random.default_rng(seed).uniform(-0.3, 0.3, (1, 2, number + padding, 2))
    found = spacings(torch.from_numpy(image), torch.tensor([number])).numpy()[0]
    for view in range(2):
        np.testing.assert_allclose(found[view], oracle.spacings(image[0, view, :number]), rtol=0, atol=1e-6)


@settings(max_examples=15, deadline=None)
@given(number=st.integers(1, 60), seed=st.integers(0, 999))
def test_neither_the_order_of_points_nor_padding_changes_it(number: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.4, 0.4, (number, 3))
    alone = evenness(*ordered(points), STATIONS)
    mixed = evenness(*ordered(rng.permutation(points), filled_to=number + 13), STATIONS)
    assert alone.shape == (1, 16, len(STATISTICS))
    assert torch.isfinite(alone).all()
    torch.testing.assert_close(mixed, alone, rtol=0, atol=1e-9)


def test_a_cloud_that_is_turned_with_the_rig_has_its_numbers_carried_along() -> None:
    points = np.random.default_rng(5).uniform(-0.4, 0.4, (50, 3))
    motions = symmetries(poses(rig("pcnbv16"), Target.at(np.zeros(3)), distance=1.0), "object")
    assert len(motions) == 2
    # In one order for both: it is fixed in space, and another one asks other points.
    there, here = (torch.from_numpy(each[None]) for each in (points @ motions.maps[1, 0].T, points))
    number = torch.tensor([len(points)])
    moved, still = evenness(there, number, STATIONS)[0], evenness(here, number, STATIONS)[0]
    torch.testing.assert_close(moved[motions.carried[1]], still, rtol=0, atol=1e-9)


def test_an_image_is_what_a_camera_of_the_rig_sees() -> None:
    points = np.random.default_rng(6).uniform(-0.4, 0.4, (20, 3))
    found = images(torch.from_numpy(points[None]), torch.tensor([20]), STATIONS)[0, 7].numpy()
    view = STATIONS[7].numpy()
    seen = (points - view[:3, 3]) @ view[:3, :3]
    image = seen[:, :2] / seen[:, 2:]
    np.testing.assert_allclose(found, image - image.mean(axis=0), rtol=0, atol=1e-12)


@pytest.mark.parametrize("category", ["chair", "car", "guitar", "bed"])
def test_the_view_of_the_scan_has_the_most_even_image(category: str) -> None:
    """Chance would be one in sixteen; three in four is asked of each shape, of a single statistic, with nothing learned."""
    rng = np.random.default_rng(7)
    clouds = model_clouds(procedural(category, rng=rng), COVERAGE_PROTOCOLS["paper"])
    right = []
    for view, cloud in enumerate(clouds):
        few = cloud[np.sort(rng.choice(len(cloud), min(512, len(cloud)), replace=False))]
        right.append(int(evenness(*ordered(few), STATIONS)[0, :, 1].argmin()) == view)
    assert np.mean(right) >= 0.75


def test_noise_along_the_rays_of_the_scan_leaves_its_own_view_as_it_is() -> None:
    """The points stay in their pixels; in the images of other views they move."""
    rng = np.random.default_rng(9)
    points, number, camera = rng.uniform(-0.3, 0.3, (1, 60, 3)), torch.tensor([60]), STATIONS[4, :3, 3].numpy()
    noisy = camera + (points - camera) * rng.uniform(0.98, 1.02, (1, 60, 1))
    still, moved = (spacings(images(torch.from_numpy(each), number, STATIONS), number)[0] for each in (points, noisy))
    torch.testing.assert_close(moved[4], still[4], rtol=0, atol=1e-9)
    assert (moved - still).abs()[5].max() > 1e-3


def test_half_precision_around_it_changes_nothing() -> None:
    points, number = ordered(np.random.default_rng(8).uniform(-0.4, 0.4, (64, 3)))
    points, stations = points.float(), STATIONS.float()
    with torch.autocast("cpu", torch.bfloat16):
        half = evenness(points, number, stations)
    torch.testing.assert_close(half, evenness(points, number, stations), rtol=0, atol=0)

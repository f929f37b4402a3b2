"""Rigs by name and number: what they are, in which order, and where the published ones stand."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.rigs.cameras import direction, seen_from, turn
from viewgain.errors import ConfigError
from viewgain.geometry import require_rigid
from viewgain.rigs import RIGS, Jitter, Rig, Target, hemisphere, irregular_rig, poses, rig, ring

BOX = Target.at(np.array([0.3, -0.2, 0.29]), np.array([0.57, 0.28, 0.58]))
"""Upright, not turned; its top corner (+x, +y) is at (0.585, -0.06, 0.58), its half diagonal is 0.3175 m."""
CORNER = np.array([0.585, -0.06, 0.58])
ROUNDING = 1e-12
COUNTS = {"ring8": 8, "paper4": 4, "paper4_unnormalised": 4, "recorded4": 4, "irregular4": 4, "pcnbv16": 16, "pcnbv33": 33}


def directions(stations: Rig) -> np.ndarray:
    return np.array([direction(station.azimuth, station.elevation or 0.0) for station in stations.stations])


@pytest.mark.parametrize(("name", "count"), COUNTS.items())
def test_presets_have_their_number_of_stations_and_know_their_name(name: str, count: int) -> None:
    assert rig(name) is RIGS[name]
    assert len(rig(name).stations) == count
    assert rig(name).name == name
    assert rig(rig(name)) is rig(name)


def test_there_are_no_other_presets_untested() -> None:
    assert set(RIGS) == set(COUNTS)


@pytest.mark.parametrize(
    ("name", "count"), [("ring2", 2), ("ring9", 9), ("ring360", 360), ("hemisphere1", 1), ("hemisphere40", 40)]
)
def test_rings_and_hemispheres_of_any_number_are_known(name: str, count: int) -> None:
    assert len(rig(name).stations) == count
    assert rig(name).name == name


@pytest.mark.parametrize("name", ["ring", "ring0", "ring08", "ring-3", "ring8 ", "hemisphere0", "rng8", "paper", "", "cell.tml"])
def test_an_unknown_name_is_refused_with_those_that_are_known(name: str) -> None:
    with pytest.raises(ConfigError, match="is not known; choose one of") as caught:
        rig(name)
    for known in (*RIGS, "ring<N>", "hemisphere<N>", ".toml"):
        assert known in str(caught.value)


def test_a_ring_of_one_is_no_ring() -> None:
    for make in (lambda: rig("ring1"), lambda: ring(0), lambda: hemisphere(0), lambda: hemisphere(3, lowest=np.pi / 2)):
        with pytest.raises(ConfigError, match="wanted"):
            make()


@given(st.integers(2, 60), st.integers(0, 200))
def test_a_ring_is_a_rotation_group(count: int, steps: int) -> None:
    """Turning it by some of its steps is relabelling it by as many, and all the way round is no turn."""
    cameras = poses(ring(count), BOX, elevation=0.5, distance=1.0)
    turned = poses(ring(count), BOX, azimuth=2 * np.pi * steps / count, elevation=0.5, distance=1.0)
    np.testing.assert_allclose(turned, np.roll(cameras, -steps, axis=0), atol=1e-9)


@given(st.integers(8, 400), st.floats(-0.5, 0.35))
def test_a_hemisphere_is_nearly_even_above_its_lowest_and_runs_down(count: int, lowest: float) -> None:
    """The band that its docstring states; a hexagonal lattice on the plane would have 1.075 everywhere."""
    found = directions(hemisphere(count, lowest=lowest))
    cosines = found @ found.T - 2 * np.eye(count)
    spacing = np.sqrt(2 * np.pi * (1 - np.sin(lowest)) / count)
    nearest = np.arccos(cosines.max(axis=1)) / spacing
    assert nearest.min() > 0.87
    assert nearest.max() < 1.05
    assert np.all(np.diff(found[:, 2]) < 0)
    assert found[-1, 2] > np.sin(lowest)
    np.testing.assert_allclose(found[:, 2].mean(), (1 + np.sin(lowest)) / 2, rtol=1e-9)  # equal areas


def test_the_paper_stands_where_its_scripts_say_by_hand() -> None:
    """On the diagonal (0.285, 0.14) / 0.317529 at offset d from there; tan(pi / 3.5) = 1.25396, tan(pi / 2.9) = 1.88620."""
    ahead = np.array([0.897553, 0.440903])
    offsets = poses(rig("paper4"), BOX)[:, :3, 3] - CORNER
    np.testing.assert_allclose(offsets[:, :2], [ahead, ahead, 1.3 * ahead, 1.3 * ahead], atol=2e-6)
    np.testing.assert_allclose(offsets[:, 2], [1.253960, 1.886200, 1.630148, 2.452060], atol=1e-6)
    np.testing.assert_allclose(offsets[:, 2], [d * np.tan(np.pi / part) for d in (1, 1.3) for part in (3.5, 2.9)], rtol=ROUNDING)


def test_unnormalised_is_their_formula() -> None:
    """From the box's centre (L + L d / (L^2 + W^2), W + W d / (L^2 + W^2)), L and W its half extents; heights unchanged."""
    half = BOX.extents[:2] / 2
    found = poses(rig("paper4_unnormalised"), BOX)
    theirs = [BOX.centre[:2] + half + half * d / (half @ half) for d in (1.0, 1.0, 1.3, 1.3)]
    np.testing.assert_allclose(found[:, :2, 3], theirs, atol=ROUNDING)
    np.testing.assert_allclose(found[:, 2, 3], poses(rig("paper4"), BOX)[:, 2, 3], atol=ROUNDING)
    np.testing.assert_allclose(
        np.linalg.norm(found[:, :2, 3] - CORNER[:2], axis=1), np.array([1, 1, 1.3, 1.3]) / 0.317529, rtol=1e-5
    )
    with pytest.raises(ConfigError, match="extents"):
        poses(rig("paper4_unnormalised"), Target.at(BOX.centre))


def test_recordings_stand_where_their_names_say_by_hand() -> None:
    """Half a metre and a metre of floor from the corner, level with it or as far above it, in the order of the alphabet."""
    ahead = np.array([0.897553, 0.440903])
    offsets = poses(rig("recorded4"), BOX)[:, :3, 3] - CORNER
    names = [station.name for station in rig("recorded4").stations]
    assert names == ["Sameheight_050", "Sameheight_100", "Top_050", "Top_100"] == sorted(names)
    np.testing.assert_allclose(offsets[:, :2], [0.5 * ahead, ahead, 0.5 * ahead, ahead], atol=2e-6)
    np.testing.assert_allclose(offsets[:, 2], [0.0, 0.0, 0.5, 1.0], atol=ROUNDING)


@pytest.mark.parametrize("name", ["paper4", "paper4_unnormalised", "recorded4"])
def test_the_paper_looks_at_the_top_corner(name: str) -> None:
    for camera in poses(rig(name), BOX):
        sight = CORNER - camera[:3, 3]
        np.testing.assert_allclose(camera[:3, 2], sight / np.linalg.norm(sight), atol=ROUNDING)


@given(st.floats(-np.pi, np.pi))
def test_the_papers_stations_turn_with_the_box_and_the_irregular_ones_do_not(yaw: float) -> None:
    turned = Target.at(np.array([0.0, 0.0, 0.2]), np.array([0.5, 0.3, 0.4]), yaw=yaw)
    straight = Target.at(np.array([0.0, 0.0, 0.2]), np.array([0.5, 0.3, 0.4]))
    np.testing.assert_allclose(poses(rig("paper4"), turned), turn(yaw) @ poses(rig("paper4"), straight), atol=1e-9)
    np.testing.assert_allclose(poses(rig("irregular4"), turned), poses(rig("irregular4"), straight), atol=1e-9)


def test_the_irregular_four_stand_at_their_numbers() -> None:
    found = [seen_from(BOX.centre, camera) for camera in poses(rig("irregular4"), BOX)]
    np.testing.assert_allclose(found, [(20, 35, 1.0), (70, 48, 1.3), (140, 32, 0.85), (-135, 42, 1.15)], atol=1e-9)


def test_the_pcnbv_directions_are_those_of_the_public_list_in_its_order(data_dir: Path) -> None:
    """The list is y-up; our x, y, z are its z, x, y. Placed, not only listed."""
    public = np.loadtxt(data_dir / "views" / "viewspace_shapenet_33.txt")[:, [2, 0, 1]]
    for name, count in (("pcnbv33", 33), ("pcnbv16", 16)):
        cameras = poses(rig(name), BOX, distance=1.4)
        np.testing.assert_allclose((cameras[:, :3, 3] - BOX.centre) / 1.4, public[:count], atol=1e-9)


def test_pcnbv16_is_the_beginning_of_pcnbv33() -> None:
    assert rig("pcnbv16").stations == rig("pcnbv33").stations[:16]


@given(st.integers(1, 30), st.integers(0, 2**32))
def test_an_irregular_rig_keeps_its_ranges_its_order_and_its_seed(count: int, seed: int) -> None:
    ranges = {"azimuth": (1.0, 4.0), "elevation": (0.2, 0.9), "distance": (0.7, 0.8)}
    one, other = (irregular_rig(count, rng=np.random.default_rng(seed), **ranges) for _ in range(2))
    assert one.stations == other.stations
    assert one.absolute
    azimuths = [station.azimuth for station in one.stations]
    assert azimuths == sorted(azimuths)
    for name, (low, high) in ranges.items():
        assert all(low <= getattr(station, name) <= high for station in one.stations)
    assert isinstance(one.jitter, Jitter)
    for camera in poses(one, BOX, rng=np.random.default_rng(seed)):
        require_rigid(camera, "camera")


@pytest.mark.parametrize(
    "options", [{"count": 0}, {"azimuth": (2.0, 1.0)}, {"elevation": (0.0, np.inf)}, {"distance": (0.0, 1.0)}], ids=str
)
def test_an_irregular_rig_of_nothing_is_refused(options: dict[str, object]) -> None:
    with pytest.raises(ConfigError, match="irregular"):
        irregular_rig(**{"count": 3, "rng": np.random.default_rng(0), **options})

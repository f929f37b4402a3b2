"""Histogram targets with the terms of a time-of-flight camera: the plain way, laws, and spellings that mean nothing."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.datasets.engines import Inline
from tests.oracles.terms import plain_border, plain_incidence
from viewgain.box import Box
from viewgain.camera import sensor
from viewgain.datasets import (
    BoxSettings,
    Dataset,
    Sample,
    add_volume_errors,
    box_views,
    build,
    knows_poses,
    object_errors,
    plan_of,
    recipe,
    with_target,
)
from viewgain.errors import ConfigError, DataError
from viewgain.gain import BorderTerm, BoxViews, IncidenceTerm
from viewgain.geometry import inverse
from viewgain.rigs import Target, poses, rig
from viewgain.scenes import standing_box

NARROW = """
extends = "pico_flexx"
name = "narrow"
[image]
width = 112
height = 86
horizontal_deg = 30.0
vertical_deg = 20.0
"""
"""A camera that has no room for the boxes from everywhere, so that the border counts."""
SIZES = ((0.42, 0.23, 0.12), (0.36, 0.58, 0.17), (0.57, 0.2, 0.51))
NAME = "histogram:lines_published:"


@pytest.fixture(scope="module")
def camera(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("camera") / "narrow.toml"
    file.write_text(NARROW)
    return file


@pytest.fixture(scope="module")
def data(camera: Path, tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """Three boxes at an angle, three scans from each of the paper's positions, by a camera from a file."""
    tiny = recipe("boxes_paper_tiny")
    assert isinstance(tiny.content, BoxSettings)
    content = replace(tiny.content, sizes=SIZES, cameras=(str(camera),), yaw_deg=(20.0, 20.0))
    folder, plan = tmp_path_factory.mktemp("boxes"), plan_of(replace(tiny, content=content))
    build(plan, folder, engine=Inline())
    add_volume_errors(plan, folder, ["lines_published"], engine=Inline())
    return Dataset(folder)


class Backwards(Dataset):
    """The same samples, the last one first: a box then begins with a scan from its last station."""

    def __getitem__(self, index: int) -> Sample:
        return super().__getitem__(len(self) - 1 - index)

    def column(self, name: str) -> np.ndarray:
        return super().column(name)[::-1]


def scene(number: int) -> tuple[Box, np.ndarray]:
    """Return a box and its stations in the world, from the recipe alone."""
    box = standing_box(np.array(SIZES[number]), yaw=np.deg2rad(20.0))
    return box, poses(rig("paper4"), Target(box.box_to_camera, box.extents))


def scores(data: Dataset, target: str) -> dict[int, np.ndarray]:
    """Return (V,) scores of each box in rig order, the same of all its samples."""
    found: dict[int, np.ndarray] = {}
    for sample in with_target(data, target):
        own = sample.in_rig_order(sample.targets[target])
        np.testing.assert_array_equal(found.setdefault(sample.object, own), own)
    return found


def test_boxes_and_stations_are_those_of_the_recipe(data: Dataset) -> None:
    for number, views in (*box_views(data).items(), *box_views(Backwards(data.folder)).items()):
        box, stations = scene(number)
        wanted, found = (inverse(b.box_to_camera) @ cameras for b, cameras in ((box, stations), (views.box, views.cameras)))
        np.testing.assert_allclose(found, wanted, atol=1e-6)  # poses are stored in single precision
        np.testing.assert_allclose(views.box.extents, SIZES[number], rtol=1e-7)
        assert (views.camera.width, views.camera.height) == (112, 86)


def near_zero(errors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (V,) shares of scans within half a bin of zero, and with as few bins more as give some view one."""
    limits = [*(0.025 + 0.05 * np.arange(10)), np.inf]
    shares = [np.array([sum(abs(error) <= limit for error in row) / len(row) for row in errors]) for limit in limits]
    return shares[0], next((each for each in shares if each.any()), shares[0])


def test_labels_with_terms_are_those_of_the_plain_way(data: Dataset, camera: Path) -> None:
    intrinsics, errors = sensor(camera).intrinsics, object_errors(data, "lines_published")
    borders, moved = [], 0
    for terms, squarely, whole in (("", 0, 0), ("+incidence", 0.2, 0), ("+border", 0, 0.2), ("+border=2+incidence=8", 8, 2)):
        found = scores(data, f"{NAME}near_zero{terms}")
        labels = scores(data, f"{NAME}soft{terms}")
        for number in range(len(SIZES)):
            box, stations = scene(number)
            incidence = np.array([plain_incidence(box, each, intrinsics) for each in stations])
            border = np.array([plain_border(box, each, intrinsics, 10) for each in stations])
            near, widened = near_zero(errors[number])
            added = squarely * incidence + whole * border
            # The package walks an outline in 32 steps an edge; a pixel at the edge of a face may be counted on either side.
            off = 0.02 * (squarely + whole)
            np.testing.assert_allclose(found[number], near + added, atol=max(off, 1e-12))
            wanted = widened + added
            if np.diff(np.sort(wanted))[-1] >= 2 * off:
                assert np.argmax(labels[number]) == np.argmax(wanted)
                moved += int(np.argmax(wanted) != np.argmax(widened))
            assert sorted(labels[number]) == [0.2, 0.2, 0.2, 0.8]
            borders += border.tolist()
    assert min(borders) < 0.8 < max(borders)  # else the border has not been tried
    assert moved  # nor have labels


def test_every_sample_of_a_box_says_the_same(data: Dataset) -> None:
    views = box_views(data)
    for sample in data:
        box = Box(np.asarray(sample.object_to_camera, dtype=float), np.asarray(sample.dims, dtype=float))
        own = BoxViews(box, np.roll(np.asarray(sample.candidates, dtype=float), sample.view, axis=0), views[sample.object].camera)
        for term in (IncidenceTerm(), BorderTerm(10)):
            # Each has its own rounding of the poses, and a pixel at the rim may change sides.
            np.testing.assert_allclose(term.gains(own), term.gains(views[sample.object]), atol=0.005)


def test_a_weight_of_nothing_is_no_term_and_a_huge_one_decides(data: Dataset) -> None:
    for objective in ("soft", "one_hot", "expected_error"):
        plain, none = scores(data, NAME + objective), scores(data, f"{NAME}{objective}+border=0+incidence=0")
        assert {number: each.tolist() for number, each in plain.items()} == {n: each.tolist() for n, each in none.items()}
    for number, label in scores(data, f"{NAME}soft+incidence=1e6").items():
        assert np.argmax(label) == np.argmax(IncidenceTerm().gains(box_views(data)[number]))
    both, turned = (scores(data, f"{NAME}near_zero{terms}") for terms in ("+incidence+border", "+border+incidence"))
    for number, each in both.items():
        np.testing.assert_allclose(turned[number], each, rtol=1e-14)


@pytest.mark.parametrize(
    "word", ["shade", "", "incidence+incidence", "incidence=", "border=-1", "border=nan", "border=inf", "border=1=2", "Border"]
)
def test_a_term_that_is_none_is_refused_in_one_line(data: Dataset, word: str) -> None:
    with pytest.raises(ConfigError, match="wanted incidence or border, each once at most") as caught:
        with_target(data, f"{NAME}soft+{word}")
    assert "\n" not in str(caught.value)
    assert f"target {NAME}soft+{word}: got the term {word.split('+')[-1]!r}" in str(caught.value)


def test_terms_want_boxes_of_known_pose(coverage: Dataset, data: Dataset) -> None:
    assert knows_poses(data)
    assert not knows_poses(coverage)
    with pytest.raises(DataError, match="wanted simulated boxes"):
        box_views(coverage)


def test_an_irregular_rig_of_each_box_is_taken_as_it_is(random_boxes: Dataset) -> None:
    views = box_views(random_boxes)
    assert {len(sample.candidates) == len(views[sample.object].cameras) for sample in random_boxes} == {True}
    assert len({each.camera.width for each in views.values()} | {len(each.cameras) for each in views.values()}) > 1
    for each in views.values():
        assert np.all((IncidenceTerm().gains(each) > 0) & (IncidenceTerm().gains(each) < 1))

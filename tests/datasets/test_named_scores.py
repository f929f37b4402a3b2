"""Targets by name: from histograms, and one drawn label per box."""

from pathlib import Path

import numpy as np
import pytest

from tests.datasets.engines import Inline
from viewgain.datasets import Dataset, add_volume_errors, build, histogram_scores, plan_of, recipe, with_target
from viewgain.errors import ConfigError, DataError
from viewgain.gain import SOFT


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """The tiny form of the paper's boxes with the errors of its estimator."""
    folder = tmp_path_factory.mktemp("boxes")
    plan = plan_of(recipe("boxes_paper_tiny"))
    build(plan, folder, engine=Inline())
    add_volume_errors(plan, folder, ["lines_published"], engine=Inline())
    return Dataset(folder)


def test_a_histogram_target_is_its_objective_with_the_present_view_first(data: Dataset) -> None:
    named = with_target(data, "histogram:lines_published:soft")
    scores = histogram_scores(data, "lines_published", SOFT)
    for index in range(len(data)):
        sample = named[index]
        target = sample.targets["histogram:lines_published:soft"]
        assert np.roll(target, sample.view).tolist() == scores[sample.object].tolist()
        assert sorted(target.tolist()) == [0.2, 0.2, 0.2, 0.8]


def test_a_tally_gives_each_object_one_position(data: Dataset) -> None:
    objects = np.unique(data.column("object"))
    tally = f"{len(objects)},0,0,0"
    named = with_target(data, f"tally:{tally}:3")
    for index in range(len(data)):
        sample = named[index]
        assert np.argmax(sample.in_rig_order(sample.targets[f"tally:{tally}:3"])) == 0
    with pytest.raises(ConfigError, match="wanted 4 for"):
        with_target(data, "tally:4,3,2,2,9:0")
    with pytest.raises(ConfigError, match="whole numbers"):
        with_target(data, "tally:a,b:0")


def test_unknown_targets_are_refused(data: Dataset) -> None:
    with pytest.raises(DataError, match="wanted one of"):
        with_target(data, "gain_published")
    with pytest.raises(ConfigError, match="'eye'"):
        with_target(data, "histogram:eye:soft")
    with pytest.raises(DataError, match="has no errors"):
        with_target(data, "histogram:default:soft")


def test_a_stored_target_is_taken_as_it_is(tmp_path: Path) -> None:
    build(plan_of(recipe("volume_irregular_tiny")), tmp_path / "data", engine=Inline())
    data = Dataset(tmp_path / "data")
    assert with_target(data, "volume_alone") is data

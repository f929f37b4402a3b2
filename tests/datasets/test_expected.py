"""Expected errors as targets: they are those of the true box, in the order of the candidates."""

from pathlib import Path

import numpy as np
import pytest

from tests.datasets.engines import Inline
from viewgain.box import Box
from viewgain.camera import sensor
from viewgain.datasets import Dataset, build, plan_of, recipe, volume_alone, volume_fused
from viewgain.geometry import inverse
from viewgain.plan import expected_error, fused_expected_error, showing
from viewgain.scenes import orbit_pose, standing_box


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """Six boxes on random rigs."""
    folder = tmp_path_factory.mktemp("volume")
    build(plan_of(recipe("volume_random_tiny")), folder, engine=Inline())
    return Dataset(folder)


def test_targets_are_those_of_the_true_box_from_each_candidate(data: Dataset) -> None:
    assert data.manifest.targets == ("volume_alone", "volume_fused")
    assert len({len(data[index].candidates) for index in range(len(data))}) > 1
    chosen = [index for index in range(len(data)) if data[index].noise == 1.0][:4]
    assert chosen
    for index in chosen:
        sample = data[index]
        camera, box = sensor(sample.camera), Box(sample.object_to_camera.astype(float), sample.dims.astype(float))
        poses = sample.candidates.astype(float)
        assert sample.targets["volume_alone"] == pytest.approx([-expected_error(box, each, camera) for each in poses], abs=2e-3)
        first = showing(box, np.eye(4), camera, 1.0)
        fused = [-fused_expected_error(box, first, each, camera) for each in poses]
        assert sample.targets["volume_fused"] == pytest.approx(fused, abs=2e-3)


def test_all_stations_at_once_are_worth_what_each_is_by_itself() -> None:
    box, camera = standing_box(np.array([0.4, 0.3, 0.2]), yaw=0.4), sensor("pico_flexx")
    stations = np.stack([orbit_pose(box.centre, azimuth, 0.6, 0.8) for azimuth in (0.0, 0.9, 2.0, 3.6)])
    alone = [-expected_error(box, each, camera) for each in stations]
    assert volume_alone(box, stations, camera) == pytest.approx(alone, rel=1e-9)
    here = box.in_frame(inverse(stations[1]))
    first = showing(here, np.eye(4), camera, 1.0)
    fused = [-fused_expected_error(here, first, inverse(stations[1]) @ each, camera) for each in stations]
    assert volume_fused(box, stations[1], stations, camera) == pytest.approx(fused, rel=1e-9)
    assert len({*alone, *fused}) == 8


def test_targets_lie_between_a_miss_and_certainty_and_differ(data: Dataset) -> None:
    table = np.concatenate([data[index].targets["volume_alone"] for index in range(len(data))])
    assert -1 <= table.min() < -0.5
    assert -0.3 < table.max() <= 0


def test_other_recipes_store_none(tmp_path: Path) -> None:
    build(plan_of(recipe("boxes_random_tiny")), tmp_path / "data", engine=Inline())
    assert Dataset(tmp_path / "data").manifest.targets == ()

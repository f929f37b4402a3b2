"""Data sets that many tests look at, built once."""

from pathlib import Path

import pytest

from tests.datasets.engines import Inline
from viewgain.datasets import Dataset, add_volume_errors, build, plan_of, recipe


def built(name: str, folder: Path, **changes: object) -> Dataset:
    """Build a recipe without processes."""
    build(plan_of(recipe(name), **changes), folder, engine=Inline())  # type: ignore[arg-type]
    return Dataset(folder)


@pytest.fixture(scope="session")
def boxes(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """boxes_paper_tiny with the errors of one estimator."""
    folder = tmp_path_factory.mktemp("boxes")
    data = built("boxes_paper_tiny", folder)
    add_volume_errors(plan_of(recipe("boxes_paper_tiny")), folder, ["lines_mended"], engine=Inline())
    return data


@pytest.fixture(scope="session")
def coverage(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """coverage_pcnbv_tiny."""
    return built("coverage_pcnbv_tiny", tmp_path_factory.mktemp("coverage"))


@pytest.fixture(scope="session")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """meshes_random_tiny."""
    return built("meshes_random_tiny", tmp_path_factory.mktemp("meshes"))


@pytest.fixture(scope="session")
def random_boxes(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """boxes_random_tiny."""
    return built("boxes_random_tiny", tmp_path_factory.mktemp("random"))

"""Scores made of stored errors, beside the plain way to count; and the errors beside estimators that are simply asked."""

import numpy as np
import pytest

from viewgain.camera import sensor
from viewgain.datasets import Dataset, histogram_scores, object_errors, plan_of, recipe, volume_error
from viewgain.datasets._plan import maker_of
from viewgain.errors import DataError
from viewgain.gain import HISTOGRAM_OBJECTIVES, HistogramRule
from viewgain.planes import MENDED, measure_lines


def test_stored_errors_are_those_of_the_scans_measured_again(boxes: Dataset) -> None:
    plan = plan_of(recipe("boxes_paper_tiny"))
    maker, stored = maker_of(plan.recipe), boxes.volume_errors("lines_mended")
    seeds = [sample.seed for sample in boxes]
    for unit in plan.units[::5]:
        for sample, scan in maker.scans(unit):
            volume = measure_lines(scan, MENDED).volume  # type: ignore[arg-type]
            expected = np.nan if volume is None else volume / np.prod(sample.dims) - 1  # type: ignore[union-attr]
            np.testing.assert_allclose(stored[seeds.index(sample.seed)], expected, rtol=1e-6)  # type: ignore[union-attr]


def test_the_default_estimator_measures_the_sample_and_no_other_box(random_boxes: Dataset) -> None:
    plan = plan_of(recipe("boxes_random_tiny"))
    maker = maker_of(plan.recipe)
    errors = []
    for unit in plan.units[:2]:
        for sample, scan in maker.scans(unit):
            if scan is not None:
                errors.append(volume_error("default", scan, sample, sensor(sample.camera)))  # type: ignore[arg-type, union-attr]
    found = [error for error in errors if np.isfinite(error)]
    assert len(found) >= len(errors) / 2
    assert np.median(np.abs(found)) < 0.15


def test_errors_by_object_and_view_are_the_errors_sorted(boxes: Dataset) -> None:
    errors = boxes.volume_errors("lines_mended")
    by_object = object_errors(boxes, "lines_mended")
    assert set(by_object) == {0, 1}
    for number, table in by_object.items():
        assert table.shape == (4, 3)
        for view in range(4):
            own = [errors[k] for k, sample in enumerate(boxes) if (sample.object, sample.view) == (number, view)]
            np.testing.assert_array_equal(np.sort(table[view]), np.sort(own))
    train = object_errors(boxes, "lines_mended", indices=boxes.part("same_box", "train"))
    assert all(table.shape == (4, 2) for table in train.values())


def test_a_view_without_scans_is_all_misses(boxes: Dataset) -> None:
    some = np.array([k for k, sample in enumerate(boxes) if (sample.object, sample.view) != (0, 2)])
    table = object_errors(boxes, "lines_mended", indices=some)[0]
    assert table.shape == (4, 3)
    assert np.all(np.isnan(table[2]))


def test_scores_reach_every_sample_rolled(boxes: Dataset) -> None:
    rule = HistogramRule(width=0.2, limit=1.0, tolerance=0.3)
    scores = histogram_scores(boxes, "lines_mended", HISTOGRAM_OBJECTIVES["probability_within"], rule=rule)
    errors = object_errors(boxes, "lines_mended")
    with_scores = boxes.with_scores("within", scores)
    for plain, sample in zip(boxes, with_scores, strict=True):
        expected = np.mean(np.abs(errors[sample.object]) <= 0.3, axis=1)
        np.testing.assert_allclose(sample.in_rig_order(sample.targets["within"]), expected)
        assert sample.targets["within"][0] == pytest.approx(expected[sample.view])
        assert "within" not in plain.targets


def test_errors_that_are_not_there_are_asked_for(boxes: Dataset, coverage: Dataset) -> None:
    with pytest.raises(DataError, match="--errors default"):
        boxes.volume_errors("default")
    with pytest.raises(DataError, match="--errors"):
        coverage.volume_errors("lines_mended")

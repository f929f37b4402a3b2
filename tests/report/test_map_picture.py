"""Maps of positions: places are directions, the footprint turns with the box, errors share a scale, grey is out of reach."""

from dataclasses import replace

import numpy as np
import pytest

from tests.report.test_drawing import texts
from viewgain.evaluation import GainMap, PolicyMap, PositionScores, VolumeSettings, volume_case
from viewgain.report._map_picture import map_figure
from viewgain.report._map_places import footprint, on_map, raster

SETTINGS = VolumeSettings(seed=5, rig="hemisphere24", captures=2, side=(0.2, 0.5))


@pytest.fixture
def drawn() -> GainMap:
    """A map with made-up numbers; the last two positions cannot be reached."""
    case = volume_case(SETTINGS, 0)
    reachable = np.arange(24) < 22
    case = replace(case, reachable=reachable, present=3)
    mean = np.where(reachable, np.geomspace(0.01, 1.0, 24), np.nan)
    truth = PositionScores(mean, np.where(reachable, 0.001, np.nan), reachable)
    policies = (
        PolicyMap("network:some/where/wise.onnx", "error", np.linspace(0.02, 0.5, 24), 0, 0.97),
        PolicyMap("covariance", "sigma_left", np.linspace(1.0, 0.4, 24), 21, -0.97),
        PolicyMap("mute", "minus_score", np.full(24, np.nan), None, None),
    )
    return GainMap(case=case, truth=truth, policies=policies)


def test_overhead_is_the_middle_and_the_horizon_the_rim() -> None:
    places = on_map(np.deg2rad([0.0, 90.0, 200.0]), np.deg2rad([0.0, 60.0, 90.0]))
    np.testing.assert_allclose(places, [[90, 0], [0, 30], [0, 0]], atol=1e-9)


def test_every_pixel_has_the_position_nearest_in_direction(drawn: GainMap) -> None:
    places, nearest, painted = raster(drawn)
    steps = np.linspace(-90, 90, len(nearest))
    for station, (x, y) in enumerate(places):
        row, column = int(np.argmin(np.abs(steps - y))), int(np.argmin(np.abs(steps - x)))
        assert nearest[row, column] == station
        assert painted[row, column]
    assert not painted[0, 0]


def test_the_footprint_turns_with_the_box(drawn: GainMap) -> None:
    def turned(quarter: float) -> np.ndarray:
        box = drawn.case.box
        spin = np.eye(4)
        spin[:2, :2] = [[np.cos(quarter), -np.sin(quarter)], [np.sin(quarter), np.cos(quarter)]]
        moved = replace(box, box_to_camera=spin @ box.box_to_camera)
        return footprint(replace(drawn, case=replace(drawn.case, scans=replace(drawn.case.scans, box=moved))))

    before, after = turned(0.0), turned(0.5)
    angle = np.arctan2(after[:, 1], after[:, 0]) - np.arctan2(before[:, 1], before[:, 0])
    np.testing.assert_allclose(angle % (2 * np.pi), 0.5)
    sides = np.linalg.norm(np.diff(before, axis=0), axis=1)
    np.testing.assert_allclose(sides[0] / sides[1], drawn.case.box.extents[0] / drawn.case.box.extents[1])


def test_the_picture_says_what_it_shows(drawn: GainMap) -> None:
    figure = map_figure(drawn)
    words = texts(figure)
    assert {"truth", "network", "wise", "covariance", "mute", "least 1 %", "rank correlation 0.97", "no opinion"} <= words
    assert {"present camera", "truly best position", "best by the policy", "out of reach"} <= words
    assert "expected volume error, % of the volume" in words
    assert "standard deviation of the volume left,\n% of today's" in words
    norms = [axes.images[0].norm for axes in figure.axes if axes.images]
    assert (norms[0].vmin, norms[0].vmax) == (norms[1].vmin, norms[1].vmax) == (0.01, pytest.approx(mean_reached(drawn)))
    assert (norms[2].vmin, norms[2].vmax) != (norms[0].vmin, norms[0].vmax)


def mean_reached(drawn: GainMap) -> float:
    return float(np.nanmax(drawn.truth.mean))


def test_without_policies_and_with_all_in_reach_no_key_is_idle(drawn: GainMap) -> None:
    free = np.ones(24, dtype=bool)
    mean = np.full(24, 0.02)
    alone = GainMap(case=replace(drawn.case, reachable=free), truth=PositionScores(mean, 0 * mean, free), policies=())
    words = texts(map_figure(alone))
    assert "out of reach" not in words
    assert "best by the policy" not in words

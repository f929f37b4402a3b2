"""Scans that fill a histogram: their seeds, their misses, and real estimators on them."""

import numpy as np
import pytest

from tests.oracles.shapes import box_mesh
from viewgain.camera import sensor
from viewgain.errors import ConfigError
from viewgain.gain import (
    ESTIMATORS,
    BoxScans,
    MeshScans,
    costs,
    fused_errors,
    measured_volume,
    volume_errors,
    volume_estimator,
)
from viewgain.measure import Measurement, fuse_measurements, measure
from viewgain.rigs import rig
from viewgain.scans import Scan
from viewgain.scenes import standing_box
from viewgain.simulate import Effects

CAMERA = sensor("pico_flexx")
SCANS = BoxScans(
    box=standing_box(np.array([0.4, 0.3, 0.25]), yaw=0.3),
    rig=rig("paper4"),
    sensor=CAMERA,
    seed=3,
    effects=Effects().without("multipath"),
)


def test_a_miss_costs_all_and_nothing_costs_more() -> None:
    assert costs([0.0, -0.3, 0.3, 4.0, np.nan, np.inf]).tolist() == [0.0, 0.3, 0.3, 1.0, 1.0, 1.0]


def footprint(scan: Scan) -> float:
    """Return a number that depends on every point of a scan."""
    return float(np.abs(scan.points).sum())


def test_a_scan_depends_on_its_own_numbers_only() -> None:
    whole = volume_errors(SCANS, footprint, range(3))
    np.testing.assert_array_equal(volume_errors(SCANS, footprint, [2, 0]), whole[:, [2, 0]])
    assert len(np.unique(whole)) == 12
    again = BoxScans(box=SCANS.box, rig=SCANS.rig, sensor=CAMERA, seed=3, effects=SCANS.effects)
    np.testing.assert_array_equal(volume_errors(again, footprint, range(3)), whole)
    other = BoxScans(box=SCANS.box, rig=SCANS.rig, sensor=CAMERA, seed=4, effects=SCANS.effects)
    assert not np.any(volume_errors(other, footprint, range(3)) == whole)


def test_scans_stand_where_the_jittered_rig_says() -> None:
    scan = SCANS.scan(2, 5)
    assert scan is not None
    assert scan.camera_to_world is not None
    np.testing.assert_allclose(scan.camera_to_world, SCANS.camera_to_world(2, 5), atol=1e-14)  # made exactly rigid in between
    spread = np.ptp([SCANS.camera_to_world(2, k)[:3, 3] for k in range(20)], axis=0)
    assert np.all(spread > [0.1, 0.1, 0.02])  # paper4 shakes by up to 0.2, 0.2 and 0.05 m
    assert np.all(spread < [0.3, 0.3, 0.06])


def test_a_box_and_its_mesh_are_seen_alike() -> None:
    upright = standing_box(np.array([0.4, 0.3, 0.25]))  # the mesh's own box lies along the world's axes
    silent = Effects.only()
    one = BoxScans(box=upright, rig=SCANS.rig, sensor=CAMERA, seed=3, effects=silent)
    other = MeshScans(mesh=box_mesh(upright), rig=SCANS.rig, sensor=CAMERA, seed=3, effects=silent)
    for view in range(2):
        np.testing.assert_allclose(one.camera_to_world(view, 1), other.camera_to_world(view, 1), atol=1e-12)
        first, second = one.scan(view, 1), other.scan(view, 1)
        assert first is not None
        assert second is not None
        apart = np.linalg.norm(first.points - second.points, axis=1)
        assert np.mean(apart < 1e-5) > 0.99  # a ray along an edge may take either side


def test_no_estimate_is_a_miss() -> None:
    def picky(scan: Scan) -> float:
        return float("nan") if scan.source == "view01_000" else SCANS.box.volume * 1.1

    errors = volume_errors(SCANS, picky, range(2))
    assert np.isnan(errors).tolist() == [[False, False], [True, False], [False, False], [False, False]]
    np.testing.assert_allclose(errors[~np.isnan(errors)], 0.1)
    assert np.isnan(measured_volume(Measurement((), None, (), "no_floor")))


def test_a_camera_that_sees_nothing_is_a_miss() -> None:
    far = BoxScans(box=SCANS.box, rig=rig("ring4"), sensor=CAMERA, seed=0, distance=60.0)
    assert far.scan(0, 0) is None
    assert np.isnan(volume_errors(far, footprint, range(1))).all()


def test_an_open_box_has_a_bound_and_no_volume() -> None:
    close = BoxScans(box=standing_box(np.array([1.2, 0.3, 0.3])), rig=rig("ring4"), sensor=CAMERA, seed=1, distance=0.7)
    scan = close.scan(1, 0)  # along the short side: both ends of the long one lie outside the image
    assert scan is not None
    measured = measure(scan, camera=CAMERA)
    assert any(measured.boxes[0].is_open)
    assert measured.boxes[0].volume > 0
    assert np.isnan(measured_volume(measured))


def test_the_estimators_measure_boxes() -> None:
    errors = {name: volume_errors(SCANS, volume_estimator(name, CAMERA), range(1)) for name in ESTIMATORS}
    assert np.all(np.abs(errors["default"]) < 0.1)
    assert len({tuple(table.ravel().tolist()) for table in errors.values()}) == len(ESTIMATORS)
    with pytest.raises(ConfigError, match="lines_mended"):
        volume_estimator("lines")


def test_fusing_with_the_present_view() -> None:
    errors, alone = fused_errors(SCANS, 3, range(1), pose_sigma=None)
    first, second = SCANS.scan(3, 1), SCANS.scan(1, 0)
    assert first is not None
    assert second is not None
    single = measure(first.posed(np.eye(4)), camera=CAMERA)
    assert alone[0] == pytest.approx(measured_volume(single) / SCANS.box.volume - 1)
    assert errors.shape == (4, 1)
    assert np.all(np.abs(errors) < 0.1)
    posed, _ = fused_errors(SCANS, 3, range(1))
    assert np.all(np.abs(posed) < 0.1)
    assert not np.array_equal(posed, errors)
    both = fuse_measurements([measure(each, camera=CAMERA) for each in (first, second)])
    assert posed[1, 0] == pytest.approx(measured_volume(both) / SCANS.box.volume - 1, abs=0.03)  # there with exact poses


def test_nonsense_is_refused() -> None:
    for view, number in ((4, 0), (-1, 0), (0, -1)):
        with pytest.raises(ConfigError, match="view"):
            SCANS.scan(view, number)
    with pytest.raises(ConfigError, match="seed"):
        BoxScans(box=SCANS.box, rig=SCANS.rig, sensor=CAMERA, seed=-1)

"""Scans of known things: what encloses them, and whether it is a box."""

import json

import numpy as np
import pytest

from tests.oracles.scenes import CAMERA, MODELLED, corner_view, scan_of
from viewgain.errors import ConfigError
from viewgain.measure import REASONS
from viewgain.meshes import TriangleMesh
from viewgain.parcels import Estimate, Rules, enclose, measure_any
from viewgain.scans import Scan
from viewgain.scenes import Scene, orbit_pose, standing_box
from viewgain.shapes import procedural
from viewgain.simulate import capture


def holds(estimate: Estimate, truth: float) -> bool:
    return estimate.low <= truth and (estimate.high is None or truth <= estimate.high)


def scan_of_mesh(mesh: TriangleMesh, *, distance: float = 1.2, seed: int = 0) -> Scan:
    view = orbit_pose(np.append(mesh.bounds.mean(axis=0)[:2], 0.1), 0.6, np.deg2rad(35), distance)
    return capture(Scene(meshes=(mesh,)), view, CAMERA, rng=np.random.default_rng(seed), effects=MODELLED)


def test_a_box_is_enclosed_by_itself_and_looks_like_one() -> None:
    box = standing_box(np.array([0.4, 0.3, 0.25]), yaw=0.3)
    found = enclose(scan_of(box, view=corner_view(box), rng=np.random.default_rng(0)), camera=CAMERA)
    assert found.reason is None
    one = found.objects[0]
    for estimate, truth in zip(one.upright.dimensions, [0.4, 0.3, 0.25], strict=True):
        assert holds(estimate, truth)
        assert estimate.seen == pytest.approx(truth, abs=0.03)
    assert one.box_likeness > 0.85
    assert one.flags == ()
    json.dumps(found.to_dict(), allow_nan=False)


def test_a_vase_is_less_box_like_than_a_box() -> None:
    vase = procedural("vase", rng=np.random.default_rng(1)).normalised(0.5).standing()
    one = enclose(scan_of_mesh(vase), camera=CAMERA).objects[0]
    assert one.box_likeness < 0.7
    assert one.upright.volume.low <= one.upright.volume.value <= one.upright.volume.high
    assert one.hull_volume.value < one.upright.volume.value


def test_a_chair_is_one_object_not_seven() -> None:
    chair = procedural("chair", rng=np.random.default_rng(3)).normalised(0.8).standing()
    assert len(enclose(scan_of_mesh(chair, distance=1.5), camera=CAMERA).objects) == 1


def test_what_leaves_the_image_has_no_upper_end() -> None:
    box = standing_box(np.array([0.5, 0.4, 0.3]))
    view = orbit_pose(box.centre + np.array([0.0, 0.45, 0.0]), 0.1, np.deg2rad(40), 1.0)
    one = enclose(scan_of(box, view=view, rng=np.random.default_rng(0)), camera=CAMERA).objects[0]
    assert "cut" in one.flags
    assert one.upright.volume.high is None
    assert one.upright.volume.low < 0.5 * 0.4 * 0.3


def test_an_empty_floor_gives_the_reason() -> None:
    view = orbit_pose(np.zeros(3), 0.3, np.deg2rad(40), 1.2)
    found = enclose(scan_of(view=view, rng=np.random.default_rng(0)), camera=CAMERA)
    assert (found.objects, found.reason) == ((), "nothing_on_floor")


def test_auto_says_box_or_any_and_why() -> None:
    box = standing_box(np.array([0.4, 0.3, 0.25]), yaw=0.3)
    scan = scan_of(box, view=corner_view(box), rng=np.random.default_rng(0))
    auto = measure_any(scan, camera=CAMERA, rules=Rules(division=0.005))
    assert [item.shape for item in auto.items] == ["box"]
    np.testing.assert_allclose(auto.items[0].billed.dimensions, [0.4, 0.3, 0.25], atol=0.0051)
    assert [item.shape for item in measure_any(scan, "any", camera=CAMERA).items] == ["any"]
    mug = procedural("mug", rng=np.random.default_rng(0)).normalised(0.3).standing()
    other = measure_any(scan_of_mesh(mug), camera=CAMERA)
    assert [item.shape for item in other.items] == ["any"]
    assert other.items[0].why_no_box in REASONS
    assert measure_any(scan_of_mesh(mug), "box", camera=CAMERA).items == ()
    json.dumps([auto.to_dict(), other.to_dict()], allow_nan=False)


def test_an_unknown_shape_is_refused() -> None:
    box = standing_box(np.array([0.4, 0.3, 0.25]))
    with pytest.raises(ConfigError, match="wanted one of: auto, box, any"):
        measure_any(scan_of(box, view=corner_view(box)), "sphere")  # type: ignore[arg-type]

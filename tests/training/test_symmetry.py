"""That labels stay right is checked on real geometry: the mirrored mesh is looked at anew."""

from dataclasses import replace

import numpy as np
import pytest

from viewgain.errors import DataError
from viewgain.gain import COVERAGE_PROTOCOLS, cover, greedy_labels, model_clouds, surface_samples
from viewgain.geometry import inverse, transform
from viewgain.meshes import TriangleMesh
from viewgain.rigs import Target, poses, rig
from viewgain.shapes import procedural
from viewgain.training import symmetries


def stations(name: str) -> np.ndarray:
    return poses(rig(name), Target.at(np.zeros(3)), distance=1.0)


@pytest.mark.parametrize(("name", "count"), [("pcnbv16", 2), ("pcnbv33", 16)])
def test_the_published_rigs_have_these_symmetries(name: str, count: int) -> None:
    found = symmetries(stations(name), "object")
    assert len(found) == count
    places = stations(name)[:, :3, 3]
    for carried, maps in zip(found.carried, found.maps, strict=True):
        assert sorted(carried.tolist()) == list(range(len(places)))
        np.testing.assert_allclose(places @ maps[0].T, places[carried], atol=1e-9)


def test_in_the_camera_frame_points_stay_before_the_camera() -> None:
    views = stations("pcnbv16")
    found = symmetries(views, "camera")
    points = np.random.default_rng(0).normal(0, 0.2, (50, 3))
    motion = symmetries(views, "object").maps[1, 0]
    for view in range(16):
        seen = transform(inverse(views[view]), points)
        wanted = transform(inverse(views[found.carried[1, view]]), points @ motion.T)
        np.testing.assert_allclose(seen @ found.maps[1, view].T, wanted, atol=1e-9)


def test_a_rig_without_symmetry_is_refused() -> None:
    with pytest.raises(DataError, match="symmetry"):
        symmetries(stations("pcnbv16")[[0, 1, 2, 4, 9, 13]], "object")
    with pytest.raises(DataError, match="poses"):
        symmetries(np.full((16, 4, 4), np.nan), "object")


def test_the_mirrored_object_has_the_carried_scores() -> None:
    protocol = replace(COVERAGE_PROTOCOLS["paper"], surface_points=2000, width=160, height=120, focal=119.0, reach=0.02)
    found = symmetries(stations("pcnbv16"), "object")
    motion, carried = found.maps[1, 0], found.carried[1]
    mesh = procedural("mug", rng=np.random.default_rng(4)).normalised(1.0)
    mirrored = TriangleMesh(vertices=mesh.vertices @ motion.T, faces=mesh.faces[:, ::-1].copy())
    surface = surface_samples(mesh, 2000, rng=np.random.default_rng(1))
    before = greedy_labels(cover(model_clouds(mesh, protocol), surface, protocol.reach), first=5, steps=1)
    covered = cover(model_clouds(mirrored, protocol), surface @ motion.T, protocol.reach)
    after = greedy_labels(covered, first=int(carried[5]), steps=1)
    gains, seen = before.gains_union[0], after.gains_union[0]
    # A pixel at the rim of the mug may fall on either side; a wrong order of the views is off by tenths.
    np.testing.assert_allclose(seen[carried], gains, atol=0.01)
    assert np.abs(seen - gains).max() > 0.05

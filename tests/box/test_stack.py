"""A stack of boxes: every function that takes one says of each box what it says of that box alone."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.box.cases import boxes, rays_around
from viewgain.box import (
    Box,
    Hits,
    adjoint,
    border_share,
    box_hits,
    edge_cosines,
    edge_distances,
    edge_end_jacobians,
    edges_shown,
    entry_mask,
    floor_hits,
    incidence,
    outline,
    range_jacobian,
)
from viewgain.camera import Intrinsics
from viewgain.geometry import inverse

CAMERA = Intrinsics.from_field_of_view(224, 171, *np.deg2rad([62.0, 45.0]))
SIZE = (CAMERA.width, CAMERA.height)


def to_pixels(image: np.ndarray) -> np.ndarray:
    return CAMERA.project(np.column_stack([image, np.ones(len(image))]))


OF_A_BOX: dict[str, Callable[[Box], np.ndarray]] = {
    "corners": Box.corners,
    "centre": lambda box: box.centre,
    "in_frame": lambda box: box.in_frame(np.diag([1.0, -1.0, -1.0, 1.0])).box_to_camera,
    "inverse": lambda box: inverse(box.box_to_camera),
    "adjoint": lambda box: adjoint(box.box_to_camera),
    "incidence": incidence,
    "border_share": lambda box: border_share(box, to_pixels, SIZE),
    "edges_shown": lambda box: edges_shown(box, to_pixels, SIZE),
}


@pytest.mark.parametrize("name", OF_A_BOX)
@given(st.lists(boxes, min_size=1, max_size=4))
def test_numbers_of_a_stack_are_those_of_its_boxes(name: str, several: list[Box]) -> None:
    said = OF_A_BOX[name](Box.stack(several))
    np.testing.assert_allclose(said, [OF_A_BOX[name](box) for box in several], rtol=1e-12, atol=1e-14)


@given(st.lists(boxes, min_size=1, max_size=4), st.integers(0, 1000))
def test_rays_meet_the_boxes_of_a_stack_as_they_meet_each_of_them(several: list[Box], seed: int) -> None:
    """Rays of their own and rays in common; products of matrices may round otherwise, so a ray on the rim may change sides."""
    stack, rays = Box.stack(several), np.array([rays_around(box, 50, seed) for box in several])
    for index, box in enumerate(several):
        for own, of_stack in ((rays[index], rays), (rays[0], rays[0])):
            for one, many in (
                (box_hits(box, own), box_hits(stack, of_stack)),
                (floor_hits(box, own), floor_hits(stack, of_stack)),
            ):
                same = one.planes == many.planes[index]
                assert same.mean() > 0.95
                np.testing.assert_allclose(many.ranges[index, same], one.ranges[same], rtol=1e-6)
                np.testing.assert_allclose(many.cosine[index, same], one.cosine[same], atol=1e-9)
            assert np.mean(entry_mask(stack, of_stack)[index] == entry_mask(box, own)) > 0.95
    found = box_hits(stack, rays)
    hits = Hits(np.minimum(found.ranges, 10.0), found.planes, np.maximum(found.cosine, 0.01))
    jacobian = range_jacobian(stack, rays, hits)
    for index, box in enumerate(several):
        own = Hits(hits.ranges[index], hits.planes[index], hits.cosine[index])
        np.testing.assert_allclose(jacobian[index], range_jacobian(box, rays[index], own), rtol=1e-9, atol=1e-9)


@given(st.lists(boxes, min_size=1, max_size=4), st.integers(0, 1000))
def test_outlines_of_a_stack_have_the_edges_of_each_and_edges_of_no_length(several: list[Box], seed: int) -> None:
    stack, points = Box.stack(several), np.random.default_rng(seed).uniform(-1, 1, (len(several), 60, 2))
    many = outline(stack)
    outside, cosines, ends = many.outside(points), edge_cosines(stack, many), edge_end_jacobians(stack, many)
    for index, box in enumerate(several):
        one = outline(box)
        rest = len(one.corners) - 1  # the last vertex is repeated, so the last edge comes last
        own = [*range(rest), len(many.corners[index]) - 1]
        np.testing.assert_array_equal(many.corners[index, :rest], one.corners[:rest])
        assert set(many.corners[index, rest:]) == {one.corners[rest]}
        np.testing.assert_allclose(many.middle[index], one.vertices.mean(axis=0), rtol=1e-12, atol=1e-14)
        np.testing.assert_array_equal(outside[index], edge_distances(one, points[index]).distance < 0)
        np.testing.assert_allclose(cosines[index, own], edge_cosines(box, one), atol=1e-12)
        for found, wanted in zip(ends, edge_end_jacobians(box, one), strict=True):
            np.testing.assert_allclose(found[index, own], wanted, rtol=1e-9, atol=1e-9)
            np.testing.assert_array_equal(found[index, rest:-1], 0)

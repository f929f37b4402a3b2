"""Pictures: points land where the camera saw them, the cloud is told apart, scales are equal, panels show what is bounded."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from viewgain.box import Box
from viewgain.episodes import Episode
from viewgain.geometry import transform
from viewgain.measure import range_image
from viewgain.plan import next_view
from viewgain.report import draw_scan, draw_scene
from viewgain.report._dimensions_picture import dimensions_figure
from viewgain.report._floor_grid import Floor
from viewgain.report._range_picture import to_image
from viewgain.report._scene import on_object, viewpoint, world_of
from viewgain.report._truth import compared, true_dimensions
from viewgain.report._units import MILLIMETRES, volume_unit
from viewgain.report._viewpoint import Viewpoint


def texts(figure: Figure) -> set[str]:
    figure.draw_without_rendering()
    axes = [child for axes in figure.axes for child in (axes, *axes.child_axes)]
    words = {text.get_text() for each in axes for text in each.texts} | {each.get_title(loc="left") for each in axes}
    words |= {each.get_xlabel() for each in axes} | {each.get_ylabel() for each in axes}
    return words | {text.get_text() for legend in figure.legends for text in legend.get_texts()}


def test_points_land_on_the_pixels_that_saw_them(episode: Episode) -> None:
    scan = episode.steps[0].scan
    assert scan.pixels is not None
    assert scan.shape is not None
    row, column = np.divmod(scan.pixels[::97], scan.shape[1])
    np.testing.assert_allclose(to_image(range_image(scan), scan.points[::97]), np.column_stack([column, row]), atol=1e-6)


def test_points_behind_or_far_beside_the_camera_are_not_drawn(episode: Episode) -> None:
    image = range_image(episode.steps[0].scan)
    away = to_image(image, np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 0.01], [50.0, 0.0, 1.0]]))
    assert np.all(np.isnan(away))


def test_the_range_image_says_what_it_shows(episode: Episode) -> None:
    step = episode.steps[0]
    words = texts(draw_scan(step.scan, step.fused, truth=step.fused.boxes[0].box, heading="Here", sizes=True))
    assert {"range, metres", "column, pixels", "row, pixels", "fitted box", "true box", "no return", "may go on", "−y"} <= words
    assert any(text.startswith("Here: ") and "224 × 171 pixels" in text for text in words)
    assert any(text.startswith("box 1: ") and "≥ " in text for text in words)


def test_a_box_beyond_the_border_widens_the_view_but_not_without_end(episode: Episode) -> None:
    step = episode.steps[1]
    estimate = step.fused.boxes[0]
    inside = draw_scan(step.scan, step.fused).axes[0]
    assert inside.get_xlim() == (-0.5, 223.5)
    huge = Box(estimate.box.box_to_camera, estimate.box.extents * 2.5)
    outside = draw_scan(step.scan, replace(step.fused, boxes=(replace(estimate, box=huge),))).axes[0]
    assert outside.get_xlim() != inside.get_xlim()
    assert np.ptp(outside.get_xlim()) <= 224 * 1.25


def test_an_object_that_is_no_box_is_marked(blob: Episode) -> None:
    step = blob.steps[0]
    assert "object that is not measured" in texts(draw_scan(step.scan, step.fused))
    assert "fitted box" not in texts(draw_scan(step.scan, step.fused))
    assert "returns on the object" in texts(draw_scene(step.scan, step.fused, step.plan))


def test_the_scene_names_every_camera_and_rings_the_winner(episode: Episode) -> None:
    step = episode.steps[1]
    figure = draw_scene(step.scan, step.fused, step.plan, earlier=[episode.steps[0].fused.world])
    words = texts(figure)
    assert {"x, metres", "y, metres", "z, metres", "best next view", "present camera", "earlier views"} <= words
    assert "share of the volume's\nstandard deviation removed" in words
    names = {name for text in words for name in text.split(", ")}
    wanted = {str(c.index) for c in step.plan.candidates if c.index != step.plan.best} | {
        f"{step.plan.best}: next",
        "now",
        "view 1",
    }
    assert wanted <= names
    assert figure.axes[0].get_aspect() == 1.0


def test_cameras_out_of_reach_are_said_to_be(episode: Episode) -> None:
    step = episode.steps[1]
    plan = next_view(step.fused, "pcnbv33", camera=episode.world.sensor)
    assert not all(candidate.reachable for candidate in plan.candidates)
    assert "out of reach" in texts(draw_scene(step.scan, step.fused, plan))
    assert "out of reach" not in texts(draw_scene(step.scan, step.fused, step.plan))


def test_names_of_cameras_keep_clear_of_each_other(episode: Episode) -> None:
    step = episode.steps[1]
    figure = draw_scene(step.scan, step.fused, step.plan)
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in figure.axes[0].texts]
    overlaps = [(a, b) for index, a in enumerate(boxes) for b in boxes[:index] if a.shrunk(0.8, 0.8).overlaps(b.shrunk(0.8, 0.8))]
    assert not overlaps


def test_returns_on_the_box_are_those_that_the_measurement_counts(episode: Episode) -> None:
    step = episode.steps[1]
    mine = on_object(step.scan.points, step.single)
    assert mine.sum() == pytest.approx(step.single.boxes[0].quality.returns, rel=0.05)


def test_the_viewer_keeps_lengths_across_the_line_of_sight_and_up_is_up() -> None:
    view = Viewpoint.at(0.8, 0.5)
    frame = np.array([view.right, view.up, view.towards])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    assert view.picture(np.array([0.0, 0.0, 1.0]))[0] == pytest.approx(0.0)
    assert view.picture(np.array([0.0, 0.0, 1.0]))[1] > 0.8


def test_the_viewpoint_is_beside_the_camera_and_slanted_to_the_grid(episode: Episode) -> None:
    step = episode.steps[0]
    view = viewpoint(step.fused, step.plan)
    camera = world_of(step.fused)[:2, 3] - transform(world_of(step.fused), step.fused.boxes[0].box.centre)[:2]
    turn = np.rad2deg(np.arccos(camera @ view.towards[:2] / np.linalg.norm(camera) / np.linalg.norm(view.towards[:2])))
    assert turn < 80
    assert np.abs(view.towards[:2]).min() > 0.2


def test_the_floor_holds_everything_in_whole_steps() -> None:
    places = np.array([[1.3, 0.2, 0.8], [-0.4, -0.7, 1.9]])
    floor = Floor.under(np.array([0.1, 0.0, 0.2]), places, 0.0)
    assert np.all(floor.low < places[:, :2])
    assert np.all(floor.high > places[:, :2])
    assert floor.top >= 1.9
    ends = np.concatenate([floor.low, floor.high, [floor.top]]) / floor.step
    np.testing.assert_allclose(ends, np.round(ends), atol=1e-9)
    assert 3 <= len(floor.ticks(0)) <= 12


def test_panels_show_the_bounded_intervals_and_send_the_open_ones_out_as_arrows(episode: Episode) -> None:
    truth = episode.world.box
    steps = [(), *(compared(step.fused, truth) for step in episode.steps)]
    truths, units = [*true_dimensions(truth), truth.volume], [*[MILLIMETRES] * 3, volume_unit(truth.volume)]
    figure = dimensions_figure(steps, truths, units)
    words = texts(figure)
    bound = f"≥ {MILLIMETRES.number(steps[1][2].value)}"
    assert {"Length", "Width", "Height", "Volume", bound, "not measured"} <= words
    assert "goes on outside the panel, or nothing bounds it" in words
    for axes, row, true, unit in zip(figure.axes, steps[-1], truths, units, strict=True):
        low, high = axes.get_ylim()
        assert low < min(true, row.low) * unit.per_metre
        assert high > max(true, row.high or 0) * unit.per_metre
    assert figure.axes[2].get_ylim()[0] > 200


def test_a_panel_of_open_ones_alone_shows_their_bound(episode: Episode) -> None:
    truth = episode.world.box
    rows = compared(episode.steps[0].fused, truth)
    figure = dimensions_figure([rows], [*true_dimensions(truth), truth.volume], [*[MILLIMETRES] * 3, volume_unit(truth.volume)])
    assert "lower bound" in texts(figure)
    assert figure.axes[2].get_ylim()[0] < 1000 * rows[2].low

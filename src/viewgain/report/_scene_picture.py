"""Cloud, box and candidate cameras in space."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from viewgain.arrays import Mask, Points, Pose
from viewgain.box import Box
from viewgain.geometry import transform
from viewgain.measure import BoxEstimate, Measurement
from viewgain.plan import NextView
from viewgain.report._cameras import FEW, Stage, draw_candidates, draw_labels, draw_own
from viewgain.report._colours import FAINT, FIT, HIDDEN_DASHES, INK, ON_BOX, ON_FLOOR, SMALL
from viewgain.report._floor_grid import Floor, draw_floor
from viewgain.report._scene import camera_places, floor_height, object_centre, on_object, viewpoint, world_of
from viewgain.report._style import (
    AXES_WIDTH,
    dots,
    fit_height,
    halo,
    key,
    legend_below,
    line_halo,
    new_figure,
    title,
    true_line,
    write,
)
from viewgain.report._viewpoint import Viewpoint
from viewgain.report._wire import edges, faces, facing_direction, open_edges, reported_box, room
from viewgain.scans import Scan

MOST_POINTS = 6000
"""The cloud is thinned to about this many points."""
CAMERA_SIZE = 0.064
"""Length of a camera over the diagonal of the floor."""


def scene_figure(
    scan: Scan,
    measurement: Measurement,
    plan: NextView | None = None,
    *,
    truth: Box | None = None,
    earlier: Sequence[Pose] = (),
    view: Viewpoint | None = None,
    heading: str = "In space",
) -> Figure:
    """Return the picture of a scan in space with the measured boxes and, after planning, the candidate cameras.

    Args:
        scan: The scan.
        measurement: What was measured, in the frame of this scan's camera.
        plan: The ranking made after it.
        truth: The true box in the world, where it is known.
        earlier: (4, 4) poses ``camera_to_world`` of the views before this one.
        view: From where to look; default where box and cameras stand farthest apart.
        heading: Title.
    """
    view = view or viewpoint(measurement, plan)
    points = transform(world_of(measurement), scan.points)
    figure = new_figure()
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.set_axis_off()
    title(axes, heading)
    floor = _floor(measurement, points, camera_places(measurement, plan, earlier), truth)
    draw_floor(axes, floor, view)
    stage = _stage(axes, view, floor, measurement, many=plan is not None and len(plan.candidates) > FEW)
    handles = _draw_cloud(axes, points, on_object(scan.points, measurement), floor, view)
    for index, estimate in enumerate(measurement.boxes):
        _draw_box(axes, estimate, world_of(measurement), view, 0.25 * stage.size if index == 0 else np.inf)
    if measurement.boxes:
        handles.append(key("fitted box", color=FIT, linewidth=2.0))
    if truth is not None:
        for edge in edges(truth, facing_direction(truth, view.towards)):
            axes.plot(*view.picture(edge.ends).T, **true_line(), zorder=6)
        handles.append(key("true box", **true_line()))
    labels = draw_candidates(figure, stage, plan, world_of(measurement)) if plan is not None else []
    draw_labels(stage, labels + draw_own(stage, world_of(measurement), earlier))
    rows = legend_below(figure, [*handles, *_camera_keys(plan, earlier)], 4)
    fit_height(figure, axes, legend_rows=rows)
    return figure


def _floor(measurement: Measurement, points: Points, cameras: Points, truth: Box | None) -> Floor:
    """Return the piece of floor that holds cameras, box and truth, or the whole cloud where there is nothing else."""
    boxes = [reported_box(estimate).in_frame(world_of(measurement)) for estimate in measurement.boxes[:1]]
    corners = [box.corners() for box in [*boxes, *([] if truth is None else [truth])]]
    if not corners and len(cameras) == 1:
        corners = [np.quantile(points, [0.05, 0.95], axis=0)]
    z = float(np.quantile(points[:, 2], 0.02)) if measurement.floor is None else floor_height(measurement)
    return Floor.under(object_centre(measurement), np.vstack([cameras, *corners]), z)


def _stage(axes: Axes, view: Viewpoint, floor: Floor, measurement: Measurement, *, many: bool) -> Stage:
    centre, world = object_centre(measurement), world_of(measurement)
    boxes = [reported_box(estimate).in_frame(world).corners() for estimate in measurement.boxes]
    scale = np.linspace(0, 1, 8)[:, None] * np.diff(floor.upright(view), axis=0) + floor.upright(view)[0]
    return Stage(
        axes=axes,
        view=view,
        centre=centre,
        floor_z=floor.z,
        size=CAMERA_SIZE * float(np.linalg.norm(floor.high - floor.low)) * (0.75 if many else 1.0),
        point=floor.width_from(view) / (72 * AXES_WIDTH),
        obstacles=view.picture(np.vstack([centre, scale, *boxes])),
    )


def _draw_cloud(axes: Axes, points: Points, mine: Mask, floor: Floor, view: Viewpoint) -> list[Line2D]:
    chosen = np.flatnonzero(floor.holds(points))
    chosen = chosen[:: max(1, len(chosen) // MOST_POINTS)]
    chosen = chosen[np.argsort(view.nearness(points[chosen]))]
    shown, mine = view.picture(points[chosen]), mine[chosen]
    dots(axes, shown[~mine], 0.7, ON_FLOOR, linewidths=0, zorder=2)
    dots(axes, shown[mine], 1.3, ON_BOX, linewidths=0, zorder=3)
    own = [key("returns on the object", color=ON_BOX, marker="o", linestyle="", markersize=3.5)] if mine.any() else []
    return [*own, key("other returns", color=ON_FLOOR, marker="o", linestyle="", markersize=3.5)]


def _draw_box(axes: Axes, estimate: BoxEstimate, world: Pose, view: Viewpoint, label_room: float) -> None:
    box = reported_box(estimate).in_frame(world)
    facing = facing_direction(box, view.towards)
    for edge in edges(box, facing):
        line = view.picture(edge.ends).T
        if edge.hidden:
            axes.plot(*line, color=FIT, linewidth=1.0, linestyle=HIDDEN_DASHES, zorder=4)
        else:
            axes.plot(*line, color=FIT, linewidth=2.0, path_effects=line_halo(2.8), solid_capstyle="round", zorder=5)
    for ends in open_edges(estimate):
        axes.plot(*view.picture(transform(world, ends)).T, color=FIT, linewidth=1.0, linestyle=":", zorder=5)
    for name, face in faces(box, facing).items():
        place = view.picture(face)
        if room(place) > label_room:
            write(axes, place[0], name, fontsize=SMALL - 1, color=INK, ha="center", va="center", path_effects=halo(1.6), zorder=7)


def _camera_keys(plan: NextView | None, earlier: Sequence[Pose]) -> list[Line2D]:
    keys = [key("present camera", color=INK, marker="^", linestyle="", markersize=5)]
    if earlier:
        keys.append(key("earlier views", color=ON_FLOOR, marker="^", linestyle="", markersize=5))
    if plan is not None and plan.best is not None:
        ring = {"markerfacecolor": "none", "markeredgecolor": INK, "markersize": 7}
        keys.append(key("best next view", marker="o", linestyle="", **ring))
    if plan is not None and not all(candidate.reachable for candidate in plan.candidates):
        keys.append(key("out of reach", color=FAINT, marker="x", linestyle="", markersize=5))
    return keys

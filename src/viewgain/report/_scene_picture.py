"""Cloud, box and candidate cameras in space."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from viewgain.arrays import Mask, Points, Pose, Vector3
from viewgain.box import Box
from viewgain.geometry import floor_to_camera, transform
from viewgain.measure import Measurement
from viewgain.plan import NextView
from viewgain.report._cameras import FEW, Label, Stage, draw_camera, draw_candidates, draw_labels
from viewgain.report._floor_grid import Floor, draw_floor
from viewgain.report._style import (
    FAINT,
    FIT,
    HIDDEN_DASHES,
    INK,
    ON_BOX,
    ON_FLOOR,
    SMALL,
    fit_height,
    halo,
    legend_below,
    line_halo,
    new_figure,
    title,
    true_line,
)  # fmt: skip
from viewgain.report._viewpoint import Viewpoint, clearest
from viewgain.report._wire import edges, faces, facing_direction, open_edges, reported_box, room
from viewgain.scans import Scan

MOST_POINTS = 6000
"""The cloud is thinned to about this many points."""
CAMERA_SIZE = 0.064
"""Length of a camera over the diagonal of the floor."""
ASIDE = np.deg2rad(35.0)
"""The viewer stands this far to the side of the present camera."""


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
    world = measurement.world
    boxes = [reported_box(estimate).in_frame(world) for estimate in measurement.boxes]
    centre = object_centre(measurement)
    cameras = camera_places(measurement, plan, earlier)
    view = view or viewpoint(measurement, plan)
    corners = [box.corners() for box in [*boxes[:1], *([] if truth is None else [truth])]]
    floor = Floor.under(centre, np.vstack([cameras, *corners]), floor_height(measurement))
    many = plan is not None and len(plan.candidates) > FEW
    size = CAMERA_SIZE * float(np.linalg.norm(floor.high - floor.low)) * (0.75 if many else 1.0)
    figure = new_figure()
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.set_axis_off()
    title(axes, heading)
    draw_floor(axes, floor, view)
    handles = _draw_cloud(axes, transform(world, scan.points), on_object(scan.points, measurement), floor, view)
    if boxes:
        handles.append(Line2D([], [], color=FIT, linewidth=2.0, label="fitted box"))
    for index, (estimate, box) in enumerate(zip(measurement.boxes, boxes, strict=True)):
        _draw_box(axes, box, view, 0.25 * size if index == 0 else np.inf)
        for line in open_edges(estimate):
            axes.plot(*view.picture(transform(world, line)).T, color=FIT, linewidth=1.0, linestyle=":", zorder=5)
    if truth is not None:
        for edge in edges(truth, facing_direction(truth, view.towards)):
            axes.plot(*view.picture(edge.ends).T, **true_line(), zorder=6)
        handles.append(Line2D([], [], **true_line(), label="true box"))
    stage = Stage(axes, view, centre, floor.z, size)
    labels = draw_candidates(figure, stage, plan, world) if plan is not None else []
    labels += _draw_own_cameras(stage, world, earlier)
    draw_labels(stage, labels)
    legend_below(figure, [*handles, *_camera_keys(plan, earlier)], 4)
    fit_height(figure, axes)
    return figure


def viewpoint(measurement: Measurement, plan: NextView | None) -> Viewpoint:
    """Return the clearest viewpoint for a measurement and the cameras of its plan."""
    centre, cameras = object_centre(measurement), camera_places(measurement, plan, ())
    ahead = measurement.world[:3, 3] - centre
    return clearest(centre, cameras, float(np.arctan2(ahead[1], ahead[0])) + ASIDE)


def object_centre(measurement: Measurement) -> Vector3:
    """Return (3,) the middle of what the pictures are about: first box, else largest object, else the point 1 m ahead."""
    if measurement.boxes:
        return transform(measurement.world, measurement.boxes[0].box.centre)
    if measurement.rejected:
        return transform(measurement.world, measurement.rejected[0].centre)
    return transform(measurement.world, np.array([0.0, 0.0, 1.0]))


def camera_places(measurement: Measurement, plan: NextView | None, earlier: Sequence[Pose]) -> Points:
    """Return (k, 3) where cameras stand, world frame: the present one, the candidates and the earlier ones."""
    candidates = [] if plan is None else [measurement.world @ candidate.camera_to_current for candidate in plan.candidates]
    return np.array([pose[:3, 3] for pose in (measurement.world, *candidates, *earlier)])


def floor_height(measurement: Measurement) -> float:
    """Return the floor's height in the world under the camera, metres; 0 without a floor."""
    if measurement.floor is None:
        return 0.0
    return float((measurement.world @ floor_to_camera(measurement.floor.plane))[2, 3])


def on_object(points: Points, measurement: Measurement) -> Mask:
    """Return the (n,) mask of camera-frame points within 1.5 cm of a measured box, or else in the bounds of a rejected object."""
    mask = np.zeros(len(points), dtype=bool)
    for box in (reported_box(estimate) for estimate in measurement.boxes):
        local = (points - box.box_to_camera[:3, 3]) @ box.box_to_camera[:3, :3]
        sides = np.all(np.abs(local[:, :2]) < box.extents[:2] / 2 + 0.015, axis=1)
        mask |= sides & (local[:, 2] > 0.005) & (local[:, 2] < box.extents[2] + 0.015)
    if measurement.floor is None or measurement.boxes:
        return mask
    for blob in measurement.rejected:
        mask |= np.all(np.abs(points - blob.centre) < 1.05 * blob.spread, axis=1) & (
            measurement.floor.plane.height(points) > 0.015
        )
    return mask


def _draw_cloud(axes: Axes, points: Points, mine: Mask, floor: Floor, view: Viewpoint) -> list[Line2D]:
    chosen = np.flatnonzero(floor.holds(points))
    chosen = chosen[:: max(1, len(chosen) // MOST_POINTS)]
    chosen = chosen[np.argsort(view.nearness(points[chosen]))]
    shown, mine = points[chosen], mine[chosen]
    axes.scatter(*view.picture(shown[~mine]).T, s=0.7, color=ON_FLOOR, linewidths=0, zorder=2)
    axes.scatter(*view.picture(shown[mine]).T, s=1.3, color=ON_BOX, linewidths=0, zorder=3)
    own = [_dot("returns on the object", ON_BOX)] if mine.any() else []
    return [*own, _dot("other returns", ON_FLOOR)]


def _draw_box(axes: Axes, box: Box, view: Viewpoint, label_room: float) -> None:
    facing = facing_direction(box, view.towards)
    for edge in edges(box, facing):
        line = view.picture(edge.ends).T
        if edge.hidden:
            axes.plot(*line, color=FIT, linewidth=1.0, linestyle=HIDDEN_DASHES, zorder=4)
        else:
            axes.plot(*line, color=FIT, linewidth=2.0, path_effects=line_halo(2.8), solid_capstyle="round", zorder=5)
    for name, face in faces(box, facing).items():
        place = view.picture(face)
        if room(place) > label_room:
            axes.text(*place[0], name, fontsize=SMALL - 1, color=INK, ha="center", va="center", path_effects=halo(1.6), zorder=7)


def _draw_own_cameras(stage: Stage, world: Pose, earlier: Sequence[Pose]) -> list[Label]:
    """Draw the present camera and the earlier ones."""
    labels = []
    for number, pose in enumerate(earlier, start=1):
        place = draw_camera(stage, pose, face=ON_FLOOR, edge=FAINT, scale=0.6).place
        labels.append(Label(place, f"view {number}"))
    place = draw_camera(stage, world, face=INK, edge=INK, scale=0.6).place
    return [*labels, Label(place, "now", bold=True, distance=18.0)]


def _camera_keys(plan: NextView | None, earlier: Sequence[Pose]) -> list[Line2D]:
    keys = [_dot("present camera", INK, "^", 5)]
    if earlier:
        keys.append(_dot("earlier views", ON_FLOOR, "^", 5))
    if plan is not None and plan.best is not None:
        keys.append(
            Line2D(
                [],
                [],
                marker="o",
                linestyle="",
                markerfacecolor="none",
                markeredgecolor=INK,
                markersize=7,
                label="best next view",
            )
        )
    if plan is not None and not all(candidate.reachable for candidate in plan.candidates):
        keys.append(_dot("out of reach", FAINT, "x", 5))
    return keys


def _dot(label: str, colour: str, marker: str = "o", size: float = 3.5) -> Line2D:
    return Line2D([], [], marker=marker, linestyle="", color=colour, markersize=size, label=label)

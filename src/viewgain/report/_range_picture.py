"""The range image of a scan with the boxes that were fitted to it."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from viewgain.arrays import Points, Points2
from viewgain.box import CORNERS, Box
from viewgain.measure import BoxEstimate, Measurement, Rejected, range_image
from viewgain.report._colours import FIT, HIDDEN_DASHES, INK, MISSING, SMALL
from viewgain.report._style import (
    colour_bar,
    fit_height,
    halo,
    key,
    legend_below,
    line_halo,
    new_figure,
    plain_axes,
    range_colours,
    title,
    true_line,
    write,
)
from viewgain.report._units import percent
from viewgain.report._wire import edges, faces, facing_camera, open_edges, reported_box, room
from viewgain.report._words import reason_in_words, size_with_sigma
from viewgain.scans import Scan

if TYPE_CHECKING:
    from viewgain.measure._range_image import RangeImage

IN_A_ROW = 4
"""Entries of the legend side by side: more do not fit beside each other."""
MARGIN = 0.12
"""Share of the image that is shown beyond its border where a box goes on there."""
_NEAR = 0.05
_SAMPLES = 24
_LABEL_ROOM = 0.02
_MAY_GO_ON = {"color": FIT, "linewidth": 1.0, "linestyle": ":"}


def range_figure(
    scan: Scan, measurement: Measurement, *, truth: Box | None = None, heading: str = "Range image", sizes: bool = False
) -> Figure:
    """Return the picture of a scan's ranges with the boxes of ``measurement`` over it.

    Args:
        scan: The scan; an unorganised cloud is drawn on a grid of its own angular pitch.
        measurement: What was measured, in the frame of this scan's camera.
        truth: The true box in the same frame, where it is known.
        heading: First words of the title.
        sizes: Whether to write the dimensions under the title.
    """
    image = range_image(scan)
    details = _sizes(measurement) if sizes else ()
    figure = new_figure()
    axes = figure.add_subplot()
    title(axes, f"{heading}: {_returned(scan, image)}", details)
    _draw_ranges(figure, axes, image)
    for index, estimate in enumerate(measurement.boxes):
        _draw_box(axes, image, estimate, named=index == 0)
    for index, blob in enumerate(measurement.rejected):
        _draw_blob(axes, image, blob, framed=index == 0 and not measurement.boxes)
    if truth is not None:
        for edge in edges(truth, facing_camera(truth)):
            _draw_line(axes, image, edge.ends, **true_line(), zorder=4)
    handles = _keys(measurement, with_truth=truth is not None)
    rows = legend_below(figure, handles, min(len(handles), IN_A_ROW))
    _show_all(axes, image, [reported_box(estimate) for estimate in measurement.boxes])
    fit_height(figure, axes, legend_rows=rows, details=len(details))
    return figure


def to_image(image: "RangeImage", points: Points) -> Points2:
    """Return the (n, 2) pixels of (n, 3) camera-frame points; NaN behind the camera or far outside its view."""
    pixels = np.full((len(points), 2), np.nan)
    ahead = points[:, 2] > _NEAR
    rays = points[ahead, :2] / points[ahead, 2:]
    seen = (image.directions[..., :2] / image.directions[..., 2:]).reshape(-1, 2)
    low, high = np.nanmin(seen, axis=0), np.nanmax(seen, axis=0)
    near = np.all((rays > low - 0.3 * (high - low)) & (rays < high + 0.3 * (high - low)), axis=1)
    pixels[np.flatnonzero(ahead)[near]] = image.plane.to_pixels(rays[near])
    return pixels


def _returned(scan: Scan, image: "RangeImage") -> str:
    if not image.organised:
        return f"{len(scan.points):,} points"
    height, width = image.ranges.shape
    return f"{percent(float(np.mean(image.valid)), 0)} of {width} × {height} pixels returned"


def _sizes(measurement: Measurement) -> tuple[str, ...]:
    """Return the dimensions of every measured box with their standard deviations, or why there is none."""
    if not measurement.boxes:
        return (f"no box: {reason_in_words(measurement.reason)}",)
    return tuple(f"box {number}: {size_with_sigma(estimate)}" for number, estimate in enumerate(measurement.boxes, start=1))


def _draw_ranges(figure: Figure, axes: Axes, image: "RangeImage") -> None:
    height, width = image.ranges.shape
    low, high = np.nanpercentile(image.ranges, [0.5, 99.5])
    picture = axes.imshow(image.ranges, cmap=range_colours(), vmin=low, vmax=max(high, low + 0.01), interpolation="nearest")
    axes.add_patch(Rectangle((-0.5, -0.5), width, height, fill=False, edgecolor=INK, linewidth=0.6))
    unit = "pixels" if image.organised else "cells"
    plain_axes(axes, f"column, {unit}", f"row, {unit}")
    colour_bar(figure, picture, axes, "range, metres")


def _draw_box(axes: Axes, image: "RangeImage", estimate: BoxEstimate, *, named: bool) -> None:
    box = reported_box(estimate)
    facing = facing_camera(box)
    for edge in edges(box, facing):
        if edge.hidden:
            _draw_line(axes, image, edge.ends, color=FIT, linewidth=1.1, linestyle=HIDDEN_DASHES, zorder=2)
        else:
            _draw_line(axes, image, edge.ends, color=FIT, linewidth=2.2, path_effects=line_halo(3.2), zorder=3)
    for line in open_edges(estimate):
        _draw_line(axes, image, line, **_MAY_GO_ON, path_effects=line_halo(2.4))
    for name, face in faces(box, facing).items() if named else ():
        pixels = to_image(image, face)
        if room(pixels) > _LABEL_ROOM * image.ranges.shape[1]:
            style = {"fontsize": SMALL, "color": INK, "path_effects": halo()}
            write(axes, pixels[0], name, ha="center", va="center", clip_on=True, zorder=5, **style)


def _draw_blob(axes: Axes, image: "RangeImage", blob: Rejected, *, framed: bool) -> None:
    """Mark the middle of an object that is no box and, where it is the only thing to see, its extent."""
    middle = to_image(image, blob.centre[None])[0]
    axes.plot(*middle, "x", color=INK, markersize=5, path_effects=line_halo(2.6), zorder=4)
    u, v = to_image(image, blob.centre + 2 * CORNERS[:4] * blob.spread).T
    if not framed or np.all(np.isnan(u)):
        return
    low, size = (np.nanmin(u), np.nanmin(v)), (np.nanmax(u) - np.nanmin(u), np.nanmax(v) - np.nanmin(v))
    axes.add_patch(Rectangle(low, *size, fill=False, edgecolor=INK, linewidth=0.9, linestyle="-.", path_effects=line_halo(2.2)))


def _draw_line(axes: Axes, image: "RangeImage", ends: Points, **style: Any) -> None:
    """Draw a straight line of space; in the image of a real lens it is a curve."""
    along = np.linspace(0, 1, _SAMPLES)[:, None]
    u, v = to_image(image, ends[0] + along * (ends[1] - ends[0])).T
    axes.plot(u, v, solid_capstyle="round", **style)


def _keys(measurement: Measurement, *, with_truth: bool) -> list[Line2D | Patch]:
    handles: list[Line2D | Patch] = []
    if measurement.boxes:
        handles.append(key("fitted box", color=FIT, linewidth=2.2))
        handles.append(key("its hidden edges", color=FIT, linewidth=1.1, linestyle=HIDDEN_DASHES))
    if any(any(estimate.is_open) for estimate in measurement.boxes):
        handles.append(key("may go on", **_MAY_GO_ON))
    if measurement.rejected:
        handles.append(key("object that is not measured", color=INK, marker="x", linestyle="", markersize=5))
    if with_truth:
        handles.append(key("true box", **true_line()))
    return [*handles, Patch(color=MISSING, label="no return")]


def _show_all(axes: Axes, image: "RangeImage", boxes: Sequence[Box]) -> None:
    """Widen the view to where a box leaves the image, up to a margin."""
    height, width = image.ranges.shape
    size = np.array([width, height], dtype=float)
    corners = [to_image(image, box.corners()) for box in boxes]
    pixels = np.vstack([np.array([[0.0, 0.0], size - 1]), *corners])
    low = np.maximum(np.nanmin(pixels, axis=0) - 3, -MARGIN * size)
    high = np.minimum(np.nanmax(pixels, axis=0) + 3, (1 + MARGIN) * size)
    low, high = np.where(low > -4, -0.5, low), np.where(high < size + 3, size - 0.5, high)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(high[1], low[1])

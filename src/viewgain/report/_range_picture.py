"""The range image of a scan with the boxes that were fitted to it."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from viewgain.arrays import Array, Points, Points2
from viewgain.box import CORNERS, Box
from viewgain.measure import Measurement, Rejected, range_image
from viewgain.measure._range_image import RangeImage
from viewgain.report._style import (
    FIT,
    HIDDEN_DASHES,
    INK,
    MISSING,
    SMALL,
    colour_bar,
    fit_height,
    halo,
    legend_below,
    line_halo,
    new_figure,
    plain_axes,
    range_colours,
    title,
    true_line,
)  # fmt: skip
from viewgain.report._wire import edges, faces, facing_camera, open_edges, reported_box, room
from viewgain.report._words import reason_in_words
from viewgain.scans import Scan

MARGIN = 0.12
"""Share of the image that is shown beyond its border where a box goes on there."""
_NEAR = 0.05
_SAMPLES = 24
_LABEL_ROOM = 0.02


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
    figure = new_figure()
    axes = figure.add_subplot()
    details = _sizes(measurement) if sizes else ()
    _draw_ranges(figure, axes, image, heading, details)
    handles: list[Line2D | Patch] = []
    for index, estimate in enumerate(measurement.boxes):
        _draw_box(axes, image, reported_box(estimate), first=index == 0)
        for line in open_edges(estimate):
            _draw_line(axes, image, line, color=FIT, linewidth=1.0, linestyle=":", path_effects=line_halo(2.4))
    if measurement.boxes:
        handles += [_key("fitted box", color=FIT, linewidth=2.2), _key("its hidden edges", color=FIT, linewidth=1.1, linestyle=HIDDEN_DASHES)]  # fmt: skip
    if any(any(estimate.is_open) for estimate in measurement.boxes):
        handles.append(_key("may go on", color=FIT, linewidth=1.0, linestyle=":"))
    for blob in measurement.rejected:
        _draw_blob(axes, image, blob)
    if measurement.rejected:
        handles.append(_key("object that is not measured", color=INK, linewidth=0.9, linestyle="-."))
    if truth is not None:
        _draw_truth(axes, image, truth)
        handles.append(_key("true box", **true_line()))
    handles.append(Patch(color=MISSING, label="no return"))
    legend_below(figure, handles, len(handles))
    _show_all(axes, image, [reported_box(estimate) for estimate in measurement.boxes])
    fit_height(figure, axes, len(details))
    return figure


def to_image(image: RangeImage, points: Points) -> Points2:
    """Return the (n, 2) pixels of (n, 3) camera-frame points; NaN behind the camera or far outside its view."""
    pixels = np.full((len(points), 2), np.nan)
    ahead = points[:, 2] > _NEAR
    rays = points[ahead, :2] / points[ahead, 2:]
    seen = (image.directions[..., :2] / image.directions[..., 2:]).reshape(-1, 2)
    low, high = np.nanmin(seen, axis=0), np.nanmax(seen, axis=0)
    near = np.all((rays > low - 0.3 * (high - low)) & (rays < high + 0.3 * (high - low)), axis=1)
    pixels[np.flatnonzero(ahead)[near]] = image.to_pixels(rays[near])
    return pixels


def _draw_ranges(figure: Figure, axes: Axes, image: RangeImage, heading: str, details: Sequence[str]) -> None:
    height, width = image.ranges.shape
    low, high = np.nanpercentile(image.ranges, [0.5, 99.5])
    picture = axes.imshow(image.ranges, cmap=range_colours(), vmin=low, vmax=max(high, low + 0.01), interpolation="nearest")
    axes.add_patch(Rectangle((-0.5, -0.5), width, height, fill=False, edgecolor=INK, linewidth=0.6))
    share = float(np.mean(image.valid))
    text = f"{share:.0%} of {width} × {height} pixels returned" if image.organised else f"{image.valid.sum():,} points"
    title(axes, f"{heading}: {text}", details)
    unit = "pixels" if image.organised else "cells of the point cloud's own pitch"
    plain_axes(axes, f"column, {unit}", f"row, {unit}")
    colour_bar(figure, picture, axes, "range, metres")


def _sizes(measurement: Measurement) -> tuple[str, ...]:
    """Return the dimensions of every measured box with their standard deviations, or why there is none."""
    if not measurement.boxes:
        return (f"no box: {reason_in_words(measurement.reason)}",)
    lines = []
    for number, estimate in enumerate(measurement.boxes, start=1):
        sides = zip(estimate.dimensions, estimate.sigma, estimate.basis, strict=True)
        text = " × ".join(
            f"≥ {1000 * value:.0f}" if basis == "open" or sigma is None else f"{1000 * value:.1f} ± {1000 * sigma:.1f}"
            for value, sigma, basis in sides
        )
        lines.append(f"box {number}: {text} mm")
    return tuple(lines)


def _draw_box(axes: Axes, image: RangeImage, box: Box, *, first: bool) -> None:
    facing = facing_camera(box)
    for edge in edges(box, facing):
        if edge.hidden:
            _draw_line(axes, image, edge.ends, color=FIT, linewidth=1.1, linestyle=HIDDEN_DASHES, zorder=2)
        else:
            _draw_line(axes, image, edge.ends, color=FIT, linewidth=2.2, path_effects=line_halo(3.2), zorder=3)
    for name, face in faces(box, facing).items() if first else ():
        pixels = to_image(image, face)
        if room(pixels) > _LABEL_ROOM * image.ranges.shape[1]:
            axes.text(
                *pixels[0], name, ha="center", va="center", fontsize=SMALL, color=INK, path_effects=halo(), clip_on=True, zorder=5
            )


def _draw_truth(axes: Axes, image: RangeImage, truth: Box) -> None:
    for edge in edges(truth, facing_camera(truth)):
        _draw_line(axes, image, edge.ends, **true_line(), zorder=4)


def _draw_blob(axes: Axes, image: RangeImage, blob: Rejected) -> None:
    corners = blob.centre + (2 * CORNERS - (0, 0, 1)) * blob.spread
    u, v = to_image(image, corners).T
    if np.all(np.isnan(u)):
        return
    low, size = (np.nanmin(u), np.nanmin(v)), (np.nanmax(u) - np.nanmin(u), np.nanmax(v) - np.nanmin(v))
    axes.add_patch(Rectangle(low, *size, fill=False, edgecolor=INK, linewidth=0.9, linestyle="-.", path_effects=line_halo(2.2)))


def _draw_line(axes: Axes, image: RangeImage, ends: Points, **style: object) -> None:
    """Draw a straight line of space; in the image of a real lens it is a curve."""
    along: Array = np.linspace(0, 1, _SAMPLES)[:, None]
    u, v = to_image(image, ends[0] + along * (ends[1] - ends[0])).T
    axes.plot(u, v, solid_capstyle="round", **style)  # type: ignore[arg-type]


def _show_all(axes: Axes, image: RangeImage, boxes: Sequence[Box]) -> None:
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


def _key(label: str, **style: object) -> Line2D:
    return Line2D([], [], label=label, **style)  # type: ignore[arg-type]

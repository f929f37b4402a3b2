"""Candidate cameras as small frustums: colour is the score, a ring the winner, a hollow grey one cannot be reached."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize, to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import FuncFormatter

from viewgain.arrays import Points, Points2, Pose, Vector3
from viewgain.geometry import transform
from viewgain.plan import MODEL, NextView
from viewgain.report._colours import FAINT, INK, NORMAL, ON_FLOOR, SMALL
from viewgain.report._style import colour_bar, dots, halo, percent, score_colours
from viewgain.report._viewpoint import Viewpoint

Colour: TypeAlias = tuple[float, float, float] | str
"""Red, green and blue from 0 to 1, or a name."""
SCORE = "share of the volume's\nstandard deviation removed"
"""What the model-based policy's score is, in two lines beside the colour bar."""
FEW = 12
"""Of more candidates than this, those out of reach go without a name."""
_RIM = np.array([[-0.55, -0.42, 0.8], [0.55, -0.42, 0.8], [0.55, 0.42, 0.8], [-0.55, 0.42, 0.8]])


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """What the cameras are drawn onto."""

    axes: Axes
    view: Viewpoint
    centre: Vector3
    """(3,) centre of the object, world frame."""
    floor_z: float
    """Height of the floor, world frame."""
    size: float
    """Length of a frustum, metres."""
    point: float
    """Metres per point of the picture."""
    obstacles: Points2
    """(k, 2) places in the picture that names should keep clear of."""


@dataclass(frozen=True, slots=True)
class Label:
    """A name beside a camera."""

    place: Points2
    """(2,) in the picture."""
    text: str
    bold: bool = False
    distance: float = 15.0
    """From the place, points."""


def draw_candidates(figure: Figure, stage: Stage, plan: NextView, camera_to_world: Pose) -> list[Label]:
    """Draw the candidates of a plan and their colour bar; return their names."""
    scores = np.array([candidate.assessment.score for candidate in plan.candidates if candidate.reachable] or [0.0])
    norm = Normalize(float(scores.min()), float(max(scores.max(), scores.min() + 0.01)))
    labels = []
    for candidate in plan.candidates:
        pose = camera_to_world @ candidate.camera_to_current
        chosen = candidate.index == plan.best
        colour = to_rgb(score_colours()(norm(candidate.assessment.score))) if candidate.reachable else None
        draw_camera(stage, pose, face=colour, edge=INK if candidate.reachable else FAINT)
        middle = _middle(stage, pose)
        if chosen:
            stage.axes.add_patch(
                Circle((middle[0], middle[1]), 0.95 * stage.size, fill=False, edgecolor=INK, linewidth=1.6, zorder=20)
            )
        if not candidate.reachable:
            dots(stage.axes, middle, 26, FAINT, marker="x", linewidths=1.0, zorder=20)
        if candidate.reachable or len(plan.candidates) <= FEW:
            name = f"{candidate.index}: next" if chosen else str(candidate.index)
            labels.append(Label(middle, name, chosen, 25.0 if chosen else 15.0))
    if any(candidate.reachable for candidate in plan.candidates):
        shares = plan.policy == MODEL
        text = SCORE if shares else f"score given by the\npolicy “{plan.policy}”"
        colour_bar(
            figure,
            ScalarMappable(norm, score_colours()),
            stage.axes,
            text,
            format=FuncFormatter(lambda share, _: percent(share)) if shares else None,
        )
    return labels


def draw_camera(stage: Stage, camera_to_world: Pose, *, face: Colour | None, edge: str, scale: float = 1.0) -> None:
    """Draw one frustum, with a line down to the floor.

    Args:
        stage: Where to.
        camera_to_world: (4, 4) its pose.
        face: Colour, or None for a hollow one.
        edge: Colour of its lines.
        scale: Size over that of the others.
    """
    apex, rim = camera_to_world[:3, 3], transform(camera_to_world, _RIM * stage.size * scale)
    view, axes = stage.view, stage.axes
    in_front = float(view.nearness(apex) - view.nearness(stage.centre))
    order = (12 if in_front > 0 else 1) + np.clip(in_front, -0.9, 5)
    foot = np.array([apex, [apex[0], apex[1], stage.floor_z]])
    axes.plot(*view.picture(foot).T, color=FAINT, linewidth=0.5, linestyle=(0, (1, 2)), zorder=0.3)
    dots(axes, view.picture(foot[1]), 3, FAINT, linewidths=0, zorder=0.3)
    sides: list[Points] = [np.array([apex, rim[k], rim[(k + 1) % 4]]) for k in range(4)]
    far_first = sorted([*sides, rim], key=lambda side: float(view.nearness(side).mean()))
    body, lens = ("none", "none") if face is None else (face, _lighter(face))
    axes.add_collection(
        PolyCollection(
            [view.picture(side) for side in far_first], facecolors=[lens if side is rim else body for side in far_first],
            edgecolors=edge, linewidths=0.6, joinstyle="round", zorder=order,
        )
    )  # fmt: skip


def draw_own(stage: Stage, camera_to_world: Pose, earlier: Sequence[Pose]) -> list[Label]:
    """Draw the present camera and the earlier ones; return their names."""
    labels = []
    for number, pose in enumerate(earlier, start=1):
        draw_camera(stage, pose, face=ON_FLOOR, edge=FAINT, scale=0.6)
        labels.append(Label(_middle(stage, pose), f"view {number}"))
    draw_camera(stage, camera_to_world, face=INK, edge=INK, scale=0.6)
    return [*labels, Label(_middle(stage, camera_to_world), "now", bold=True, distance=18.0)]


def draw_labels(stage: Stage, labels: list[Label]) -> None:
    """Write the names beside their cameras, where there is room; names of cameras that coincide are written as one."""
    merged: list[list[Label]] = []
    for label in labels:
        group = next((g for g in merged if np.linalg.norm(g[0].place - label.place) < 0.8 * stage.size), None)
        if group is None:
            merged.append([label])
        else:
            group.append(label)
    taken = [*stage.obstacles, *(group[0].place for group in merged)]
    for group in sorted(merged, key=lambda group: -max(label.distance for label in group)):
        bold = any(label.bold for label in group)
        text = ", ".join(label.text for label in sorted(group, key=lambda label: not label.bold))
        distance = max(label.distance for label in group)
        away = _roomiest(stage, group[0].place, distance + 2.2 * len(text), taken)
        taken.append(group[0].place + away * (distance + 2.2 * len(text) * abs(away[0])) * stage.point)
        written = stage.axes.annotate(
            text,
            (float(group[0].place[0]), float(group[0].place[1])),
            (float(away[0]) * distance, float(away[1]) * distance),
            textcoords="offset points",
            horizontalalignment="left" if away[0] > 0.35 else "right" if away[0] < -0.35 else "center",
            verticalalignment="center",
        )
        written.set(fontsize=NORMAL if bold else SMALL, fontweight="bold" if bold else "normal", color=INK)
        written.set(path_effects=halo(), zorder=30)


def _roomiest(stage: Stage, place: Points2, distance: float, taken: list[Points2]) -> Points2:
    """Return the (2,) unit direction from a camera in which a name has most room, away from the object among equals.

    Args:
        stage: Where it is drawn.
        place: (2,) the camera.
        distance: From there to the middle of the name, points.
        taken: (2,) places that other cameras and names have.
    """
    outward = place - stage.view.picture(stage.centre)
    outward = outward / max(float(np.linalg.norm(outward)), 1e-9)
    angles = np.arctan2(outward[1], outward[0]) + np.pi / 8 * np.array([0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6, 7, -7, 8])
    ways = np.column_stack([np.cos(angles), np.sin(angles)])
    others = np.array([other for other in taken if np.linalg.norm(other - place) > 1e-6]).reshape(-1, 2)
    names = place + ways * distance * stage.point
    clear = np.min(np.linalg.norm(names[:, None] - others[None], axis=-1), axis=1, initial=2.2 * stage.size)
    return np.asarray(ways[np.argmax(clear / stage.size + 0.6 * ways @ outward)])


def _lighter(colour: Colour) -> Colour:
    """Return a colour mixed with white, for the front of a camera, so that it shows where it looks."""
    red, green, blue = (0.45 * part + 0.55 for part in to_rgb(colour))
    return red, green, blue


def _middle(stage: Stage, camera_to_world: Pose) -> Points2:
    """Return the (2,) place in the picture of the middle of a frustum."""
    return stage.view.picture(transform(camera_to_world, np.array([0.0, 0.0, 0.5 * stage.size])))

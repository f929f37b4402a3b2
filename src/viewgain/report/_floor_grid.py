"""The floor of the view in space: a grid with metre marks along its near sides, and an upright scale."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from viewgain.arrays import Array, Mask, Points, Vector3
from viewgain.report._colours import FAINT, GRID, SMALL
from viewgain.report._style import write
from viewgain.report._viewpoint import Viewpoint

_STEPS = (0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0)


@dataclass(frozen=True, slots=True, eq=False)
class Floor:
    """The piece of floor that is shown."""

    low: Array
    """(2,) least x and y, metres, world frame."""
    high: Array
    """(2,) greatest x and y."""
    z: float
    """Its height."""
    top: float
    """Height up to which the upright scale goes."""
    step: float
    """Distance of the lines, metres."""

    @classmethod
    def under(cls, centre: Vector3, places: Points, z: float) -> "Floor":
        """Return the piece around ``centre`` (3,) that has all ``places`` (k, 3) above it, in whole steps."""
        reach = float(np.abs(places[:, :2] - centre[:2]).max()) + 0.05
        step = next((step for step in _STEPS if 2 * reach / step <= 9), _STEPS[-1])
        low, high = np.floor((centre[:2] - reach) / step) * step, np.ceil((centre[:2] + reach) / step) * step
        top = max(np.ceil(float(places[:, 2].max()) / step), np.floor(z / step) + 1) * step
        return cls(low, high, z, top, step)

    def holds(self, points: Points) -> Mask:
        """Return the (n,) mask of points that are shown."""
        inside = np.all((points[:, :2] > self.low) & (points[:, :2] < self.high), axis=1)
        return np.asarray(inside & (points[:, 2] < self.top))

    def width_from(self, view: Viewpoint) -> float:
        """Return its width in the picture, metres."""
        corners = np.array([[x, y, 0.0] for x in (self.low[0], self.high[0]) for y in (self.low[1], self.high[1])])
        return float(np.ptp(view.picture(corners)[:, 0]))

    def upright(self, view: Viewpoint) -> Points:
        """Return the (2, 3) ends of the upright scale: on the corner that is farthest to the left."""
        corners = np.array([[x, y, self.z] for x in (self.low[0], self.high[0]) for y in (self.low[1], self.high[1])])
        foot = corners[np.argmin(view.picture(corners)[:, 0])]
        return np.array([foot, [*foot[:2], self.top]])

    def ticks(self, axis: int) -> Array:
        """Return the marks along x (0) or y (1)."""
        return np.arange(round(self.low[axis] / self.step), round(self.high[axis] / self.step) + 1) * self.step


def draw_floor(axes: Axes, floor: Floor, view: Viewpoint) -> None:
    """Draw grid, marks and the upright scale."""
    corners = np.array([[floor.low[0], floor.low[1]], [floor.high[0], floor.low[1]], floor.high, [floor.low[0], floor.high[1]]])
    sheet = view.picture(np.column_stack([corners, np.full(4, floor.z)]))
    axes.fill(*sheet.T, facecolor="#fafbfc", edgecolor=GRID, linewidth=0.8, zorder=0)
    for axis in (0, 1):
        for tick in floor.ticks(axis):
            ends = np.full((2, 3), floor.z)
            ends[:, axis], ends[:, 1 - axis] = tick, (floor.low[1 - axis], floor.high[1 - axis])
            axes.plot(*view.picture(ends).T, color=GRID, linewidth=0.6, zorder=0.1)
        _draw_marks(axes, floor, view, axis)
    _draw_upright(axes, floor, view)


def _draw_marks(axes: Axes, floor: Floor, view: Viewpoint, axis: int) -> None:
    """Write the numbers of one axis along the side of the floor that is nearer to the viewer."""
    across = 1 - axis
    near = floor.high[across] if view.towards[across] > 0 else floor.low[across]
    outward = np.zeros(3)
    outward[across] = np.sign(near - (floor.low + floor.high)[across] / 2)
    sideways = "left" if view.picture(outward)[0] > 0 else "right"
    place = np.full(3, floor.z)
    place[across] = near
    for tick in floor.ticks(axis)[1:-1]:
        place[axis] = tick
        where = view.picture(place + 0.18 * floor.step * outward)
        write(axes, where, _number(tick), fontsize=SMALL - 1, color=FAINT, ha=sideways, va="top")
    place[axis] = (floor.low + floor.high)[axis] / 2
    name = f"{'xy'[axis]}, metres"
    write(axes, view.picture(place + 0.95 * floor.step * outward), name, fontsize=SMALL, color=FAINT, ha=sideways, va="top")


def _draw_upright(axes: Axes, floor: Floor, view: Viewpoint) -> None:
    """Draw the z scale at the floor's leftmost corner."""
    foot = floor.upright(view)[0]
    ticks = np.arange(np.ceil(floor.z / floor.step + 0.3), round(floor.top / floor.step) + 1) * floor.step
    axes.plot(*view.picture(floor.upright(view)).T, color=FAINT, linewidth=0.7, zorder=0.2)
    for tick in ticks:
        u, v = view.picture(np.array([*foot[:2], tick]))
        axes.plot([u - 0.08 * floor.step, u], [v, v], color=FAINT, linewidth=0.7, zorder=0.2)
        write(axes, np.array([u - 0.15 * floor.step, v]), _number(tick), fontsize=SMALL - 1, color=FAINT, ha="right", va="center")
    u, v = view.picture(np.array([*foot[:2], floor.top + 0.35 * floor.step]))
    axes.update_datalim([(u, v + 0.5 * floor.step)])
    write(axes, np.array([u, v]), "z, metres", fontsize=SMALL, color=FAINT, ha="center", va="bottom")


def _number(value: float) -> str:
    return f"{value + 0.0:.2f}".rstrip("0").rstrip(".").replace("-", "−")

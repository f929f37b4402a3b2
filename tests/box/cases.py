"""Boxes in front of a camera, for hypothesis, and rays around them."""

import numpy as np
from hypothesis import strategies as st

from viewgain.box import Box
from viewgain.geometry import inverse
from viewgain.scenes import orbit_pose, standing_box


def seen_box(extents: list[float], yaw: float, elevation: float, distance: float, azimuth: float, roll: float) -> Box:
    """Return a standing box in the frame of a camera that looks at its centre."""
    box = standing_box(np.array(extents), yaw=yaw)
    reach = float(np.linalg.norm(box.extents)) / 2
    return box.in_frame(inverse(orbit_pose(box.centre, azimuth, np.deg2rad(elevation), reach + distance, roll)))


boxes = st.builds(
    seen_box,
    st.lists(st.floats(0.05, 0.8), min_size=3, max_size=3),
    st.floats(0, 2 * np.pi),
    st.floats(-5, 89),
    st.floats(0.2, 2),
    st.floats(0, 2 * np.pi),
    st.floats(-3, 3),
)
"""Boxes wholly in front of the camera, from nearly level to nearly overhead."""


def rays_around(box: Box, count: int, seed: int) -> np.ndarray:
    """Return (count, 3) unit rays, most of them at the box or just beside it."""
    rng = np.random.default_rng(seed)
    share = rng.dirichlet(np.full(8, 0.4), count)
    aims = share @ box.corners() + rng.normal(0, 0.03, (count, 3))
    return np.asarray(aims / np.linalg.norm(aims, axis=1, keepdims=True))

"""Cloud, box and candidate cameras in space, seen by a viewer infinitely far away, world z up, all axes at one scale.

The projection is our own: a handful of lines, and text and depth order stay in our hands.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import PercentFormatter

from viewgain.arrays import Array, Mask, Points, Points2, Pose, Vector3
from viewgain.box import Box
from viewgain.geometry import transform
from viewgain.measure import Measurement
from viewgain.plan import NextView
from viewgain.report._style import (
    FAINT, FIT, GRID, HIDDEN_DASHES, INK, NORMAL, ON_BOX, ON_FLOOR, SMALL, TRUE_DASHES, TRUTH, colour_bar, halo, legend_below,
    line_halo, new_figure, score_colours, title,
)  # fmt: skip
from viewgain.report._wire import edges, face_labels, facing_direction, open_edges, reported_box
from viewgain.scans import Scan

"""How the stations of a built set stand to each box: what the constraints of a time-of-flight camera are worked out of."""

import numpy as np

from viewgain.box import Box
from viewgain.camera import sensor
from viewgain.datasets._dataset import Dataset
from viewgain.errors import DataError
from viewgain.gain import BoxViews


def knows_poses(data: Dataset) -> bool:
    """Return whether a data set knows how its boxes stand to the cameras."""
    return "boxes" in data.manifest.recipe


def box_views(data: Dataset) -> dict[int, BoxViews]:
    """Return each box with the stations of its rig, in rig order and without jitter.

    Every sample holds the box and the stations as its own camera sees them, so any one of a box will do. Poses are as they are
    stored, in single precision.

    Raises:
        DataError: If the data set holds no simulated boxes: of recordings nobody knows how a box stood to the camera.
        ConfigError: If a camera file of the recipe is no longer there.
    """
    if not knows_poses(data):
        raise DataError(f"{data.folder}: got no boxes of known pose, which incidence and border are of; wanted simulated boxes")
    cameras = {each.name: each.intrinsics for each in map(sensor, data.manifest.recipe["boxes"]["cameras"])}
    views = {}
    for number, row in zip(*np.unique(data.column("object"), return_index=True), strict=True):
        sample = data[int(row)]
        box = Box(np.asarray(sample.object_to_camera, dtype=float), np.asarray(sample.dims, dtype=float))
        stations = np.roll(np.asarray(sample.candidates, dtype=float), sample.view, axis=0)
        views[int(number)] = BoxViews(box, stations, cameras[sample.camera])
    return views

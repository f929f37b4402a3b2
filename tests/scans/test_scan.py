"""The scan as a value: what it drops, what it refuses, what it gives back."""

import numpy as np
import pytest

from tests.scans import files
from viewgain.errors import ConfigError, ScanError
from viewgain.scans import MIN_POINTS, Dropped, Scan


def test_invalid_returns_are_dropped_and_counted() -> None:
    image = files.cloud(192).reshape(12, 16, 3)
    image[0, 0] = 0
    image[0, 1, 2] = np.nan
    image[0, 2, 0] = np.inf
    image[0, 3] = [np.nan, np.inf, 0]
    scan = Scan.from_array(image, intrinsics=files.CAMERA)
    assert scan.dropped == Dropped(not_a_number=2, infinite=1, zero=1)
    assert scan.dropped.total == 4
    np.testing.assert_array_equal(scan.pixels, np.arange(4, 192))
    organised = scan.organised()
    assert np.isnan(organised[0, :4]).all()
    np.testing.assert_array_equal(organised.reshape(-1, 3)[4:], image.reshape(-1, 3)[4:])


def test_too_few_points_and_wrong_shapes_are_refused() -> None:
    assert len(Scan.from_array(files.cloud(MIN_POINTS)).points) == MIN_POINTS
    with pytest.raises(ScanError, match="99 valid points, wanted at least 100"):
        Scan.from_array(files.cloud(99))
    with pytest.raises(ScanError, match="wanted \\(n, 3\\)"):
        Scan.from_array(np.zeros((5, 4)))
    with pytest.raises(ScanError, match="16 x 12 pixels"):
        Scan.from_array(files.cloud(), intrinsics=files.CAMERA)
    with pytest.raises(ConfigError, match="not a rigid motion"):
        Scan.from_array(files.cloud(), camera_to_world=2 * np.eye(4))
    with pytest.raises(ScanError, match="an unorganised cloud has no image"):
        Scan.from_array(files.cloud()).organised()


def test_another_pose_changes_nothing_else() -> None:
    scan = Scan.from_array(files.cloud())
    posed = scan.posed(files.POSE)
    np.testing.assert_allclose(posed.camera_to_world, files.POSE, atol=1e-12)
    assert posed.points is scan.points or np.array_equal(posed.points, scan.points)
    assert scan.camera_to_world is None

"""Turned and mirrored samples: what every candidate sees of the points stays what it was, or becomes its mirror image."""

import numpy as np
import pytest
import torch

from viewgain.geometry import pose, rotation_from_rotvec
from viewgain.training import DataSettings
from viewgain.training._moved import moved_alike


def batch(seed: int) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    rng = np.random.default_rng(seed)
    points = torch.from_numpy(rng.normal(0, 1, (6, 20, 3))).float()
    mask = torch.from_numpy(rng.random((6, 20)) < 0.8)
    made = [pose(rotation_from_rotvec(rng.normal(0, 1, 3)), rng.normal(0, 1, 3)) for _ in range(24)]
    return points * mask[..., None], mask, torch.from_numpy(np.stack(made)).float().reshape(6, 4, 4, 4)


def seen(points: torch.Tensor, poses: torch.Tensor) -> torch.Tensor:
    """Return (B, V, n, 3) points in each candidate's camera."""
    return (points[:, None] - poses[:, :, None, :3, 3]) @ poses[..., :3, :3]


@pytest.mark.parametrize(("turn", "mirror"), [(0.0, False), (25.0, False), (0.0, True), (25.0, True)])
def test_candidates_see_the_same_or_its_mirror_image(turn: float, mirror: bool) -> None:
    points, mask, poses = batch(1)
    settings = DataSettings(frame="camera", turn_deg=turn, mirror=mirror)
    moved, moved_poses = moved_alike(points, mask, poses, settings, torch.Generator().manual_seed(2))
    before, after = (each * mask[:, None, :, None] for each in (seen(points, poses), seen(moved, moved_poses)))
    flipped = before * torch.tensor([-1.0, 1.0, 1.0])
    same = [torch.allclose(one, two, atol=1e-4) for one, two in zip(before, after, strict=True)]
    mirrored = [torch.allclose(one, two, atol=1e-4) for one, two in zip(flipped, after, strict=True)]
    assert all(one or (two and mirror) for one, two in zip(same, mirrored, strict=True))
    assert mirror == any(mirrored)
    turns = moved_poses[..., :3, :3]
    torch.testing.assert_close(turns @ turns.transpose(2, 3), torch.eye(3).expand(6, 4, 3, 3), atol=1e-5, rtol=0)
    assert torch.all(torch.linalg.det(turns) > 0)
    assert (turn > 0 or mirror) != torch.allclose(moved, points)

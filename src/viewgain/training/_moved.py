"""Samples shown in other axes of the present camera, or in a mirror: points and candidates move alike, so no score changes."""

import torch
from torch import Tensor

from viewgain.training._settings import DataSettings


def moved_alike(
    clouds: Tensor, mask: Tensor, candidates: Tensor, settings: DataSettings, generator: torch.Generator
) -> tuple[Tensor, Tensor]:
    """Return clouds and candidates after random turns and mirrors; the same numbers are drawn whatever the settings.

    Args:
        clouds: (B, n, 3) points in the present camera; zero where there is none.
        mask: (B, n) where there is one.
        candidates: (B, V, 4, 4) poses in the present camera.
        settings: How far: :attr:`DataSettings.turn_deg` about a random axis, and whether half of all are mirrored.
        generator: Of torch, on the device of the clouds.
    """
    count, device = len(clouds), clouds.device
    axis = torch.nn.functional.normalize(torch.randn(count, 3, generator=generator, device=device), dim=1)
    angle = (2 * torch.rand(count, generator=generator, device=device) - 1) * torch.deg2rad(torch.tensor(settings.turn_deg))
    mirrored = (torch.rand(count, generator=generator, device=device) < 0.5) & settings.mirror
    turns = torch.linalg.matrix_exp(_crossed(axis * angle[:, None]))  # (B, 3, 3)
    flips = torch.ones(count, 3, device=device)
    flips[:, 0] = torch.where(mirrored, -1.0, 1.0)
    points = (clouds * flips[:, None]) @ turns.transpose(1, 2) * mask[..., None]
    poses = candidates.clone()
    # A mirror image of a camera looks through a mirror itself: F R F is a turn again, and its image is flipped.
    poses[..., :3, :3] = turns[:, None] @ (flips[:, None, :, None] * candidates[..., :3, :3] * flips[:, None, None, :])
    poses[..., :3, 3] = (candidates[..., :3, 3] * flips[:, None]) @ turns.transpose(1, 2)
    return points, poses


def _crossed(vectors: Tensor) -> Tensor:
    """Return (B, 3, 3) the matrices whose product with a vector is the cross product of (B, 3) vectors with it."""
    x, y, z = vectors.unbind(1)
    nothing = torch.zeros_like(x)
    return torch.stack((nothing, -z, y, z, nothing, -x, -y, x, nothing), dim=1).reshape(-1, 3, 3)

"""The inputs that all networks share, checked."""

import torch
from torch import Tensor

from viewgain.errors import ConfigError
from viewgain.network._neighbours import unrepeated
from viewgain.network._settings import NetworkSettings


def prepared(
    points: Tensor, mask: Tensor | None, view_state: Tensor | None, settings: NetworkSettings
) -> tuple[Tensor, Tensor | None]:
    """Return the mask (B, N) of real points, each place once, and the view state (B, V) as numbers or None.

    Raises:
        ConfigError: If shapes do not fit, or a view state is missing or not wanted.
    """
    if points.ndim != 3 or points.shape[-1] != 3:
        raise ConfigError(f"network: got points {tuple(points.shape)}, wanted (batch, number, 3)")
    if mask is None:
        mask = torch.ones(points.shape[:2], dtype=torch.bool, device=points.device)
    elif mask.shape != points.shape[:2] or mask.dtype != torch.bool:
        raise ConfigError(f"network: got a mask {tuple(mask.shape)} of {mask.dtype}, wanted {tuple(points.shape[:2])} of bool")
    if (view_state is not None) != settings.with_view_state:
        wanted = "a view state" if settings.with_view_state else "no view state"
        raise ConfigError(f"network {settings.kind}: wanted {wanted}; take another kind or change what it is given")
    if view_state is not None and view_state.shape != (len(points), settings.views):
        wanted = f"{(len(points), settings.views)}"
        raise ConfigError(f"network {settings.kind}: got a view state {tuple(view_state.shape)}, wanted {wanted}")
    return unrepeated(points, mask), None if view_state is None else view_state.to(points.dtype)

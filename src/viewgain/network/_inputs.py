"""What all networks have in common: their inputs, checked, and that no place counts twice."""

from abc import ABC, abstractmethod

import torch
from torch import Tensor, nn

from viewgain.errors import ConfigError
from viewgain.network._neighbours import unrepeated
from viewgain.network._settings import NetworkSettings


class ScoreNetwork(nn.Module, ABC):
    """A partial cloud, and with the view state where the camera has been, to a score for every candidate view.

    Shapes: points (B, N, 3), mask (B, N), view state (B, V) to (B, V); with uncertainty (B, V, 2) or (B, V, 4), see
    :func:`viewgain.network.sigma_of`.
    """

    def __init__(self, settings: NetworkSettings) -> None:
        """Keep the settings."""
        super().__init__()
        self.settings = settings

    def forward(self, points: Tensor, mask: Tensor | None = None, view_state: Tensor | None = None) -> Tensor:
        """Return scores: the present view first without the view state, in rig order with it.

        Args:
            points: (B, N, 3) points, normalised as the network was trained; the padding may be any finite numbers.
            mask: (B, N) which points are real, at least one per cloud (else its scores are NaN); None for all. Points that lie
                exactly where an earlier one lies are left out.
            view_state: (B, V) 1 for visited views; None for a network without it. For a network that is told poses
                they stand here, (B, V, 4, 4), and the scores come in their order.

        Raises:
            ConfigError: If shapes do not fit, or a view state is missing or not wanted.
        """
        if points.ndim != 3 or points.shape[-1] != 3:
            raise ConfigError(f"network: got points {tuple(points.shape)}, wanted (batch, number, 3)")
        if mask is None:
            mask = torch.ones(points.shape[:2], dtype=torch.bool, device=points.device)
        if mask.shape != points.shape[:2] or mask.dtype != torch.bool:
            wanted = f"{tuple(points.shape[:2])} of bool"
            raise ConfigError(f"network: got a mask {tuple(mask.shape)} of {mask.dtype}, wanted {wanted}")
        self._check(view_state, len(points))
        return self.scored(points, unrepeated(points, mask), None if view_state is None else view_state.to(points.dtype))

    def located(self, points: Tensor, mask: Tensor) -> tuple[Tensor, Tensor]:
        """Return scores as :meth:`forward`, and (B, V) logits of the present view being each of the rig's.

        Args:
            points: (B, N, 3) as for :meth:`forward`.
            mask: (B, N) likewise.

        Raises:
            ConfigError: If the network does not say from where a cloud was seen.
        """
        raise ConfigError(f"network {self.settings.kind}: does not say from where a cloud was seen; wanted compact")

    def standardised(self, points: Tensor) -> Tensor:
        """Return (B, N, 3) points less the offset and over the scale of the settings."""
        settings = self.settings
        return (points - points.new_tensor(settings.offset)) * (1 / settings.scale) if settings.standardises else points

    @abstractmethod
    def scored(self, points: Tensor, mask: Tensor, view_state: Tensor | None) -> Tensor:
        """Return as :meth:`forward`, of sound inputs in which no real point is repeated: what is exported."""

    def _check(self, view_state: Tensor | None, batch: int) -> None:
        settings = self.settings
        if (view_state is not None) != settings.with_view_state:
            wanted = "a view state" if settings.with_view_state else "no view state"
            raise ConfigError(f"network {settings.kind}: wanted {wanted}; take another kind or change what it is given")
        if view_state is not None and view_state.shape != (batch, settings.views):
            wanted = str((batch, settings.views))
            raise ConfigError(f"network {settings.kind}: got a view state {tuple(view_state.shape)}, wanted {wanted}")


def joined(cloud: Tensor, view_state: Tensor | None) -> Tensor:
    """Return (B, C) the cloud's feature, with the view state behind it where there is one."""
    return cloud if view_state is None else torch.cat((cloud, view_state), dim=-1)

"""What a network is made of, as a record. The defaults are those of PC-NBV (Zeng et al. 2020, public code)."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from viewgain.errors import ConfigError
from viewgain.rigs import rig

Kind: TypeAlias = Literal["pc_nbv", "pc_nbv_noview", "compact", "compact_view", "pose_scores"]
"""``pc_nbv`` and ``compact_view`` are told which views were visited, ``pc_nbv_noview`` and ``compact`` are not; ``pose_scores``
is told the candidates' poses, so it scores any number of views of any rig."""
Uncertainty: TypeAlias = Literal["none", "gaussian", "evidential"]
"""Whether a network says how sure it is of each score."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NetworkSettings:
    """One network; two of equal settings have the same parameters in the same order."""

    kind: Kind = "pc_nbv"
    """Which network."""
    views: int = 33
    """V, the candidate views of the rig; of ``pose_scores`` the most that are trained on at once."""
    points: int = 512
    """Points per cloud that it is trained and exported for; it runs on any number."""
    neighbours: int = 16
    """k, the neighbours of each point."""
    growth: int = 12
    """Channels that each layer of a dense edge convolution adds (the paper-size networks)."""
    blocks: int = 4
    """Dense edge convolutions (the paper-size networks): 4 of growth 12 make 264 features."""
    shared: tuple[int, ...] = (1024, 1024)
    """Widths of the layers that every point passes (the paper-size networks)."""
    head: tuple[int, ...] = (1024, 512, 256)
    """Widths of the layers that the cloud's one feature passes (the paper-size networks); a last one gives the V scores."""
    width: int = 32
    """Channels of the first layers of the compact networks; all others are multiples of it."""
    centres: tuple[int, int] = (64, 16)
    """Points that a cloud is taken together to, first and then (the compact networks)."""
    rig: str = ""
    """The rig whose views look at the points from where they stand (the compact networks, points in the object's frame); empty:
    a view knows nothing of its place but what it learns."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """What the coordinates are lessened by before the first layer, units of the input: about where whole scans in metres lie."""
    scale: float = 1.0
    """What they are divided by then: a layer that sees centimetres beside metres of distance learns them slowly."""
    uncertainty: Uncertainty = "none"
    """``gaussian``: a second number per view, the logarithm of the score's variance. ``evidential``: three more, a distribution
    over the score's mean and variance (Amini et al. 2020)."""

    def __post_init__(self) -> None:
        if self.kind not in get_args(Kind) or self.uncertainty not in get_args(Uncertainty):
            wanted = f"one of {', '.join(get_args(Kind))} and one of {', '.join(get_args(Uncertainty))}"
            raise ConfigError(f"network: got kind {self.kind!r} and uncertainty {self.uncertainty!r}, wanted {wanted}")
        widths = (self.growth, self.width, *self.shared, *self.head)
        counts = (self.views, self.points, self.neighbours, self.blocks, *self.centres)
        if min(*widths, *counts) < 1 or not self.shared or not self.head:
            raise ConfigError("network: wanted views, points, neighbours, blocks, centres and all widths of at least one")
        if not np.all(np.isfinite([*self.offset, self.scale])) or self.scale <= 0:
            raise ConfigError(
                f"network: got offset {self.offset} and scale {self.scale}, wanted finite numbers and a positive scale"
            )
        if self.standardises and (self.rig or self.with_poses):
            raise ConfigError("network: got an offset or a scale where views stand among the points, wanted neither")
        if self.rig and self.kind not in ("compact", "compact_view"):
            raise ConfigError(f"network: got rig {self.rig!r} for kind {self.kind}, whose views do not look; wanted none")
        if self.rig and len(rig(self.rig).stations) != self.views:
            raise ConfigError(f"network: got views = {self.views}, wanted the {len(rig(self.rig).stations)} of rig {self.rig!r}")

    @property
    def standardises(self) -> bool:
        """Whether coordinates are moved or scaled before the first layer."""
        return self.scale != 1 or any(self.offset)

    @property
    def with_poses(self) -> bool:
        """Whether the network is told the candidates' poses, and answers in their order."""
        return self.kind == "pose_scores"

    @property
    def with_view_state(self) -> bool:
        """Whether the network is told which views were visited, and answers in rig order instead of the present view first."""
        return self.kind in ("pc_nbv", "compact_view")

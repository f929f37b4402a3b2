"""How well a depth camera measures: range noise, lateral noise, lost returns, and what calibration leaves behind."""

from dataclasses import dataclass, replace

import numpy as np

from viewgain.arrays import Array
from viewgain.camera._intrinsics import Intrinsics
from viewgain.errors import ConfigError


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """A depth camera: geometry, noise and systematic error. Ranges are radial distances along each pixel's ray, metres."""

    name: str
    """Preset name, or the file it came from."""
    intrinsics: Intrinsics
    """Where each pixel looks."""
    range_min: float = 0.1
    """Nearest measurable range, metres."""
    range_max: float = 4.0
    """Farthest measurable range, metres."""
    noise_constant: float = 0.0
    """Standard deviation of the range at zero range and head-on incidence, metres."""
    noise_per_metre: float = 0.005
    """Growth of the standard deviation with range, metres per metre."""
    noise_per_square_metre: float = 0.0
    """Growth of the standard deviation with squared range, metres per square metre."""
    lateral_px: float = 0.3
    """Standard deviation of where in the image a pixel really looked, pixels."""
    grazing_start: float = np.deg2rad(70.0)
    """Incidence angle at which returns begin to be lost, radians."""
    grazing_end: float = np.deg2rad(85.0)
    """Incidence angle at which no return comes back, radians."""
    flying_share: float = 0.4
    """Share of pixels on a depth edge that mix foreground and background."""
    scale_sd: float = 0.003
    """Standard deviation of the relative range error that remains after calibration."""
    offset_sd: float = 0.003
    """Standard deviation of the constant range error that remains after calibration, metres."""

    edge_sd_px: float = 0.07
    """Standard deviation of where the camera shows an edge of an outline as a whole, pixels: mixed pixels and the filters
    against them shift whole edges. Chosen so that 90 % intervals hold 90 % on our own simulated scans."""
    lost_edge_sd_px: float = 0.3
    """The same for an edge of a face whose returns are all lost to grazing incidence: only missing returns show it."""

    def __post_init__(self) -> None:
        if not 0 <= self.range_min < self.range_max:
            raise ConfigError(f"camera {self.name}: got range {self.range_min} to {self.range_max} m, wanted 0 <= min < max")
        if not 0 < self.grazing_start < self.grazing_end <= np.pi / 2:
            raise ConfigError(f"camera {self.name}: grazing angles must satisfy 0 < start < end <= 90 degrees")

    def range_sigma(self, ranges: Array, cosine: Array) -> Array:
        """Return the standard deviation of the measured range, metres.

        Grows with range and as 1/sqrt(cos) with the angle of incidence (less light returns); the lateral noise of the pixel
        adds what it costs on a slope: pitch times range times tan(incidence).

        Args:
            ranges: (n,) true ranges, metres.
            cosine: (n,) cosine of the angle of incidence; floored at 0.15.
        """
        cosine = np.maximum(cosine, 0.15)
        axial = self.noise_constant + ranges * (self.noise_per_metre + ranges * self.noise_per_square_metre)
        slope = self.lateral_px / self.intrinsics.fx * ranges * np.sqrt(1 - cosine**2) / cosine
        return np.asarray(np.hypot(axial / np.sqrt(cosine), slope))

    def loss(self, cosine: Array) -> Array:
        """Return the (n,) probability that a return is lost to grazing incidence: a ramp between the two grazing angles."""
        angle = np.arccos(np.clip(cosine, 0.0, 1.0))
        return np.clip((angle - self.grazing_start) / (self.grazing_end - self.grazing_start), 0.0, 1.0)

    def edge_sigma(self, cosine: Array) -> Array:
        """Return the (k,) standard deviation of whole edges, pixels, of faces seen under these cosines of incidence."""
        return np.asarray(self.edge_sd_px + self.lost_edge_sd_px * self.loss(cosine))

    def without_systematic(self) -> "Sensor":
        """Return the same camera with perfect calibration (no scale and offset error)."""
        return replace(self, scale_sd=0.0, offset_sd=0.0)


def _preset(name: str, size: tuple[int, int], field_of_view_deg: tuple[float, float], **numbers: float) -> Sensor:
    horizontal, vertical = np.deg2rad(field_of_view_deg)
    return Sensor(name=name, intrinsics=Intrinsics.from_field_of_view(*size, horizontal, vertical), **numbers)


PRESETS = {
    # Size, field of view and range: pmd CamBoard pico flexx data sheet. Noise: its "1 % of distance" read as two sigma, so
    # 0.5 %. Lateral noise, grazing angles, flying share and the two systematic terms: assumed.
    "pico_flexx": _preset("pico_flexx", (224, 171), (62.0, 45.0), range_max=4.0),
    # Size and field of view: Asus Xtion Pro Live data sheet. Noise: Nguyen et al. 2012 for the same PrimeSense sensor,
    # 0.0012 + 0.0019 (z - 0.4)^2 = 0.0015 - 0.00152 z + 0.0019 z^2 m, lateral 0.8 px. Systematic terms: assumed.
    "xtion": _preset(
        "xtion", (640, 480), (58.0, 45.0), range_min=0.5, range_max=3.5, noise_constant=0.0015, noise_per_metre=-0.00152,
        noise_per_square_metre=0.0019, lateral_px=0.8, scale_sd=0.005,
    ),
}  # fmt: skip
"""Cameras by name; a number without a source in the comment above it is assumed."""


def sensor(name: str) -> Sensor:
    """Return a preset camera by name.

    Raises:
        ConfigError: If there is no preset of that name; the message lists them.
    """
    if name not in PRESETS:
        raise ConfigError(f"camera {name!r} is not known; choose one of {', '.join(sorted(PRESETS))}")
    return PRESETS[name]

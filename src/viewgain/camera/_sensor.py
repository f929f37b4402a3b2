"""How well a depth camera measures: noise, lost returns, edges, and what calibration leaves behind. Numbers: docs/cameras.md."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from viewgain.arrays import Array
from viewgain.camera._checks import check_numbers
from viewgain.camera._intrinsics import Intrinsics
from viewgain.errors import ConfigError

SPEED_OF_LIGHT = 299_792_458.0
"""Metres per second."""
LEAST_COSINE = 0.15
"""No formula of noise is trusted beyond this cosine of incidence (81 degrees); there the noise stays as it is."""
LEAST_REFLECTIVITY = 0.01
"""Blacker than this nothing is; keeps the noise finite."""
LEAST_RANGE = 1e-3
"""Metres; keeps a negative power of the range finite."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """A depth camera: geometry, noise and systematic error. Ranges are radial distances along each pixel's ray, metres."""

    name: str
    """Preset name, or the file it came from."""
    intrinsics: Intrinsics
    """Where each pixel looks."""
    kind: Literal["tof", "structured_light"] = "tof"
    """What limits it: the light that returns (time of flight) or the disparity of a projected pattern."""
    range_min: float = 0.1
    """Nearest measurable range, metres."""
    range_max: float = 4.0
    """Farthest measurable range, metres."""
    unambiguous: float = np.inf
    """Range after which the phases wrap, metres, once all modulation frequencies have been compared."""
    modulation_hz: float | None = None
    """Highest modulation frequency; None if unknown or not a time-of-flight camera."""

    noise_constant: float = 0.0
    """Standard deviation of the range at zero range and head-on incidence, metres."""
    noise_per_metre: float = 0.005
    """Growth of the standard deviation with range, metres per metre."""
    noise_per_square_metre: float = 0.0
    """Growth of the standard deviation with squared range, metres per square metre."""
    noise_incidence_power: float = 0.5
    """The three above grow as this power of 1 / cos(incidence); 0.5 if photons limit them, since less light returns."""
    noise_grazing: float = 0.0
    """Extra standard deviation at 1 m and 45 degrees of incidence, metres; grows as (t / (pi / 2 - t))^2 with incidence t."""
    noise_grazing_range_power: float = 0.0
    """The extra standard deviation grows as this power of the range."""
    noise_reflectivity: float = 0.5
    """Reflectivity of the target that the noise holds for."""
    jitter_px: float = 0.0
    """Standard deviation of where in the image a pixel really looks, independent per pixel and scan; it shows on slopes."""
    lateral_px: float = 0.3
    """Standard deviation of where a depth edge appears, pixels, on a face seen head-on."""
    lateral_grazing_px: float = 0.0
    """Its growth with incidence t: this times t / (pi / 2 - t), pixels."""

    weakest: float = 0.0
    """Weakest amplitude that still gives a return: reflectivity * cos(incidence) / range^2, so that a white surface seen head-on
    at 1 m has amplitude one."""
    grazing_start: float = np.deg2rad(70.0)
    """Incidence angle at which returns begin to be lost, radians."""
    grazing_end: float = np.deg2rad(85.0)
    """Incidence angle at which no return comes back, radians."""
    short_floor: float = 0.0
    """Share of the floor's pixels beside an object that read short, by light that took a detour over it or inside the lens."""
    footprint_px: float = 1.0
    """Width of the square that one pixel integrates over, lens blur included, pixels."""
    flying_filter: float = 0.0
    """The camera drops a pixel whose range differs by more than this share of it from both neighbours on a line; 0: no filter."""

    scale_sd: float = 0.003
    """Standard deviation of the relative range error that remains after calibration."""
    offset_sd: float = 0.003
    """Standard deviation of the constant range error that remains after calibration, metres."""
    scale: float = 0.0
    """Known relative range error of this very camera: measuring takes it off (``viewgain calibrate`` finds it)."""
    offset: float = 0.0
    """Known constant range error, metres, taken off likewise."""
    wiggle: float = 0.0
    """Amplitude of the periodic range error that remains after calibration, metres."""
    wiggle_period: float = 0.5
    """Its period, metres of range."""
    step: float = 0.0
    """Quantum of the reported range, metres."""
    step_per_square_metre: float = 0.0
    """Growth of the quantum with squared range, metres per square metre: the quantum of a disparity."""

    edge_sd_px: float = 0.07
    """Standard deviation of where the camera shows an edge of an outline as a whole, pixels: mixed pixels and the filters
    against them shift whole edges. Chosen so that 90 % intervals hold 90 % on our own simulated scans."""
    lost_edge_sd_px: float = 0.3
    """The same for an edge of a face whose returns are all lost to grazing incidence: only missing returns show it."""
    spread: float = 1.0
    """Factor on the standard deviations that the likelihood of a scan claims, learned on simulated scans (docs/accuracy.md)."""

    def __post_init__(self) -> None:
        check_numbers(self, f"camera {self.name}")
        if self.kind not in ("tof", "structured_light"):
            raise ConfigError(f"camera {self.name}: got kind {self.kind!r}, wanted 'tof' or 'structured_light'")
        if not -0.5 < self.scale < 0.5:
            raise ConfigError(f"camera {self.name}: got scale = {self.scale}, wanted a relative error between -0.5 and 0.5")
        if not self.range_min < self.range_max:
            raise ConfigError(f"camera {self.name}: got range {self.range_min} to {self.range_max} m, wanted 0 <= min < max")
        if not 0 < self.grazing_start < self.grazing_end <= np.pi / 2:
            raise ConfigError(f"camera {self.name}: grazing angles must satisfy 0 < start < end <= 90 degrees")
        if self._least_axial() < 0:
            raise ConfigError(f"camera {self.name}: the noise is negative somewhere between 0 and {self.range_max} m")

    @property
    def wavelength(self) -> float:
        """Metres of range per turn of the highest modulation frequency; infinite if there is none."""
        return SPEED_OF_LIGHT / (2 * self.modulation_hz) if self.modulation_hz and self.kind == "tof" else np.inf

    def range_sigma(self, ranges: Array, cosine: Array, *, reflectivity: Array | float | None = None) -> Array:
        """Return the standard deviation of the measured range, metres.

        (c0 + c1 r + c2 r^2) cos(t)^-power + grazing r^p (t / (pi / 2 - t))^2, and in quadrature what the jitter of the pixel
        costs on a slope: its angle times r tan(t). The lateral noise of depth edges is not in it.

        Args:
            ranges: (n,) true ranges r, metres.
            cosine: (n,) cosine of the angle of incidence t; floored at 0.15.
            reflectivity: (n,) or one reflectivity of the target; None for the one that the noise was stated for. With half of it,
                half the photons return to a time-of-flight camera and its noise is sqrt(2) times as large.
        """
        cosine = np.clip(cosine, LEAST_COSINE, 1.0)
        axial = self._axial(ranges) / cosine**self.noise_incidence_power
        if self.noise_grazing > 0:
            growth = np.maximum(ranges, LEAST_RANGE) ** self.noise_grazing_range_power
            axial = axial + self.noise_grazing * growth * _grazing(cosine) ** 2
        if reflectivity is not None and self.kind == "tof":
            axial = axial * np.sqrt(self.noise_reflectivity / np.maximum(reflectivity, LEAST_REFLECTIVITY))
        if self.jitter_px == 0:
            return np.asarray(axial)
        return np.asarray(np.hypot(axial, self.jitter_sigma(ranges, cosine)))

    def jitter_sigma(self, ranges: Array, cosine: Array) -> Array:
        """Return the (n,) part of the range's standard deviation that the jitter of the rays causes on slopes, metres."""
        cosine = np.clip(cosine, LEAST_COSINE, 1.0)
        return np.asarray(self.jitter_px / self.intrinsics.fx * ranges * np.sqrt(1 - cosine**2) / cosine)

    def lateral_sigma(self, cosine: Array) -> Array:
        """Return the (n,) standard deviation of where a depth edge appears, pixels, on faces under these cosines of incidence."""
        return np.asarray(self.lateral_px + self.lateral_grazing_px * _grazing(np.clip(cosine, LEAST_COSINE, 1.0)))

    def quantum(self, ranges: Array) -> Array:
        """Return the (n,) step between neighbouring values that the camera can report at these ranges, metres; 0 for none."""
        return np.asarray(self.step + self.step_per_square_metre * np.square(ranges))

    def rounded(self, ranges: Array) -> Array:
        """Return (n,) ranges as the camera can report them: the nearest of values that are :meth:`quantum` apart, metres.

        The values are equally spaced in the integral of dr / quantum(r): for a quantum that grows as the square of the range, in
        1 / r, which is what a disparity is.
        """
        a, b = self.step, self.step_per_square_metre
        if b == 0:
            return ranges if a == 0 else np.rint(ranges / a) * a
        if a == 0:
            return np.asarray(1 / (b * np.maximum(np.rint(1 / (b * np.maximum(ranges, LEAST_RANGE))), 1)))
        unit = np.sqrt(a * b)
        return np.asarray(np.sqrt(a / b) * np.tan(np.rint(np.arctan(ranges * np.sqrt(b / a)) / unit) * unit))

    def loss(self, cosine: Array) -> Array:
        """Return the (n,) probability that a return is lost to grazing incidence: a ramp between the two grazing angles."""
        cosine = np.asarray(cosine, dtype=float)
        lost = np.zeros(cosine.shape)
        grazing = cosine < np.cos(self.grazing_start)
        angle = np.arccos(np.maximum(cosine[grazing], 0.0))
        lost[grazing] = np.minimum((angle - self.grazing_start) / (self.grazing_end - self.grazing_start), 1.0)
        return lost

    def edge_sigma(self, cosine: Array) -> Array:
        """Return the (k,) standard deviation of whole edges, pixels, of faces seen under these cosines of incidence."""
        return np.asarray(self.edge_sd_px + self.lost_edge_sd_px * self.loss(cosine))

    def systematic_shapes(self, ranges: Array) -> Array:
        """Return (..., 4): how ranges err together, as functions of the range: scale, offset, and a wave of unknown phase."""
        turn = 2 * np.pi / self.wiggle_period * ranges
        return np.stack([ranges, np.ones(ranges.shape), np.sin(turn), np.cos(turn)], axis=-1)

    @property
    def systematic_sd(self) -> Array:
        """(4,) standard deviation of each shape's amplitude: relative, then metres; of a wave, its root mean square."""
        return np.array([self.scale_sd, self.offset_sd, self.wiggle / np.sqrt(2), self.wiggle / np.sqrt(2)])

    def true_ranges(self, ranges: Array) -> Array:
        """Return reported ranges, metres, without the camera's known scale and offset error."""
        return ranges if self.scale == self.offset == 0 else np.asarray((ranges - self.offset) / (1 + self.scale))

    def corrected(self, scale: float, offset: float, scale_sd: float, offset_sd: float) -> "Sensor":
        """Return the camera with a further known range error, metres for the offset, and what remains unknown of it."""
        whole_scale = (1 + self.scale) * (1 + scale) - 1
        whole_offset = self.offset + (1 + self.scale) * offset
        return replace(self, scale=whole_scale, offset=whole_offset, scale_sd=scale_sd, offset_sd=offset_sd)

    def without_systematic(self) -> "Sensor":
        """Return the same camera with perfect calibration (no scale, offset and periodic error)."""
        return replace(self, scale=0.0, offset=0.0, scale_sd=0.0, offset_sd=0.0, wiggle=0.0)

    def noisier(self, factor: float) -> "Sensor":
        """Return the same camera with ``factor`` times the noise of its ranges; jitter and lateral noise stay."""
        return replace(
            self,
            noise_constant=factor * self.noise_constant,
            noise_per_metre=factor * self.noise_per_metre,
            noise_per_square_metre=factor * self.noise_per_square_metre,
            noise_grazing=factor * self.noise_grazing,
        )

    def _axial(self, ranges: Array) -> Array:
        return np.asarray(self.noise_constant + ranges * (self.noise_per_metre + ranges * self.noise_per_square_metre))

    def _least_axial(self) -> float:
        """Return the least noise, head-on, between zero and the farthest range."""
        ends = np.array([0.0, self.range_max])
        if self.noise_per_square_metre > 0:
            ends = np.append(ends, np.clip(-self.noise_per_metre / (2 * self.noise_per_square_metre), 0.0, self.range_max))
        return float(self._axial(ends).min())


def _grazing(cosine: Array) -> Array:
    """Return t / (pi / 2 - t) for incidences t: 0 head-on, 1 at 45 degrees."""
    angle = np.arccos(cosine)
    return np.asarray(angle / (np.pi / 2 - angle))

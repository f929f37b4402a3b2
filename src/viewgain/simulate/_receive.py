"""From the light in a pixel to the number a camera reports: systematic error, noise, losses, wrapping, rounding, filtering."""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Image, Mask, Vector
from viewgain.camera import Sensor
from viewgain.simulate._effects import Effects
from viewgain.simulate._signal import Signal, mixing_wavelength

_WEAK_BAND = 0.25
"""Half width, relative, of the ramp of amplitudes around the weakest between which returns are lost at random (assumed)."""


@dataclass(frozen=True, slots=True)
class RangeError:
    """The systematic error of one particular camera: r becomes r (1 + scale) + offset."""

    scale: float = 0.0
    """Relative range error."""
    offset: float = 0.0
    """Constant range error, metres."""


NO_ERROR = RangeError()
"""A camera in perfect calibration."""


def draw_range_error(sensor: Sensor, *, rng: np.random.Generator) -> RangeError:
    """Return the systematic error of one camera of this model, as calibration leaves it."""
    return RangeError(float(rng.normal(0.0, sensor.scale_sd)), float(rng.normal(0.0, sensor.offset_sd)))


def received(signal: Signal, sensor: Sensor, error: RangeError, effects: Effects, draws: "Draws") -> tuple[Vector, Vector]:
    """Return the (n,) reported ranges (NaN for no return) and amplitudes of one frame.

    Args:
        signal: What comes back to each pixel.
        sensor: The camera.
        error: This camera's systematic error.
        effects: Which effects are on.
        draws: Random numbers.
    """
    seen = np.isfinite(signal.ranges)
    ranges = np.where(seen, signal.ranges, 0.0)
    sigma = random_sigma(ranges, signal, sensor, effects)
    ranges = (ranges * (1 + error.scale) + error.offset) * (1 + sensor.scale) + sensor.offset
    if effects.wiggle and sensor.wiggle > 0:
        turn = (2 * np.pi / sensor.wiggle_period * ranges).astype(np.float32)  # a millionth of a millimetre is close enough
        ranges = ranges + sensor.wiggle * np.sin(turn)
    amplitude = signal.amplitude
    if effects.noise:
        ranges = ranges + sigma * draws.noise
        # The same noise of the light that shows as an angle in the phase shows as a length in the amplitude.
        amplitude = np.maximum(amplitude * (1 + 2 * np.pi / mixing_wavelength(sensor) * sigma * draws.amplitude), 0.0)
    if effects.loss:
        seen &= draws.loss >= loss_probability(signal, sensor)
    if effects.wrap and ranges.max(initial=0.0) >= sensor.unambiguous:
        ranges = np.where(ranges >= sensor.unambiguous, np.mod(ranges, sensor.unambiguous), ranges)
    if effects.quantisation:
        ranges = sensor.rounded(ranges)
    ranges = np.where(seen & (ranges >= sensor.range_min) & (ranges <= sensor.range_max), ranges, np.nan)
    if effects.filtering and sensor.flying_filter > 0:
        shape = (sensor.intrinsics.height, sensor.intrinsics.width)
        ranges = np.where(flying(ranges.reshape(shape), sensor.flying_filter).ravel(), np.nan, ranges)
    return ranges, np.where(np.isfinite(signal.ranges), amplitude, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Draws:
    """The random numbers of one frame, (n,) each."""

    noise: Array
    """Standard normal."""
    amplitude: Array
    """Standard normal."""
    loss: Array
    """Uniform on [0, 1)."""


def random_sigma(ranges: Vector, signal: Signal, sensor: Sensor, effects: Effects) -> Vector:
    """Return the (n,) standard deviation of the random part of the noise, metres.

    A published figure is the whole scatter; what rounding (and the jitter of the rays) brings by itself is taken off.
    """
    whole = sensor.range_sigma(ranges, signal.cosine, reflectivity=signal.reflectivity)
    if sensor.step == sensor.step_per_square_metre == sensor.jitter_px == 0:
        return whole
    other = sensor.quantum(ranges) ** 2 / 12 if effects.quantisation else np.zeros(len(ranges))
    if effects.jitter:
        other = other + sensor.jitter_sigma(ranges, signal.cosine) ** 2
    return np.sqrt(np.maximum(whole**2 - other, 0.0))


def loss_probability(signal: Signal, sensor: Sensor) -> Vector:
    """Return the (n,) probability that no return comes: from grazing incidence, or from light under the camera's weakest."""
    kept = 1 - sensor.loss(signal.cosine)
    if sensor.weakest > 0:
        kept = kept * np.clip((signal.amplitude / sensor.weakest - 1) / (2 * _WEAK_BAND) + 0.5, 0.0, 1.0)
    return np.asarray(1 - kept)


def flying(ranges: Image, threshold: float) -> Mask:
    """Return the (h, w) mask of pixels that differ from both neighbours on a line by more than ``threshold`` of their range.

    Lines are rows and columns. Next to no return, and at the image's border, there is nothing to differ from.
    """
    out, allowed = np.zeros(ranges.shape, dtype=bool), threshold * ranges
    with np.errstate(invalid="ignore"):
        across, down = np.abs(np.diff(ranges, axis=1)), np.abs(np.diff(ranges, axis=0))
        out[:, 1:-1] = np.minimum(across[:, :-1], across[:, 1:]) > allowed[:, 1:-1]
        out[1:-1] |= np.minimum(down[:-1], down[1:]) > allowed[1:-1]
    return out

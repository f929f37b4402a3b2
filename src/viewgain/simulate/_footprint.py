"""A pixel is a square, not a ray: what it reports where it sees several surfaces at once, and where depth edges appear.

Pixels within reach of a depth edge are looked through on a grid of sub-rays, moved as a whole by the camera's lateral noise. The
signals of the sub-rays add up as phasors, so a flying pixel lies where the phase of the sum says. Elsewhere a pixel sees one flat
surface and its centre says it all; a thing thinner than the distance of two pixels that no centre hits is missed.
"""

import numpy as np
from scipy import ndimage

from viewgain.arrays import Array, Ids, Indices, Mask, Pose, Vector
from viewgain.camera import Sensor
from viewgain.rays import Hits, SceneCaster, Triple, pixel_rays, rays_through
from viewgain.simulate._signal import Signal, lambertian, mixing_wavelength

SUBRAYS = 3
"""Sub-rays along each side of the footprint."""
_LATERAL_REACH = 1.5
"""Standard deviations of lateral noise within which a pixel may see across an edge."""
_USUAL_INCIDENCE = np.pi / 3
"""Incidence for which that reach is reckoned."""
_DARK = 1e-300
"""Less light than any pixel gets: keeps a weighted mean over nothing finite."""
_CREASE = 0.03
"""Neighbouring ranges on one mesh that differ by more than this share may be an edge of it against itself."""
_STEEPEST = 6.3
"""Tangent of the steepest incidence, 81 degrees, at which a surface is continued as it is; a steeper one as if it were this."""
_CONTINUED = 2.0
"""How far from its sub-ray a surface is continued, pixels."""


def mixed_signal(
    signal: Signal,
    hits: Hits,
    caster: SceneCaster,
    camera_to_world: Pose,
    sensor: Sensor,
    *,
    mixing: bool,
    rng: np.random.Generator | None,
) -> Signal:
    """Return the signal with the pixels near depth edges replaced by what their whole footprint receives.

    Args:
        signal: (n,) what the pixel centres receive.
        hits: (n,) what they see.
        caster: The scene.
        camera_to_world: (4, 4) pose of the camera.
        sensor: The camera.
        mixing: Whether a pixel integrates over its footprint, or looks along one ray.
        rng: Source of the displacements of the footprints; None for no lateral noise.
    """
    usual = 0.0 if rng is None else float(sensor.lateral_sigma(np.cos(_USUAL_INCIDENCE)))
    # The same pixels whether they mix or not, so that they get the same lateral noise.
    reach = sensor.footprint_px / 2 + _LATERAL_REACH * usual
    edge = pixels_near_edges(hits, caster, sensor, int(np.ceil(reach)))
    if len(edge) == 0:
        return signal
    directions = _subrays(edge, hits.cosine[edge], sensor, mixing, rng)
    seen = caster.rays(camera_to_world, directions)
    owners = np.repeat(edge, len(seen.ranges) // len(edge))
    ranges = _at_centre(seen, caster, camera_to_world, directions, owners, sensor)
    return _replaced(signal, edge, _integrated(ranges, seen, caster, sensor, len(edge)))


def _subrays(pixels: Indices, cosine: Vector, sensor: Sensor, mixing: bool, rng: np.random.Generator | None) -> Triple:
    """Return the directions of all sub-rays of (e,) pixels, pixel by pixel: (e k) components."""
    width = sensor.intrinsics.width
    centres = np.stack([pixels % width, pixels // width], axis=-1).astype(float)
    if rng is not None:
        centres += sensor.lateral_sigma(cosine)[:, None] * rng.standard_normal((len(pixels), 2))
    grid = _grid(SUBRAYS if mixing else 1, sensor.footprint_px)
    return rays_through(sensor.intrinsics, (centres[:, None, :] + grid).reshape(-1, 2))


def _integrated(ranges: Vector, seen: Hits, caster: SceneCaster, sensor: Sensor, count: int) -> Signal:
    """Return what each of ``count`` pixels makes of its sub-rays, whose surfaces lie at (e k,) ranges along its own ray."""
    reflectivity, ranges = caster.surfaces.reflectivity[seen.surfaces], ranges.reshape(count, -1)
    weight = lambertian(seen, reflectivity).reshape(count, -1)
    if sensor.kind == "structured_light":
        chosen = _most_seen(caster.surfaces.patches[seen.surfaces].reshape(count, -1))
        weight = np.where(chosen, weight, 0.0)
        mixed, amplitude = _middle(np.where(chosen, ranges, np.nan)), weight.mean(axis=1)
    else:
        mixed, amplitude = _phasor_sum(ranges, weight, mixing_wavelength(sensor))
    total = np.maximum(weight.sum(axis=1), _DARK)
    cosine, reflected = ((weight * values.reshape(count, -1)).sum(axis=1) / total for values in (seen.cosine, reflectivity))
    return Signal(mixed, amplitude, cosine, reflected)


def _replaced(signal: Signal, pixels: Indices, part: Signal) -> Signal:
    """Return a signal with that of some pixels exchanged."""
    whole = Signal(*(values.copy() for values in (signal.ranges, signal.amplitude, signal.cosine, signal.reflectivity)))
    whole.ranges[pixels], whole.amplitude[pixels] = part.ranges, part.amplitude
    whole.cosine[pixels], whole.reflectivity[pixels] = part.cosine, part.reflectivity
    return whole


def pixels_near_edges(hits: Hits, caster: SceneCaster, sensor: Sensor, reach: int) -> Indices:
    """Return the row-major indices of the pixels within ``reach`` pixels of one that sees another smooth patch.

    Patches are faces of boxes, whole meshes, and planes; on a mesh, neighbours of very different range count as well.
    """
    shape = (sensor.intrinsics.height, sensor.intrinsics.width)
    patch = caster.surfaces.patches[hits.surfaces].reshape(shape)
    ranges = hits.ranges.reshape(shape) if caster.scene.meshes else None
    edge = np.zeros(shape, dtype=bool)
    for here, there in (((slice(None), slice(1, None)), (slice(None), slice(None, -1))), ((slice(1, None),), (slice(None, -1),))):
        differs = patch[here] != patch[there]
        if ranges is not None:
            with np.errstate(invalid="ignore"):
                differs |= np.abs(ranges[here] - ranges[there]) > _CREASE * np.minimum(ranges[here], ranges[there])
        edge[here] |= differs
        edge[there] |= differs
    return np.flatnonzero(_dilated(edge, reach - 1))


def _dilated(mask: Mask, by: int) -> Mask:
    return np.asarray(ndimage.maximum_filter(mask, 2 * by + 1)) if by > 0 else mask


def _grid(per_side: int, width: float) -> Array:
    """Return the (per_side^2, 2) offsets of sub-rays: the centres of the cells of a square about zero."""
    line = ((np.arange(per_side) + 0.5) / per_side - 0.5) * width
    return np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)


def _at_centre(
    seen: Hits, caster: SceneCaster, camera_to_world: Pose, directions: Triple, pixels: Indices, sensor: Sensor
) -> Vector:
    """Return the ranges at which the flat pieces that sub-rays met are crossed by the rays of their pixels' centres.

    So a slope seen a little off centre brings no range error of its own: lateral noise is measured at edges, and published range
    noise already holds what it does on slopes.
    """
    normals = (caster.surfaces.normals_of(seen.surfaces) @ camera_to_world[:3, :3]).T
    along = sum(normals[k] * directions[k] for k in range(3))
    along_centre = sum(normals[k] * component[pixels] for k, component in enumerate(pixel_rays(sensor.intrinsics)))
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.nan_to_num(along / along_centre, nan=1.0)
        factor = np.where(factor < 0, np.inf, factor)  # the pixel's own ray never meets that plane: it lies far off
        bend = min(_CONTINUED / sensor.intrinsics.fx * _STEEPEST, 0.5)
        return np.asarray(seen.ranges * np.clip(factor, 1 - bend, 1 + bend))


def _phasor_sum(ranges: Array, weight: Array, wavelength: float) -> tuple[Vector, Vector]:
    """Return the ranges and amplitudes that time of flight makes of several returns in one pixel.

    Their phasors add; the phase of the sum is counted from the strongest, within half a turn. Returns more than half a wavelength
    apart can so yield a range outside their interval, as they do in a camera with one frequency.
    """
    strongest = ranges[np.arange(len(ranges)), np.argmax(weight, axis=1)]
    with np.errstate(invalid="ignore"):
        turn = 2 * np.pi / wavelength * np.where(weight > 0, ranges - strongest[:, None], 0.0)
    real, imaginary = (weight * np.cos(turn)).sum(axis=1), (weight * np.sin(turn)).sum(axis=1)
    found = weight.max(axis=1) > 0
    phase_range = strongest + np.arctan2(imaginary, real) * wavelength / (2 * np.pi)
    return np.where(found, phase_range, np.inf), np.hypot(real, imaginary) / weight.shape[1]


def _most_seen(patches: Ids) -> Mask:
    """Return the (e, k) mask of the sub-rays on the patch that most of a pixel's sub-rays see.

    The correlation of a projected pattern locks to the surface that fills most of its window.
    """
    alike = (patches[:, :, None] == patches[:, None, :]).sum(axis=2)
    winner = patches[np.arange(len(patches)), np.argmax(alike, axis=1)]
    return np.asarray(patches == winner[:, None])


def _middle(ranges: Array) -> Vector:
    """Return the lower median of each row of (e, k) ranges, NaN left out; no row is all NaN."""
    count = np.isfinite(ranges).sum(axis=1) + np.isinf(ranges).sum(axis=1)
    return np.asarray(np.sort(ranges, axis=1)[np.arange(len(ranges)), (count - 1) // 2])

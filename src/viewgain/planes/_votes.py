"""Pairs of points vote for planes: a semi-global Hough transform (stages 1 and 2 of the method).

A reference point knows its own plane. Each partner whose normal is orthogonal to the reference's votes, in a table of the
reference's own, for the partner's plane by the two numbers that such a plane still has: the angle of its normal around the
reference's, and its offset from the reference. All references and partners are worked at once; a table is one row of a histogram.
"""

from dataclasses import dataclass

import numpy as np

from viewgain.arrays import Array, Indices, Mask, Points, Vector
from viewgain.planes._cloud import Cloud
from viewgain.planes._draw import draw_pairs, draw_references
from viewgain.planes._settings import Settings

Edges = Indices
"""(e, 2) indices of planes that are orthogonal because one point voted for the other's plane."""


@dataclass(frozen=True, slots=True, eq=False)
class Hypotheses:
    """Planes n . x + d = 0 that were voted for, as many times over as they were."""

    normals: Points
    """(v, 3) unit normals."""
    offsets: Vector
    """(v,) d, metres."""
    anchors: Points
    """(v, 3) a point on each plane near what voted for it."""
    edges: Edges
    """(e, 2) which are orthogonal to which."""


@dataclass(frozen=True, slots=True, eq=False)
class Votes:
    """What the partners of each reference say about it and about planes orthogonal to its own."""

    coplanar: Mask
    """(r, k): the partner lies in the reference's plane."""
    orthogonal: Mask
    """(r, k): the partner's plane is orthogonal to it."""
    angles: Array
    """(r, k) direction of the partner's normal around the reference's, -pi to pi."""
    offsets: Array
    """(r, k) signed distance of the reference from the partner's plane, metres."""


def vote(cloud: Cloud, settings: Settings, rng: np.random.Generator) -> Hypotheses:
    """Return the planes that pairs of points vote for; none for an empty cloud.

    Args:
        cloud: Points with normals.
        settings: The parameters; ``unbiased_decode``, ``peaks_only``, ``random_pairs`` and ``balanced_draw`` apply here.
        rng: Draws the references, and the partners where they are random.
    """
    if len(cloud) == 0:
        return Hypotheses(np.empty((0, 3)), np.empty(0), np.empty((0, 3)), np.empty((0, 2), dtype=np.intp))
    references = draw_references(cloud, settings, rng)
    partners = draw_pairs(cloud, references, settings, rng)
    votes = pair_votes(cloud, references, partners, settings)
    rows, angles, offsets = elected(votes, settings)
    return _hypotheses(cloud, references, rows, angles, offsets)


def pair_votes(cloud: Cloud, references: Indices, partners: Indices, settings: Settings) -> Votes:
    """Return the votes of (r, k) ``partners`` on (r,) ``references`` from the four numbers of a pair of oriented points.

    With delta = p_r - p_i these are n_r . n_i, n_r . delta, n_i . delta and |delta|: they stay under every rigid motion.
    """
    own, normal = cloud.normals[references][:, None], cloud.normals[partners]
    delta = cloud.points[references][:, None] - cloud.points[partners]
    cosine = np.einsum("rki,rki->rk", own, normal)
    above_own = np.einsum("rki,rki->rk", own, delta)
    above_partner = np.einsum("rki,rki->rk", normal, delta)
    distance = np.sqrt(np.einsum("rki,rki->rk", delta, delta))
    near = distance < settings.pair_max
    flat = settings.right * distance
    coplanar = near & (cosine > settings.parallel) & (np.abs(above_own) < flat) & (np.abs(above_partner) < flat)
    orthogonal = near & (distance > settings.pair_min) & (np.abs(cosine) < settings.right)
    u, v = tangents(cloud.normals[references])
    angles = np.arctan2(np.einsum("ri,rki->rk", v, normal), np.einsum("ri,rki->rk", u, normal))
    return Votes(coplanar, orthogonal, angles, above_partner)


def tangents(normals: Points) -> tuple[Points, Points]:
    """Return what the shortest rotation that takes +z to each of (n, 3) unit normals makes of x and y; both (n, 3)."""
    x, y, z = normals.T
    opposite = z < -1 + 1e-4
    share = 1 / np.where(opposite, 1.0, 1 + z)
    u = np.stack([1 - x * x * share, -x * y * share, -x], axis=1)
    v = np.stack([-x * y * share, 1 - y * y * share, -y], axis=1)
    half_turn = np.array([-1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    return np.where(opposite[:, None], half_turn[0], u), np.where(opposite[:, None], half_turn[1], v)


def elected(votes: Votes, settings: Settings) -> tuple[Indices, Vector, Vector]:
    """Return (row, angle, offset) of every cell with enough votes, of references whose own plane has enough support."""
    counts, angles, offsets = tables(votes, settings)
    wins = counts >= settings.min_votes
    wins &= (votes.coplanar.sum(axis=1) >= settings.min_votes)[:, None, None]
    if settings.peaks_only:
        wins &= _is_peak(counts)
    row, angle_cell, offset_cell = np.nonzero(wins)
    if settings.unbiased_decode:
        return row, angles[wins], offsets[wins]
    turn = 2 * np.pi / settings.angle_bins
    angle, offset = (angle_cell - 0.5) * turn - np.pi, (offset_cell - 0.5) * settings.offset_width - settings.pair_max
    return np.asarray(row), np.asarray(angle, dtype=float), np.asarray(offset, dtype=float)


def tables(votes: Votes, settings: Settings) -> tuple[Array, Array, Array]:
    """Return each reference's (angle, offset) histogram, and the mean angle and offset of the votes in each cell.

    Cells are centred on multiples of their width; shapes (r, angle_bins, 2 offset_bins + 1). The mean of an empty cell is NaN.
    """
    turn, width = 2 * np.pi / settings.angle_bins, settings.offset_width
    shape = (len(votes.angles), settings.angle_bins, 2 * settings.offset_bins + 1)
    row = np.broadcast_to(np.arange(shape[0])[:, None], votes.angles.shape)[votes.orthogonal]
    angle, offset = votes.angles[votes.orthogonal], votes.offsets[votes.orthogonal]
    step, level = np.floor(angle / turn + 0.5), np.floor(offset / width + 0.5)
    cell = (row * shape[1] + (step.astype(int) + shape[1] // 2) % shape[1]) * shape[2]
    cell += np.clip(level.astype(int) + settings.offset_bins, 0, shape[2] - 1)
    count, angle_rest, offset_rest = (
        np.bincount(cell, weights, int(np.prod(shape))).reshape(shape) for weights in (None, angle - step * turn, offset)
    )
    with np.errstate(invalid="ignore"):
        centre = (np.arange(shape[1]) - shape[1] // 2)[None, :, None] * turn
        return count.astype(float), centre + angle_rest / count, offset_rest / count


def _is_peak(counts: Array) -> Mask:
    """Return where no neighbour (of eight; angles go round) has more votes, and none that comes first as many."""
    around = np.concatenate([counts[:, -1:], counts, counts[:, :1]], axis=1)
    around = np.pad(around, ((0, 0), (0, 0), (1, 1)), constant_values=-1)
    height, width = counts.shape[1:]
    peak = np.ones(counts.shape, dtype=bool)
    for down, across in ((0, 0), (0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1), (2, 2)):
        other = around[:, down : down + height, across : across + width]
        peak &= (counts > other) if (down, across) < (1, 1) else (counts >= other)
    return peak


def _hypotheses(cloud: Cloud, references: Indices, rows: Indices, angles: Vector, offsets: Vector) -> Hypotheses:
    """Return the planes of the references that elected any, followed by the elected ones, and the edges between them."""
    voters, own = np.unique(rows, return_inverse=True)
    at = references[voters]
    u, v = tangents(cloud.normals[at])
    normals = np.cos(angles)[:, None] * u[own] + np.sin(angles)[:, None] * v[own]
    points = cloud.points[at]
    return Hypotheses(
        normals=np.concatenate([cloud.normals[at], normals]),
        offsets=np.concatenate([
            -np.einsum("vk,vk->v", cloud.normals[at], points), offsets - np.einsum("vk,vk->v", normals, points[own])
        ]),
        anchors=np.concatenate([points, points[own] - offsets[:, None] * normals]),
        edges=np.stack([own, len(voters) + np.arange(len(own))], axis=1),
    )  # fmt: skip

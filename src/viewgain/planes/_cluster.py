"""Hypotheses that are the same plane become one (stage 3): single linkage on mutual distance and normal."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from viewgain.arrays import Array, Indices, Mask, Points
from viewgain.planes._settings import Settings
from viewgain.planes._votes import Edges, Hypotheses


def cluster(hypotheses: Hypotheses, settings: Settings) -> Hypotheses:
    """Return one plane per cluster of hypotheses, with the edges between different clusters, each once.

    Args:
        hypotheses: Planes as voted for.
        settings: ``parallel`` and ``band`` say when two are one.
    """
    if len(hypotheses.normals) == 0:
        return hypotheses
    label = components(same_plane(hypotheses, settings))
    normals, anchors = _means(hypotheses, label)
    return Hypotheses(normals, -np.einsum("ck,ck->c", normals, anchors), anchors, rewired(hypotheses.edges, label))


def same_plane(planes: Hypotheses, settings: Settings) -> Mask:
    """Return the (v, v) mask of pairs with like normals, each with its anchor in the other's plane."""
    off = np.abs(planes.anchors @ planes.normals.T + planes.offsets) < settings.band  # [anchor, plane]
    return np.asarray(off & off.T & (planes.normals @ planes.normals.T > settings.parallel))


def components(linked: Mask) -> Indices:
    """Return (v,) labels 0, 1, ... of the connected parts of a graph, in the order of their first vertices."""
    _, label = connected_components(coo_array(linked), directed=False)
    _, first, part = np.unique(label, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[part])


def rewired(edges: Edges, label: Indices) -> Edges:
    """Return the edges between the parts that ``label`` makes of the vertices: sorted, each once, none from a part to itself."""
    ends = np.sort(label[edges], axis=1)
    return np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0).reshape(-1, 2)


def _means(planes: Hypotheses, label: Indices) -> tuple[Points, Points]:
    """Return the normal and the anchor of each cluster.

    The normal is the mean one less its part along the direction in which the anchors spread most: that direction lies in the
    plane, and the spread fixes it better than the normals do.
    """
    count = np.bincount(label)
    anchors = _summed(planes.anchors, label) / count[:, None]
    away = planes.anchors - anchors[label]
    scatter = _summed((away[:, :, None] * away[:, None, :]).reshape(-1, 9), label).reshape(-1, 3, 3)
    along = np.linalg.eigh(scatter)[1][:, :, 2]
    normals = _unit(_summed(planes.normals, label))
    straight = normals - np.einsum("ck,ck->c", along, normals)[:, None] * along
    return np.where((count > 1)[:, None], _unit(straight), normals), anchors


def _summed(values: Array, label: Indices) -> Array:
    return np.stack([np.bincount(label, column) for column in values.T], axis=1)


def _unit(vectors: Points) -> Points:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12))

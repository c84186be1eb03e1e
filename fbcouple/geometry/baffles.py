"""Baffles, walls without thickness inside of a mesh: outer faces of two cells at one place, back to back."""

from __future__ import annotations

import numpy as np
import scipy

from fbcouple.geometry.polymesh import PolyMesh

_TOUCHING = 1e-6
"""Distance of two points, over the edge of a usual cell, below which they are at one place."""
_NONE = -1


def pair_faces(mesh: PolyMesh) -> np.ndarray:
    """Pairs (n, 2) of outer faces at one place, the lower number first: baffles have the same points, or points of
    their own there."""
    outer = np.arange(len(mesh.neighbour), len(mesh.owner))
    rows = mesh.faces.take(outer)
    padded = np.full((len(outer), int(rows.lengths.max(initial=0))), _NONE, np.int64)
    column = np.arange(len(rows.values)) - np.repeat(rows.starts[:-1], rows.lengths)
    padded[np.repeat(np.arange(len(outer)), rows.lengths), column] = _number_places(mesh, rows.values)
    padded.sort(axis=1)
    order = np.lexsort(padded.T)
    alike = np.flatnonzero(np.all(padded[order][1:] == padded[order][:-1], axis=1))
    pairs = np.sort(np.column_stack([order[alike], order[alike + 1]]), axis=1)
    return outer[pairs[np.argsort(pairs[:, 0])]]


def _number_places(mesh: PolyMesh, points: np.ndarray) -> np.ndarray:
    """A number for the place of each of `points`, (n,): one for all that touch."""
    used, which = np.unique(points, return_inverse=True)
    edge = (mesh.volume / mesh.count) ** (1.0 / 3.0)
    near = scipy.spatial.cKDTree(mesh.points[used]).query_pairs(_TOUCHING * edge, output_type="ndarray")
    links = scipy.sparse.coo_matrix((np.ones(len(near)), tuple(near.T)), (len(used), len(used)))
    return np.asarray(scipy.sparse.csgraph.connected_components(links, directed=False)[1][which])

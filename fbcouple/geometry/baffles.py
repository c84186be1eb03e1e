"""Baffles, walls without thickness inside of a mesh: outer faces of two cells at one place, back to back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy

from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.ragged import Ragged

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


def split_points(mesh: PolyMesh, pairs: np.ndarray) -> PolyMesh:
    """The mesh in which cells at a point of the baffles `pairs` share it only if inner faces lead from one to the other
    around it: what is shared by points, weights and filter, does not reach across. At free edges it does."""
    rows = mesh.faces
    at_baffle = np.zeros(len(mesh.points), bool)
    at_baffle[rows.take(pairs.ravel()).values] = True
    entries = np.flatnonzero(at_baffle[rows.values])
    face, point = np.repeat(np.arange(len(rows)), rows.lengths)[entries], rows.values[entries]
    inner = face < len(mesh.neighbour)
    here = mesh.owner[face] * len(mesh.points) + point
    beyond = mesh.neighbour[face[inner]] * len(mesh.points) + point[inner]
    corners, which = np.unique(np.concatenate([here, beyond]), return_inverse=True)
    here, beyond = which[: len(here)], which[len(here) :]
    links = scipy.sparse.coo_matrix((np.ones(len(beyond)), (here[inner], beyond)), (len(corners), len(corners)))
    fans, fan = scipy.sparse.csgraph.connected_components(links, directed=False)
    point_of = np.empty(fans, np.int64)
    point_of[fan] = corners % len(mesh.points)
    _, first = np.unique(point_of, return_index=True)
    added = np.setdiff1d(np.arange(fans), first)
    number = point_of.copy()
    number[added] = len(mesh.points) + np.arange(len(added))
    values = rows.values.copy()
    values[entries] = number[fan[here]]
    points = np.concatenate([mesh.points, mesh.points[point_of[added]]])
    return replace(mesh, points=points, faces=Ragged(rows.starts, values))


def find_unsplit(mesh: PolyMesh, pairs: np.ndarray) -> np.ndarray:
    """Which of `pairs` (n, 2) of a mesh whose points are split have the same points on both sides, (n,): those of a
    baffle one cell wide with free edges."""
    if not len(pairs):
        return np.zeros(0, bool)
    sides = [mesh.faces.take(faces) for faces in pairs.T]
    one, other = ([set(row) for row in np.split(side.values, side.starts[1:-1])] for side in sides)
    return np.array([points == others for points, others in zip(one, other, strict=True)])

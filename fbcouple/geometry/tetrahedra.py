"""Polyhedra cut into tetrahedra, on which a field is linear.

A cell is cut from its centre: a triangle of its surface gives one tetrahedron, a face of more points one for each of
its edges, about the mean of its points. The corners are sites, numbered: cells first (their centres), then points, then
the middles of faces that are no triangles. Both cells at a face cut it alike, so that a field given at the sites is
continuous.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from fbcouple.errors import CaseError
from fbcouple.geometry.polyhedra import Polyhedra


@dataclass(frozen=True)
class Tetrahedra:
    """The cut: corners as sites (n, 4), the cell's centre first, and volumes (n,) [m3], positive.

    `faces` (m, points): rows of shares, the middles of faces as means of points.
    """

    corners: np.ndarray
    volumes: np.ndarray
    nodes: np.ndarray
    """Of each site [m], (sites, 3)."""
    cells: int
    points: int
    middles: scipy.sparse.csr_matrix

    @property
    def owners(self) -> np.ndarray:
        """The cell of each, (n,)."""
        return self.corners[:, 0]


def cut(cells: Polyhedra) -> Tetrahedra:
    """Cut `cells` into tetrahedra.

    Raises: CaseError if a cell's centre does not see all of its surface: what is linear on the parts needs that.
    """
    faces = cells.faces
    cell = np.repeat(np.repeat(np.arange(len(cells)), cells.cells.lengths), faces.lengths)
    face = np.repeat(np.arange(len(faces)), faces.lengths)
    following = np.arange(len(faces.values)) + 1
    following[faces.starts[1:] - 1] = faces.starts[:-1]
    middles, number = _find_middles(faces.starts, faces.values, faces.lengths, cells)
    here, after = len(cells) + faces.values, len(cells) + faces.values[following]
    first_site = len(cells) + len(cells.points)
    fans = np.column_stack([cell, first_site + number[face], here, after])[number[face] >= 0]
    whole = faces.lengths == 3
    head = faces.starts[:-1][whole]
    owner = np.repeat(np.arange(len(cells)), cells.cells.lengths)[whole]
    triangles = np.column_stack([owner, *(len(cells) + faces.values[head + k] for k in range(3))])
    corners = np.concatenate([triangles, fans])
    nodes = np.concatenate([cells.centres, cells.points, middles @ cells.points])
    origin, a, b, c = nodes[corners].transpose(1, 0, 2)
    volumes = np.einsum("ij,ij->i", a - origin, np.cross(b - origin, c - origin)) / 6.0
    if len(volumes) and volumes.min() <= 0.0:
        wrong = cells.ids[np.unique(corners[volumes <= 0.0, 0])]
        text = f"{len(wrong)} cells of the mesh are not star-shaped about their centres (first: cell {wrong[0]})"
        raise CaseError([f"{text}; fix the mesh (checkMesh names such cells)."])
    order = np.argsort(corners[:, 0], kind="stable")
    return Tetrahedra(corners[order], volumes[order], nodes, len(cells), len(cells.points), middles)


def _find_middles(
    starts: np.ndarray, values: np.ndarray, lengths: np.ndarray, cells: Polyhedra
) -> tuple[scipy.sparse.csr_matrix, np.ndarray]:
    """Shares of points in the middle of each face that is no triangle, and its number for each face, -1 for triangles.

    The two cells of a face name the same middle: three points are in one face only, and the two faces of a baffle, of
    which one has later points than the other where they do not share them.
    """
    number = np.full(len(lengths), -1)
    large = np.flatnonzero(lengths > 3)
    if not len(large):
        return scipy.sparse.csr_matrix((0, len(cells.points))), number
    face = np.repeat(np.arange(len(lengths)), lengths)
    order = np.lexsort([values, face])
    keys = values[order][np.column_stack([starts[:-1][large][:, None] + np.arange(3), starts[1:][large] - 1])]
    _, first, which = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    number[large] = which.ravel()
    chosen = large[first]
    columns = np.concatenate([values[starts[f] : starts[f + 1]] for f in chosen])
    rows = np.repeat(np.arange(len(chosen)), lengths[chosen])
    shares = np.repeat(1.0 / lengths[chosen], lengths[chosen])
    return scipy.sparse.csr_matrix((shares, (rows, columns)), (len(chosen), len(cells.points))), number


def share_volumes(parts: Tetrahedra) -> scipy.sparse.csr_matrix:
    """How much of each cell's volume [m3] is nearest to each of its points, (cells, points): rows add up to the cells.

    A third of each tetrahedron goes to each of its corners but the centre, and what a middle of a face gets, to the
    points of the face.
    """
    rows = np.repeat(parts.owners, 3)
    columns = parts.corners[:, 1:].ravel() - parts.cells
    sites = scipy.sparse.csr_matrix(
        (np.repeat(parts.volumes / 3.0, 3), (rows, columns)), (parts.cells, len(parts.nodes) - parts.cells)
    )
    shares = sites[:, : parts.points] + sites[:, parts.points :] @ parts.middles
    return scipy.sparse.csr_matrix(shares)


def find_neighbours(corners: np.ndarray) -> np.ndarray:
    """For each tetrahedron (n, 4) the one beyond the side across from each corner, -1 where there is none, (n, 4)."""
    sides = np.concatenate([np.sort(np.delete(corners, k, axis=1), axis=1) for k in range(4)])
    order = np.lexsort(sides.T)
    same = np.flatnonzero(np.all(sides[order][1:] == sides[order][:-1], axis=1))
    one, other = order[same], order[same + 1]
    found = np.full(len(sides), -1, np.int64)
    found[one], found[other] = other % len(corners), one % len(corners)
    return found.reshape(4, -1).T.copy()

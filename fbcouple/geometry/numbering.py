"""From cells of known shapes to a mesh: which faces two cells share, and how OpenFOAM orders them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.ragged import pile_up

NONE = -1
"""Stands for the fourth point of a triangle."""
# Faces by the places of their points in a cell, seen from outside, anticlockwise (the order of VTK and meshio).
SHAPES: dict[str, list[list[int]]] = {
    "tetra": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    "pyramid": [[0, 3, 2, 1], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
    "wedge": [[0, 2, 1], [3, 4, 5], [0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]],
    "hexahedron": [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
}

_TURNED = {
    "tetra": [0, 2, 1, 3],
    "pyramid": [0, 3, 2, 1, 4],
    "wedge": [3, 4, 5, 0, 1, 2],
    "hexahedron": [4, 5, 6, 7, 0, 1, 2, 3],
}
"""The points of a cell as those of its mirror image are numbered."""

Name = Callable[[np.ndarray], np.ndarray]
"""Patch number (n,) of each outer face, given as rows of four points (n, 4)."""


def build_mesh(
    points: np.ndarray, shapes: Sequence[tuple[str, np.ndarray]], names: Sequence[str], name: Name
) -> PolyMesh:
    """Number the faces of cells as OpenFOAM does.

    points (n, 3) [m]; shapes: a word of `SHAPES` and the points of its cells (cells, k); names: the patches, of which
    `name` chooses one for each outer face.

    Raises CaseError if more than two cells share a face.
    """
    rows, cells = _list_faces(points, shapes)
    keys = np.sort(rows, axis=1)
    order = np.lexsort(keys.T)
    same = np.all(keys[order][1:] == keys[order][:-1], axis=1)
    if np.any(same[1:] & same[:-1]):
        raise CaseError(["the mesh has a face that more than two cells share; fix it in its mesher."])
    first = np.flatnonzero(same)
    one, other = order[first], order[first + 1]
    owned = np.where(cells[one] < cells[other], one, other)
    shared = np.where(cells[one] < cells[other], other, one)
    upper = np.lexsort([cells[shared], cells[owned]])
    owned, shared = owned[upper], shared[upper]
    alone = np.ones(len(rows), bool)
    alone[one] = alone[other] = False
    outer = np.flatnonzero(alone)
    which = name(rows[outer])
    outer = outer[np.lexsort([cells[outer], which])]
    counts = np.bincount(which, minlength=len(names))
    starts = len(owned) + np.concatenate([[0], np.cumsum(counts)[:-1]])
    chosen = rows[np.concatenate([owned, outer])]
    there = chosen != NONE
    return PolyMesh(
        points,
        pile_up(there.sum(axis=1), chosen[there]),
        cells[np.concatenate([owned, outer])],
        cells[shared],
        {word: (int(start), int(count)) for word, start, count in zip(names, starts, counts, strict=True)},
    )


def _list_faces(points: np.ndarray, shapes: Sequence[tuple[str, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """All faces of all cells (n, 4), outwards, and their cell (n,)."""
    rows, cells, count = [], [], 0
    for shape, given in shapes:
        corners = _turn_out(points, shape, given)
        for face in SHAPES[shape]:
            row = np.full((len(corners), 4), NONE, np.int64)
            row[:, : len(face)] = corners[:, face]
            rows.append(row)
            cells.append(np.arange(count, count + len(corners)))
        count += len(corners)
    return np.concatenate(rows), np.concatenate(cells)


def _turn_out(points: np.ndarray, shape: str, corners: np.ndarray) -> np.ndarray:
    """The points of cells in the order that makes their volume positive: a mirrored mesh has them inside out."""
    coordinates = points[corners]
    centre = coordinates.mean(axis=1)
    volumes = np.zeros(len(corners))
    for face in SHAPES[shape]:
        middle = coordinates[:, face].mean(axis=1) - centre
        for one, other in zip(face, face[1:] + face[:1], strict=True):
            sides = np.cross(coordinates[:, one] - centre, coordinates[:, other] - centre)
            volumes += np.einsum("ij,ij->i", middle, sides)
    return np.where((volumes < 0.0)[:, None], corners[:, _TURNED[shape]], corners)

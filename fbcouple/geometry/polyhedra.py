"""Some cells of a mesh, each a polyhedron for itself: what ranks hand to each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.geometry.ragged import Ragged, concatenate_ragged, pile_up


@dataclass(frozen=True)
class Polyhedra:
    """Cells with their numbers in the whole mesh, `ids` (n,), and their centres (n, 3) [m].

    `cells`: the rows of `faces` of each cell; `faces`: rows of points, anticlockwise from outside the cell; `points`
    (m, 3) [m] have the numbers `point_ids` (m,) in the whole mesh. A face between two cells stands here twice.
    """

    ids: np.ndarray
    centres: np.ndarray
    cells: Ragged
    faces: Ragged
    points: np.ndarray
    point_ids: np.ndarray

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def corners(self) -> Ragged:
        """Points of each cell, one for each face that it is part of."""
        return Ragged(self.faces.starts[self.cells.starts], self.faces.values)

    def find_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner [m] of the box around each cell, (n, 3) each."""
        corners = self.corners
        coordinates = self.points[corners.values]
        starts = corners.starts[:-1]
        return np.minimum.reduceat(coordinates, starts), np.maximum.reduceat(coordinates, starts)

    def select(self, rows: np.ndarray) -> Polyhedra:
        """Only the cells `rows`, in this order, and what they need."""
        owned = self.cells.take(rows)
        faces = self.faces.take(owned.values)
        used, values = np.unique(faces.values, return_inverse=True)
        cells = Ragged(owned.starts, np.arange(len(owned.values)))
        return Polyhedra(
            self.ids[rows],
            self.centres[rows],
            cells,
            Ragged(faces.starts, values),
            self.points[used],
            self.point_ids[used],
        )


def join(parts: Sequence[Polyhedra]) -> Polyhedra:
    """All cells of `parts`, one part after the other; points of one number become one."""
    ids, first, coordinates = np.unique(
        np.concatenate([part.point_ids for part in parts]), return_index=True, return_inverse=True
    )
    faces = concatenate_ragged([part.faces for part in parts])
    offsets = np.cumsum([0, *(len(part.points) for part in parts[:-1])])
    shift = np.repeat(offsets, [len(part.faces.values) for part in parts])
    lengths = np.concatenate([part.cells.lengths for part in parts])
    return Polyhedra(
        np.concatenate([part.ids for part in parts]),
        np.concatenate([part.centres for part in parts]),
        pile_up(lengths, np.arange(int(lengths.sum()))),
        Ragged(faces.starts, coordinates[faces.values + shift]),
        np.concatenate([part.points for part in parts])[first],
        ids,
    )


def stream_faces(cells: Polyhedra) -> Ragged:
    """A row a cell: how many faces it has, and of each face how many points and which rows of `points` they are."""
    faces = cells.faces.take(cells.cells.values)
    lengths = faces.lengths
    firsts = np.insert(faces.values, faces.starts[:-1], lengths)
    sizes = np.add.reduceat(lengths + 1, cells.cells.starts[:-1])
    stream = np.insert(firsts, np.cumsum(sizes) - sizes, cells.cells.lengths)
    return pile_up(sizes + 1, stream)


def take_apart(mesh: PolyMesh, centres: np.ndarray, ids: np.ndarray, point_ids: np.ndarray) -> Polyhedra:
    """The cells of `mesh` with these centres (n, 3) [m]; `ids` and `point_ids` number cells and points elsewhere."""
    inner = len(mesh.neighbour)
    cells = np.concatenate([mesh.owner, mesh.neighbour])
    faces = np.concatenate([np.arange(len(mesh.owner)), np.arange(inner)])
    order = np.argsort(cells, kind="stable")
    backward = order >= len(mesh.owner)
    lengths = np.bincount(cells, minlength=len(ids))
    return Polyhedra(
        ids,
        centres,
        pile_up(lengths, np.arange(len(order))),
        mesh.faces.take(faces[order], backward),
        mesh.points,
        point_ids,
    )


def find_centres(mesh: PolyMesh) -> np.ndarray:
    """Mean of the points of each cell [m], shape (n, 3): a point inside, where the cell is star-shaped about it."""
    number = np.arange(mesh.count)
    cells = take_apart(mesh, np.zeros((mesh.count, 3)), number, np.arange(len(mesh.points)))
    corners = cells.corners
    pairs = np.unique(np.repeat(number, corners.lengths) * len(mesh.points) + corners.values)
    cell, point = np.divmod(pairs, len(mesh.points))
    sums = np.stack([np.bincount(cell, mesh.points[point, axis]) for axis in range(3)], axis=1)
    return sums / np.bincount(cell)[:, None]

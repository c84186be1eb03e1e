"""A mesh of polyhedra on a regular grid: which cell is at a place, and means over the depth of what is inside."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy
from mpi4py import MPI

from fbcouple.geometry.grid import Grid
from fbcouple.geometry.polyhedra import Polyhedra

OUTSIDE = -1
PARTS = 3
"""Points along each axis that stand for a place of the grid: which part of it is inside of the mesh, in which cells."""

Find = Callable[[np.ndarray], np.ndarray]
"""Rows (n,) of this rank's cells that hold points (n, 3) [m], OUTSIDE where none does."""


def open_finder(cells: Polyhedra, bricks: Grid | None) -> Find:
    """How the cells of points are found among this rank's `cells`, `bricks` being their grid if they have one."""
    if not len(cells):
        return lambda points: np.full(len(points), OUTSIDE, np.int64)
    if bricks:
        return _open_brick_finder(cells, bricks)
    from fbcouple.geometry.locator import Locator  # noqa: PLC0415  (asked for once)
    from fbcouple.geometry.tetrahedra import cut  # noqa: PLC0415

    locator = Locator(cut(cells))
    low, high = cells.points.min(axis=0), cells.points.max(axis=0)

    def find(points: np.ndarray) -> np.ndarray:
        found = np.full(len(points), OUTSIDE, np.int64)
        near = np.flatnonzero(np.all((points >= low) & (points <= high), axis=1))
        found[near] = locator.find_cells(points[near])
        return found

    return find


def _open_brick_finder(cells: Polyhedra, bricks: Grid) -> Find:
    rows = np.full(bricks.cells, OUTSIDE, np.int64)
    rows[tuple(bricks.indices(cells.centres).T)] = np.arange(len(cells))

    def find(points: np.ndarray) -> np.ndarray:
        indices = np.floor(bricks.measure_from_corner(points) / bricks.spacing).astype(np.int64)
        inside = np.all((indices >= 0) & (indices < bricks.cells), axis=1)
        return np.where(inside, rows[tuple(np.clip(indices, 0, np.array(bricks.cells) - 1).T)], OUTSIDE)

    return find


def find_samples(comm: MPI.Comm, find: Find, ids: np.ndarray, grid: Grid, parts: int = 1) -> np.ndarray:
    """Numbers, (z, y, x) times `parts`, of the cells at the centres of the places of `grid`, each cut into `parts`
    along each axis; of two cells that meet there the one with the higher number; OUTSIDE of the mesh (collective)."""
    axes = [grid.origin[k] + (np.arange(grid.cells[k] * parts) + 0.5) * grid.spacing[k] / parts for k in range(3)]
    z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
    rows = find(np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1))
    own = np.where(rows >= 0, ids[rows] if len(ids) else OUTSIDE, OUTSIDE).astype(np.int64)
    found = np.empty_like(own)
    comm.Allreduce(own, found, MPI.MAX)
    return found.reshape(z.shape)


class DepthMean:
    """Means over y of values in the cells: each place of the grid counts with the part of it that is in the mesh."""

    def __init__(self, comm: MPI.Comm, find: Find, ids: np.ndarray, grid: Grid) -> None:
        """`find` and `ids` are of this rank's cells (collective)."""
        nx, ny, nz = grid.cells
        self._comm, self._shape = comm, (nz, nx)
        order = np.argsort(ids)
        rows, columns, counts = [], [], np.zeros((nz, nx))
        for layer in range(nz):
            found = find_samples(comm, find, ids, _cut_layer(grid, layer), PARTS).reshape(-1, ny * PARTS, nx, PARTS)
            counts[layer] = (found >= 0).sum(axis=(0, 1, 3))
            sample = np.broadcast_to(layer * nx + np.arange(nx)[:, None], found.shape)
            at = np.searchsorted(ids[order], found)
            mine = np.zeros(found.shape, bool)
            inside = (found >= 0) & (at < len(ids))
            mine[inside] = ids[order][at[inside]] == found[inside]
            rows.append(sample[mine])
            columns.append(order[at[mine]])
        row, column = np.concatenate(rows), np.concatenate(columns)
        self._sums = scipy.sparse.csr_matrix((np.ones(len(row)), (row, column)), (nz * nx, len(ids)))
        self._counts = counts

    def find(self, values: np.ndarray) -> np.ndarray | None:
        """The mean of `values` (n,) of this rank's cells, (z, x), on rank 0; nan where nothing is inside of the mesh
        (collective)."""
        sums = self._sums @ values
        total = np.empty_like(sums)
        self._comm.Reduce(sums, total)
        if self._comm.rank:
            return None
        return total.reshape(self._shape) / np.where(self._counts > 0.0, self._counts, np.nan)


def _cut_layer(grid: Grid, layer: int) -> Grid:
    x, y, z = grid.origin
    width, depth, _ = grid.size
    height = float(grid.spacing[2])
    return Grid((*grid.cells[:2], 1), (width, depth, height), origin=(x, y, z + layer * height))

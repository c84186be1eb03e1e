"""The gas cells of this rank in a box, as records and results see them."""

from __future__ import annotations

from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.geometry.grid import Grid
from fbcouple.geometry.overlap import find_bounds

Part = tuple[np.ndarray, np.ndarray]
"""Numbers of a rank's cells, as `owned`, and their rows of values (n, components)."""


class BoxCells:
    """Cells of a box: `owned` (n, 3) are index triples, of the `shape` of the grid."""

    has_layers = True

    def __init__(self, grid: Grid, owned: np.ndarray) -> None:
        self.grid, self.owned, self.shape = grid, owned, grid.cells

    def add_up(self, densities: np.ndarray) -> float:
        """Sum over this rank's cells of values per volume (n,)."""
        return float(densities.sum()) * self.grid.cell_volume

    def arrange(self, parts: list[Part]) -> np.ndarray:
        """The values of all ranks, (z, y, x) or (component, z, y, x)."""
        return self.grid.assemble(parts)

    def prepare_samples(self, comm: MPI.Comm) -> None:
        """Nothing is to be found: the cells are the places of the grid."""

    def sample(self, parts: list[Part]) -> np.ndarray:
        """The values of all ranks at the places of the grid, (z, y, x) or (component, z, y, x)."""
        return self.arrange(parts)

    def find_holders(self, comm: MPI.Comm, points: np.ndarray) -> np.ndarray:
        """Rows (n,) of this rank's cells that hold `points` (n, 3) [m], -1 for points in cells of others; one on a wall
        is in the cell inside."""
        return find_rows(self.grid, self.owned, points)

    def open_depth_mean(self, comm: MPI.Comm) -> BoxDepthMean:
        """Means over the depth."""
        return BoxDepthMean(comm, self.grid, self.owned)

    def describe(self, comm: MPI.Comm) -> dict[str, Any]:
        """What results say of the cells beside the grid: nothing."""
        return {}

    def find_shortest_edge(self, comm: MPI.Comm) -> float:
        """Shortest edge [m] of a cell."""
        return float(self.grid.spacing.min())

    def find_outside(self, positions: np.ndarray) -> int | None:
        """Row of the first of `positions` (n, 3) [m] that is behind a wall; None if none is."""
        return find_outside(self.grid, positions)

    def add_layers(self, comm: MPI.Comm, values: np.ndarray) -> np.ndarray | None:
        """Sum of a value per cell (n,) over each layer of cells and all ranks (collective)."""
        return comm.allreduce(np.bincount(self.owned[:, 2], values, minlength=self.grid.cells[2]))

    def find_profile(
        self, comm: MPI.Comm, positions: np.ndarray, radii: np.ndarray, voidage: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Mean solids fraction of each layer of cells, from the particles whose centres are in it, and the middles of
        the layers above the floor [m]; the gas's `voidage` (n,) is not asked (collective)."""
        layers, height = self.grid.cells[2], self.grid.size[2]
        volumes = 4.0 / 3.0 * np.pi * radii**3
        layer = np.clip((positions[:, 2] / height * layers).astype(int), 0, layers - 1)
        sums = comm.allreduce(np.bincount(layer, volumes, minlength=layers))
        return sums / (self.grid.cell_volume * self.grid.cells[0] * self.grid.cells[1]), self.grid.centres(2)


class BoxDepthMean:
    """Means over y of values in the cells."""

    def __init__(self, comm: MPI.Comm, grid: Grid, owned: np.ndarray) -> None:
        nx, self._depth, nz = grid.cells
        self._comm, self._shape = comm, (nz, nx)
        self._columns = owned[:, 2] * nx + owned[:, 0]

    def find(self, values: np.ndarray) -> np.ndarray | None:
        """The mean of `values` (n,) of this rank's cells, (z, x), on rank 0 (collective)."""
        nz, nx = self._shape
        sums = np.bincount(self._columns, values, minlength=nz * nx)
        total = np.empty_like(sums)
        self._comm.Reduce(sums, total)
        return None if self._comm.rank else (total / self._depth).reshape(nz, nx)


def find_rows(grid: Grid, owned: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Rows (n,) of the cells `owned` (cells, 3), index triples in `grid`, that hold `points` (n, 3) [m]; -1 where none
    does. A point on a wall is in the cell inside."""
    indices = np.floor(grid.measure_from_corner(points) / grid.spacing).astype(np.int64)
    rows = np.full(grid.cells, -1)
    rows[tuple(owned.T)] = np.arange(len(owned))
    return rows[tuple(np.clip(indices, 0, np.array(grid.cells) - 1).T)]


def find_outside(grid: Grid, positions: np.ndarray) -> int | None:
    """Row of the first of `positions` (n, 3) [m] that is behind a wall of the box `grid`; None if none is."""
    bottom, walled = np.array(grid.origin), ~np.array(grid.periodic)
    top = bottom + grid.size
    low, high = find_bounds(positions)
    if not (walled & ((low < bottom) | (high > top))).any():
        return None
    return int((((positions < bottom) | (positions > top)) & walled).any(axis=1).argmax())

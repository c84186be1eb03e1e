"""The gas cells of this rank in a mesh of polyhedra, as records and results see them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.coupling.box.cells import Part, find_outside, find_rows
from fbcouple.coupling.polyhedral.sampling import DepthMean, Find, find_samples, open_finder
from fbcouple.geometry.grid import Grid
from fbcouple.geometry.holders import find_holders
from fbcouple.geometry.polyhedra import Polyhedra


class MeshCells:
    """Cells of a mesh of polyhedra: `owned` (n, 1) are their numbers in the whole mesh, of `shape` (count,).

    `grid` is the regular grid that results are sampled on; `bricks` that of the cells where they are a plain box.
    """

    has_layers = False

    def __init__(
        self, comm: MPI.Comm, grid: Grid, cells: Polyhedra, volumes: np.ndarray, bricks: Grid | None = None
    ) -> None:
        self._bricks = bricks
        self.grid, self.owned, self.volumes = grid, cells.ids[:, None], volumes
        self._cells = cells
        self._about: dict[str, Any] | None = None
        self._samples: np.ndarray | None = None
        self._finder: Find | None = None
        self.shape = (comm.allreduce(len(cells)),)
        layer = np.floor((cells.centres[:, 2] - grid.origin[2]) / grid.spacing[2]).astype(int)
        self._layer = np.clip(layer, 0, grid.cells[2] - 1)
        self._layer_volumes = comm.allreduce(self._sort(volumes))

    def add_up(self, densities: np.ndarray) -> float:
        """Sum over this rank's cells of values per volume (n,)."""
        return float(densities @ self.volumes)

    def find_shortest_edge(self, comm: MPI.Comm) -> float:
        """Cube root of the smallest volume of a cell [m] (collective)."""
        return comm.allreduce(float(self.volumes.min(initial=math.inf)), MPI.MIN) ** (1.0 / 3.0)

    def find_outside(self, positions: np.ndarray) -> int | None:
        """None: the cell of every particle is looked for in every step, and one without a cell ends the run there. In
        a plain box that is not so, and the first row of one behind a wall is found here."""
        return find_outside(self._bricks, positions) if self._bricks else None

    def add_layers(self, comm: MPI.Comm, values: np.ndarray) -> np.ndarray | None:
        """None: polyhedra have no layers."""
        return None

    def find_profile(
        self, comm: MPI.Comm, positions: np.ndarray, radii: np.ndarray, voidage: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Mean solids fraction of the cells whose centres are in each layer of the grid, from `voidage` (n,), and the
        middles of the layers above the lowest point [m]; layers without a cell are left out (collective)."""
        assert voidage is not None, "a mesh of polyhedra has gas"
        sums = comm.allreduce(self._sort((1.0 - voidage) * self.volumes))
        filled = self._layer_volumes > 0.0
        return sums[filled] / self._layer_volumes[filled], self.grid.centres(2)[filled] - self.grid.origin[2]

    def _sort(self, amounts: np.ndarray) -> np.ndarray:
        return np.bincount(self._layer, amounts, minlength=self.grid.cells[2])

    def arrange(self, parts: list[Part]) -> np.ndarray:
        """The values of all ranks, (cell,) or (component, cell)."""
        field = np.full((parts[0][1].shape[1], *self.shape), np.nan, dtype=parts[0][1].dtype)
        for owned, values in parts:
            field[:, owned[:, 0]] = values.T
        return field if len(field) > 1 else field[0]

    def prepare_samples(self, comm: MPI.Comm) -> np.ndarray:
        """Number of the cell at each place of the grid, (z, y, x), -1 outside; found once (collective)."""
        if self._samples is None:
            self._samples = find_samples(comm, self._find_rows(), self.owned[:, 0], self.grid)
        return self._samples

    def sample(self, parts: list[Part]) -> np.ndarray:
        """The values of all ranks at the places of the grid, (z, y, x) or (component, z, y, x), nan outside of the
        mesh; after `prepare_samples`."""
        assert self._samples is not None, "places are found before values are put there"
        return np.where(self._samples >= 0, self.arrange(parts)[..., self._samples], np.float32(np.nan))

    def find_holders(self, comm: MPI.Comm, points: np.ndarray) -> np.ndarray:
        """Rows (n,) of this rank's cells that hold `points` (n, 3) [m], -1 for points in cells of others; of cells that
        meet at a point the one with the highest number (collective)."""
        if self._bricks:
            return find_rows(self._bricks, self._bricks.indices(self._cells.centres), points)
        own = find_holders(self._cells, points)
        found = np.empty_like(own)
        comm.Allreduce(own, found, MPI.MAX)
        rows = np.full(self.shape[0] + 1, -1)  # the last one is that of points in no cell
        rows[self._cells.ids] = np.arange(len(self._cells))
        return np.where(own == found, rows[own], -1)

    def open_depth_mean(self, comm: MPI.Comm) -> DepthMean:
        """Means over the depth of what is inside of the mesh; places that are cut count by that part (collective)."""
        return DepthMean(comm, self._find_rows(), self.owned[:, 0], self.grid)

    def _find_rows(self) -> Find:
        if self._finder is None:
            self._finder = open_finder(self._cells, self._bricks)
        return self._finder

    def describe(self, comm: MPI.Comm) -> dict[str, Any]:
        """Centres (cell, 3) [m], volumes (cell,) [m3], points (node, 3) [m] and faces of all cells, and the cell at
        each place of the grid, (z, y, x), -1 outside; on rank 0, nothing on the others (collective)."""
        if self._about is None:
            self._about = self._find_about(comm)
        return self._about

    def _find_about(self, comm: MPI.Comm) -> dict[str, Any]:
        from fbcouple.geometry.polyhedra import join, stream_faces  # noqa: PLC0415  (asked for once)

        parts = comm.gather((self.owned, np.column_stack([self._cells.centres, self.volumes])))
        polyhedra = comm.gather(self._cells)
        samples = self.prepare_samples(comm)
        if parts is None or polyhedra is None:
            return {}
        table, whole = self.arrange(parts), join(polyhedra)
        whole = whole.select(np.argsort(whole.ids))
        about = {"centres": table[:3].T, "volumes": table[3], "samples": samples}
        return about | {"points": whole.points, "faces": stream_faces(whole)}

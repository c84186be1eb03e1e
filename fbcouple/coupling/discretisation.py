"""The two kinds of cells that particles meet: those of a box, and those of a mesh of polyhedra.

A space has all that a coupling needs to know of its cells: who needs which of them (`halo`, with its local), how
particles share themselves among them (`mapping`), how local fields are smoothed, and what volume a cell has.
"""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.derived import wraps
from fbcouple.case.schema.sections import Case
from fbcouple.coupling.box.cells import BoxCells
from fbcouple.coupling.box.diffusion import Diffusion, find_margin
from fbcouple.coupling.box.filter import filtered
from fbcouple.coupling.box.halo import HaloExchange, find_local_grid
from fbcouple.coupling.box.mapping import VOIDAGE_METHODS, Mapping, find_widths
from fbcouple.coupling.polyhedral.cells import MeshCells
from fbcouple.coupling.polyhedral.filter import CellFilter, CellGeometry
from fbcouple.coupling.polyhedral.halo import CellHaloExchange
from fbcouple.coupling.polyhedral.mapping import CELL_METHODS, CellMapping
from fbcouple.geometry.grid import Grid
from fbcouple.geometry.polyhedra import Polyhedra

LINEAR_RING = 1
"""Rings of cells around a particle's own that its weights reach."""


class BoxSpace:
    """Cells of a box; its smoothing is symmetric, the same for what is read and what is written."""

    def __init__(
        self,
        case: Case,
        comm: MPI.Comm,
        centres: np.ndarray,
        bounds: np.ndarray,
        reach: float,
        bricks: tuple[Grid, np.ndarray] | None = None,
    ) -> None:
        """`centres` (cells, 3) [m] of this rank's gas cells; `bounds` (2, 3) [m] of its particles' box, which they
        may leave by `reach` [m]; `bricks`: grid and cell volumes (cells,) [m3] of a mesh from a file that is a plain
        box (collective)."""
        assert case.exchange is not None
        grid = bricks[0] if bricks else Grid(case.domain.cells, case.domain.size, wraps(case.domain))
        method, widths = VOIDAGE_METHODS[case.exchange.voidage], find_widths(case)
        reach += method.find_reach(widths)
        widen = case.exchange.filter_passes + find_margin(grid.spacing, widths.diffusion)
        local = find_local_grid(grid, bounds[0], bounds[1], reach, widen)
        self.rise = int(widen[2])
        """Layers that smoothing carries values up."""
        self.halo = HaloExchange(comm, local, grid.indices(centres))
        self.mapping: Mapping = method(local, widths)
        self.volumes = bricks[1] if bricks else np.full(len(centres), grid.cell_volume)
        self.make_field = local.make_field
        self._diffusion = Diffusion(local, widths.diffusion) if widths.diffusion else None
        self._passes = case.exchange.filter_passes
        self.needs_scratch = self._passes > 0
        self.filter_written = self.average

    def average(self, field: np.ndarray, scratch: np.ndarray) -> np.ndarray:
        """Diffuse and filter a local field as far as the case asks for it; the operators commute."""
        if self._diffusion:
            self._diffusion.smooth(field)
        return filtered(field, self._passes, scratch)


class MeshSpace:
    """Cells of a mesh of polyhedra; what is written is smoothed by the transpose of what is read."""

    rise = 0
    needs_scratch = False

    def __init__(
        self, case: Case, comm: MPI.Comm, own: Polyhedra, volumes: np.ndarray, bounds: np.ndarray, reach: float
    ) -> None:
        """`own`: this rank's gas cells, of `volumes` (cells,) [m3] (collective)."""
        assert case.exchange is not None
        passes = case.exchange.filter_passes
        self.halo = CellHaloExchange(comm, own, bounds[0] - reach, bounds[1] + reach, LINEAR_RING + passes)
        geometry = CellGeometry(self.halo.local)
        self.mapping: CellMapping = CELL_METHODS[case.exchange.voidage](geometry)
        self.volumes = volumes
        self.make_field = self.halo.local.make_field
        self._filter = CellFilter(geometry, passes)

    def average(self, field: np.ndarray, scratch: np.ndarray) -> np.ndarray:
        """Filter what particles read."""
        return self._filter.average(field)

    def filter_written(self, field: np.ndarray, scratch: np.ndarray) -> np.ndarray:
        """Filter what particles wrote."""
        return self._filter.average_transposed(field)


Space = BoxSpace | MeshSpace
Cells = BoxCells | MeshCells
"""Both have the same methods, and attributes `grid`, `owned` and `shape`; nobody asks which of the two they are."""

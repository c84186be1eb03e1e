"""Weights of particles in a mesh of polyhedra, and the filter on it.

A cell is cut into tetrahedra (fbcouple/geometry/tetrahedra.py). A field is linear on each of them: at the cell's centre
it has the cell's value, at a point of the mesh the mean of the cells around it, at the middle of a face the mean of its
points. The mean weighs each cell by the part of it that is nearest to the point, m_ci [m3]. So weights are never
negative, add up to one, change without a jump from cell to cell, and particles that are spread evenly give every cell
the same solids fraction. The paper's weights (eq. 28) are these at the points alone, where its gas has its values.

The filter is the paper's eq. 31 for values of cells: to the points and back with the same parts, F = V^-1 m D^-1 m^T
with the cells' volumes V and the points' D. It is symmetric, V F = (V F)^T; on a box of hexahedra it is the box's own
filter (1/4, 1/2, 1/4).
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from scipy import sparse

from fbcouple.coupling.box.corners import Stencil
from fbcouple.coupling.particles import report_outside
from fbcouple.coupling.polyhedral.halo import CellPatch
from fbcouple.geometry.locator import Locator
from fbcouple.geometry.tetrahedra import cut, share_volumes
from fbcouple.physics.jit import compiled


class Rows:
    """A sparse matrix whose product with columns of a field is written in place."""

    def __init__(self, matrix: sparse.spmatrix) -> None:
        matrix = sparse.csr_matrix(matrix)
        matrix.sort_indices()
        self.shape = matrix.shape
        self._parts = matrix.indptr.astype(np.int64), matrix.indices.astype(np.int64), matrix.data.astype(float)

    def multiply(self, field: np.ndarray, columns: int, result: np.ndarray) -> None:
        """Set the first `columns` of `result` (rows, >= columns) to the product with those of `field`."""
        _multiply(*self._parts, field, columns, result, 0.0)

    def add_product(self, field: np.ndarray, columns: int, result: np.ndarray) -> None:
        """Add the product with the first `columns` of `field` to those of `result`."""
        _multiply(*self._parts, field, columns, result, 1.0)


class CellGeometry:
    """What weights and filter are made of: the tetrahedra of a patch, m, V and D."""

    def __init__(self, patch: CellPatch) -> None:
        self.patch = patch
        self.parts = cut(patch.cells)
        shares = share_volumes(self.parts)
        self.volumes = np.asarray(shares.sum(axis=1)).ravel()
        around = np.asarray(shares.sum(axis=0)).ravel()
        self.to_points = sparse.csr_matrix(sparse.diags(1.0 / around) @ shares.T)
        self.to_cells = sparse.csr_matrix(sparse.diags(1.0 / self.volumes) @ shares)
        self.to_sites = sparse.csr_matrix(sparse.vstack([self.to_points, self.parts.middles @ self.to_points]))


class CellFilter:
    """The conservative filter on the cells of a patch, `passes` times.

    The outermost rings of a patch get wrong values, a ring a pass: it is widened by so many.
    """

    def __init__(self, geometry: CellGeometry, passes: int) -> None:
        self._passes = passes
        self._volumes = geometry.volumes[:, None]
        self._to_points, self._to_cells = Rows(geometry.to_points), Rows(geometry.to_cells)
        self._points: dict[int, np.ndarray] = {}

    def average(self, field: np.ndarray) -> np.ndarray:
        """Filter values per volume, (cells + 1, c), in place: what particles read."""
        columns = field.shape[1]
        if columns not in self._points:
            self._points[columns] = np.empty((self._to_points.shape[0], columns))
        for _ in range(self._passes):
            self._to_points.multiply(field, columns, self._points[columns])
            self._to_cells.multiply(self._points[columns], columns, field)
        return field

    def spread(self, field: np.ndarray) -> np.ndarray:
        """Filter amounts, (cells + 1, c), in place: what particles write. The transpose of `average`; totals stay."""
        if self._passes:
            field[:-1] /= self._volumes
            self.average(field)
            field[:-1] *= self._volumes
        return field


class CellMapping(ABC):
    """How particles and the cells of a patch exchange values; the interface of voidage.Mapping."""

    def __init__(self, geometry: CellGeometry) -> None:
        self._patch = geometry.patch
        inner = geometry.patch.inner
        self._locator = Locator(geometry.parts, inner) if len(inner) else None
        self._room = -1
        self._count = 0
        self._corners = np.zeros(8, np.uint64)

    @property
    def layers(self) -> int:
        """All rows of the patch may hold something."""
        return len(self._patch.cells)

    @property
    def stencil(self) -> Stencil:
        """For the kernels of forces each particle stands on a cell of its own."""
        return Stencil(self._own[: self._count], self._upper[: self._count], self._corners)

    @property
    def cells(self) -> np.ndarray:
        """Row of the patch, (n,), of the cell that each particle lies in."""
        return self.sites[:, 0]

    def locate(self, positions: np.ndarray, radii: np.ndarray) -> None:
        """Find the weights of particles at `positions` (n, 3) [m].

        Raises DivergedError, with the place, if a particle is in none of the cells that it may be in.
        """
        self._count = len(positions)
        if self._count > self._room:
            self._room = self._count + self._count // 4
            self._own, self._upper = np.arange(self._room, dtype=np.uint64), np.zeros((self._room, 3))
            self._found = np.empty(self._room, np.int64)
            self._all_weights, self._all_sites = np.empty((self._room, 4)), np.empty((self._room, 4), np.int64)
            self._rows: dict[tuple[int, str], np.ndarray] = {}
        self.weights, self.sites = self._all_weights[: self._count], self._all_sites[: self._count]
        if not self._count:
            return
        if self._locator is None:
            report_outside(positions[0], "no cell of the mesh is in its rank's box")
        assert self._locator is not None
        stray = self._locator.locate(np.ascontiguousarray(positions), self._found[: self._count], self.weights)
        if stray >= 0:
            report_outside(positions[stray], "no cell of the mesh that its rank knows holds it")
        np.take(self._locator.corners, self._found[: self._count], axis=0, out=self.sites)

    @abstractmethod
    def read(self, field: np.ndarray, columns: int) -> np.ndarray:
        """Rows (n, columns) of the particles from patch `field`, valid until the next call with as many columns."""

    def open(self, field: np.ndarray) -> np.ndarray:
        """Rows (n, c) for the kernels to add to, before `write`; sets `field` to 0."""
        field.fill(0.0)
        rows = self._find_rows(field.shape[1], "written")
        rows.fill(0.0)
        return rows

    @abstractmethod
    def write(self, rows: np.ndarray, field: np.ndarray) -> None:
        """Add the rows of `open` to patch `field`."""

    def _find_rows(self, components: int, purpose: str) -> np.ndarray:
        key = components, purpose
        if key not in self._rows:
            self._rows[key] = np.empty((self._room, components))
        return self._rows[key][: self._count]


class Linear(CellMapping):
    """Linear on the tetrahedra of a cell."""

    def __init__(self, geometry: CellGeometry) -> None:
        super().__init__(geometry)
        self._to_sites, self._from_sites = Rows(geometry.to_sites), Rows(geometry.to_sites.T)
        self._sites: dict[int, np.ndarray] = {}

    def read(self, field: np.ndarray, columns: int) -> np.ndarray:
        rows, sites = self._find_rows(columns, "read"), self._find_sites(columns)
        self._to_sites.multiply(field, columns, sites)
        _gather(self.sites, self.weights, self.layers, field, sites, rows)
        return rows

    def write(self, rows: np.ndarray, field: np.ndarray) -> None:
        sites = self._find_sites(field.shape[1])
        sites.fill(0.0)
        _scatter(self.sites, self.weights, self.layers, rows, field, sites)
        self._from_sites.add_product(sites, field.shape[1], field)

    def _find_sites(self, columns: int) -> np.ndarray:
        if columns not in self._sites:
            self._sites[columns] = np.empty((self._to_sites.shape[0], columns))
        return self._sites[columns]


class CellOfCentre(CellMapping):
    """All of a particle to the cell that holds its centre (particle centre method)."""

    def read(self, field: np.ndarray, columns: int) -> np.ndarray:
        rows = self._find_rows(columns, "read")
        np.take(field[:, :columns], self.cells, axis=0, out=rows)
        return rows

    def write(self, rows: np.ndarray, field: np.ndarray) -> None:
        _add_up(self.sites, rows, field)


CELL_METHODS: dict[str, type[CellMapping]] = {"trilinear": Linear, "centre": CellOfCentre}
"""By the words of exchange.voidage: those that a mesh of polyhedra has."""


@compiled
def _multiply(starts, columns_of, values, field, columns, result, kept):
    for row in range(len(starts) - 1):
        for q in range(columns):
            result[row, q] = kept * result[row, q] if kept != 0.0 else 0.0
        for k in range(starts[row], starts[row + 1]):
            for q in range(columns):
                result[row, q] += values[k] * field[columns_of[k], q]


@compiled
def _gather(sites, weights, cells, field, others, rows):
    for p in range(len(sites)):
        for q in range(rows.shape[1]):
            rows[p, q] = weights[p, 0] * field[sites[p, 0], q]
        for k in range(1, 4):
            for q in range(rows.shape[1]):
                rows[p, q] += weights[p, k] * others[sites[p, k] - cells, q]


@compiled
def _scatter(sites, weights, cells, rows, field, others):
    for p in range(len(sites)):
        for q in range(rows.shape[1]):
            field[sites[p, 0], q] += weights[p, 0] * rows[p, q]
        for k in range(1, 4):
            for q in range(rows.shape[1]):
                others[sites[p, k] - cells, q] += weights[p, k] * rows[p, q]


@compiled
def _add_up(sites, rows, field):
    for p in range(len(sites)):
        for q in range(rows.shape[1]):
            field[sites[p, 0], q] += rows[p, q]

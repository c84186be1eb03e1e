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
import scipy

from fbcouple.coupling.box.corners import Stencil
from fbcouple.coupling.particles import report_outside
from fbcouple.coupling.polyhedral.halo import LocalCells
from fbcouple.geometry.locator import Locator
from fbcouple.geometry.tetrahedra import cut, share_volumes
from fbcouple.physics.jit import compiled, inlined


class Rows:
    """A sparse matrix whose product with columns of a field is written in place."""

    def __init__(self, matrix: scipy.sparse.spmatrix) -> None:
        matrix = scipy.sparse.csr_matrix(matrix)
        matrix.sort_indices()
        self.shape = matrix.shape
        self._parts = matrix.indptr.astype(np.int64), matrix.indices.astype(np.int64), matrix.data.astype(float)

    def multiply(self, field: np.ndarray, columns: int, result: np.ndarray) -> None:
        """Set the first `columns` of `result` (rows, >= columns) to the product with those of `field`."""
        _multiply(*self._parts, field, columns, result)

    def multiply_some(self, some: np.ndarray, field: np.ndarray, columns: int, result: np.ndarray) -> None:
        """The same for the rows `some` alone; the others stay as they are."""
        _multiply_some(*self._parts, some, field, columns, result)

    def add_back(self, some: np.ndarray, rows: np.ndarray, columns: int, field: np.ndarray) -> None:
        """Add the product of the transpose with the `rows` at `some` to the first `columns` of `field`."""
        _add_back(*self._parts, some, rows, columns, field)

    def mark_columns(self, some: np.ndarray, marks: np.ndarray) -> None:
        """Set `marks` at all columns that the rows `some` have entries in."""
        _mark_columns(self._parts[0], self._parts[1], some, marks)


class CellGeometry:
    """What weights and filter are made of: the local tetrahedra, m, V and D."""

    def __init__(self, local: LocalCells) -> None:
        self.local = local
        self.parts = cut(local.cells)
        shares = share_volumes(self.parts)
        self.volumes = np.asarray(shares.sum(axis=1)).ravel()
        around = np.asarray(shares.sum(axis=0)).ravel()
        self.to_points = scipy.sparse.csr_matrix(scipy.sparse.diags(1.0 / around) @ shares.T)
        self.to_cells = scipy.sparse.csr_matrix(scipy.sparse.diags(1.0 / self.volumes) @ shares)


class CellFilter:
    """The conservative filter on the local cells, `passes` times.

    The outermost rings of local cells get wrong values, a ring a pass: so many are added.
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

    def average_transposed(self, field: np.ndarray) -> np.ndarray:
        """Filter amounts, (cells + 1, c), in place: what particles write. The transpose of `average`; totals stay."""
        if self._passes:
            field[:-1] /= self._volumes
            self.average(field)
            field[:-1] *= self._volumes
        return field


class CellMapping(ABC):
    """How particles and the local cells exchange values; the interface of voidage.Mapping."""

    def __init__(self, geometry: CellGeometry) -> None:
        self._local = geometry.local
        inner = geometry.local.inner
        self._locator = Locator(geometry.parts, inner) if len(inner) else None
        self._room = -1
        self._count = 0
        self._corners = np.zeros(8, np.uint64)
        self._marks = np.zeros(len(geometry.parts.nodes), bool)

    @property
    def layers(self) -> int:
        """All local rows may hold something."""
        return len(self._local.cells)

    @property
    def stencil(self) -> Stencil:
        """For the kernels of forces each particle stands on a cell of its own."""
        return Stencil(self._own[: self._count], self._upper[: self._count], self._corners)

    @property
    def cells(self) -> np.ndarray:
        """Local row, (n,), of the cell that each particle lies in."""
        return self.sites[:, 0]

    def locate(self, positions: np.ndarray, radii: np.ndarray) -> None:
        """Find the weights of particles at `positions` (n, 3) [m].

        Raises DivergedError, with the place, if a particle is in none of the cells that it may be in.
        """
        self._count = len(positions)
        if self._count > self._room:
            self._room = self._count + self._count // 4
            self._own, self._upper = np.arange(self._room, dtype=np.uint64), np.zeros((self._room, 3))
            self._found = np.full(self._room, -1)
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
        self._marks.fill(False)
        _look_up(self._locator.corners, self._found[: self._count], self.sites, self._marks)

    @abstractmethod
    def read(self, field: np.ndarray, columns: int) -> np.ndarray:
        """Rows (n, columns) of the particles from local `field`, valid until the next call with as many columns."""

    def open(self, field: np.ndarray) -> np.ndarray:
        """Rows (n, c) for the kernels to add to, before `write`; sets `field` to 0."""
        field.fill(0.0)
        rows = self._find_rows(field.shape[1], "written")
        rows.fill(0.0)
        return rows

    @abstractmethod
    def write(self, rows: np.ndarray, field: np.ndarray) -> None:
        """Add the rows of `open` to local `field`."""

    def _find_rows(self, components: int, purpose: str) -> np.ndarray:
        key = components, purpose
        if key not in self._rows:
            self._rows[key] = np.empty((self._room, components))
        return self._rows[key][: self._count]


class Linear(CellMapping):
    """Linear on the tetrahedra of a cell; only sites at which a particle has weight are looked at."""

    def __init__(self, geometry: CellGeometry) -> None:
        super().__init__(geometry)
        self._points, self._middles = Rows(geometry.to_points), Rows(geometry.parts.middles)
        self._some_points = self._some_middles = np.empty(0, np.int64)
        self._sites: dict[int, np.ndarray] = {}

    def locate(self, positions: np.ndarray, radii: np.ndarray) -> None:
        super().locate(positions, radii)
        points, middles = np.split(self._marks[self.layers :], [self._points.shape[0]])
        self._some_middles = np.flatnonzero(middles)
        self._middles.mark_columns(self._some_middles, points)
        self._some_points = np.flatnonzero(points)

    def read(self, field: np.ndarray, columns: int) -> np.ndarray:
        rows, points, middles = self._find_rows(columns, "read"), *self._find_sites(columns)
        self._points.multiply_some(self._some_points, field, columns, points)
        self._middles.multiply_some(self._some_middles, points, columns, middles)
        _gather(self.sites, self.weights, self.layers, field, self._sites[columns], rows)
        return rows

    def write(self, rows: np.ndarray, field: np.ndarray) -> None:
        columns = field.shape[1]
        points, middles = self._find_sites(columns)
        points[self._some_points] = 0.0
        middles[self._some_middles] = 0.0
        _scatter(self.sites, self.weights, self.layers, rows, field, self._sites[columns])
        self._middles.add_back(self._some_middles, middles, columns, points)
        self._points.add_back(self._some_points, points, columns, field)

    def _find_sites(self, columns: int) -> tuple[np.ndarray, np.ndarray]:
        """Values at the points and at the middles of faces, parts of one array."""
        points = self._points.shape[0]
        if columns not in self._sites:
            self._sites[columns] = np.empty((points + self._middles.shape[0], columns))
        return self._sites[columns][:points], self._sites[columns][points:]


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
def _multiply(starts, columns_of, values, field, columns, result):
    for row in range(len(starts) - 1):
        _multiply_row(starts, columns_of, values, row, field, columns, result)


@compiled
def _multiply_some(starts, columns_of, values, some, field, columns, result):
    for row in some:
        _multiply_row(starts, columns_of, values, row, field, columns, result)


@inlined
def _multiply_row(starts, columns_of, values, row, field, columns, result):
    """Four columns at once, which are one vector to the compiler, then those that are left."""
    fours = columns - columns % 4
    for q in range(0, fours, 4):
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        for k in range(starts[row], starts[row + 1]):
            weight, here = values[k], field[columns_of[k], q : q + 4]
            a, b, c, d = a + weight * here[0], b + weight * here[1], c + weight * here[2], d + weight * here[3]
        result[row, q], result[row, q + 1], result[row, q + 2], result[row, q + 3] = a, b, c, d
    for q in range(fours, columns):
        total = 0.0
        for k in range(starts[row], starts[row + 1]):
            total += values[k] * field[columns_of[k], q]
        result[row, q] = total


@compiled
def _add_back(starts, columns_of, values, some, rows, columns, field):
    for row in some:
        for k in range(starts[row], starts[row + 1]):
            _add_share(values[k], rows, row, columns, field, columns_of[k])


@inlined
def _add_share(weight, rows, row, columns, field, cell):
    fours = columns - columns % 4
    for q in range(0, fours, 4):
        given, taken = rows[row, q : q + 4], field[cell, q : q + 4]
        a, b = taken[0] + weight * given[0], taken[1] + weight * given[1]
        c, d = taken[2] + weight * given[2], taken[3] + weight * given[3]
        taken[0], taken[1], taken[2], taken[3] = a, b, c, d
    for q in range(fours, columns):
        field[cell, q] += weight * rows[row, q]


@compiled
def _mark_columns(starts, columns_of, some, marks):
    for row in some:
        for k in range(starts[row], starts[row + 1]):
            marks[columns_of[k]] = True


@compiled
def _look_up(corners, found, sites, marks):
    """The sites of each particle's tetrahedron, and marks at all of them."""
    for p in range(len(found)):
        for k in range(4):
            site = corners[found[p], k]
            sites[p, k] = site
            marks[site] = True


@compiled
def _gather(sites, weights, cells, field, others, rows):
    columns = rows.shape[1]
    fours = columns - columns % 4
    for p in range(len(sites)):
        u, v, w, x = weights[p, 0], weights[p, 1], weights[p, 2], weights[p, 3]
        i, j, k, m = sites[p, 0], sites[p, 1] - cells, sites[p, 2] - cells, sites[p, 3] - cells
        for q in range(0, fours, 4):
            f, g, h, s = field[i, q : q + 4], others[j, q : q + 4], others[k, q : q + 4], others[m, q : q + 4]
            a, b = u * f[0] + v * g[0] + w * h[0] + x * s[0], u * f[1] + v * g[1] + w * h[1] + x * s[1]
            c, d = u * f[2] + v * g[2] + w * h[2] + x * s[2], u * f[3] + v * g[3] + w * h[3] + x * s[3]
            rows[p, q], rows[p, q + 1], rows[p, q + 2], rows[p, q + 3] = a, b, c, d
        for q in range(fours, columns):
            rows[p, q] = u * field[i, q] + v * others[j, q] + w * others[k, q] + x * others[m, q]


@compiled
def _scatter(sites, weights, cells, rows, field, others):
    columns = rows.shape[1]
    for p in range(len(sites)):
        _add_share(weights[p, 0], rows, p, columns, field, sites[p, 0])
        for k in range(1, 4):
            _add_share(weights[p, k], rows, p, columns, others, sites[p, k] - cells)


@compiled
def _add_up(sites, rows, field):
    for p in range(len(sites)):
        for q in range(rows.shape[1]):
            field[sites[p, 0], q] += rows[p, q]

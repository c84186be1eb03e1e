"""Weights of particles in a mesh of polyhedra.

A cell is cut into tetrahedra (fbcouple/geometry/tetrahedra.py). A field is linear on each of them: at the cell's centre
it has the cell's value, at a point of the mesh the mean of the cells around it, at the middle of a face the mean of its
points. The mean weighs each cell by the part of it that is nearest to the point, m_ci [m3]. So weights are never
negative, add up to one, change without a jump from cell to cell, and particles that are spread evenly give every cell
the same solids fraction. The paper's weights (eq. 28) are these at the points alone, where its gas has its values.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from fbcouple.coupling.box.corners import Stencil
from fbcouple.coupling.particles import report_outside
from fbcouple.coupling.polyhedral.filter import CellGeometry
from fbcouple.coupling.polyhedral.rows import Rows, add_share
from fbcouple.geometry.locator import Locator
from fbcouple.physics.jit import compiled


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
        add_share(weights[p, 0], rows, p, columns, field, sites[p, 0])
        for k in range(1, 4):
            add_share(weights[p, k], rows, p, columns, others, sites[p, k] - cells)


@compiled
def _add_up(sites, rows, field):
    for p in range(len(sites)):
        for q in range(rows.shape[1]):
            field[sites[p, 0], q] += rows[p, q]

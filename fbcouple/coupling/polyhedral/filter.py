"""The conservative filter on the cells of a mesh of polyhedra.

It is the paper's eq. 31 for values of cells: to the points and back with the same parts m, F = V^-1 m D^-1 m^T
with the cells' volumes V and the points' D. It is symmetric, V F = (V F)^T; on a box of hexahedra it is the box's own
filter (1/4, 1/2, 1/4).
"""

from __future__ import annotations

import numpy as np
import scipy

from fbcouple.coupling.polyhedral.halo import LocalCells
from fbcouple.coupling.polyhedral.rows import Rows
from fbcouple.geometry.tetrahedra import cut, share_volumes


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

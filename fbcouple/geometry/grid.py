"""The box grid that gas cells, particles and averages share: a cell has an index triple (i, j, k)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Grid:
    """A box of `size` [m] from `origin` [m], cut into `cells` equal cells along x, y and z.

    Along a `periodic` axis cell n is cell 0 again, and -1 the last.
    """

    cells: tuple[int, int, int]
    size: tuple[float, float, float]
    periodic: tuple[bool, bool, bool] = (False, False, False)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Not the zero point only for a mesh from a file, and for the grid that its results are sampled on."""

    @property
    def spacing(self) -> np.ndarray:
        """Edge lengths of a cell [m], shape (3,)."""
        return np.array(self.size) / np.array(self.cells)

    @property
    def cell_volume(self) -> float:
        """Volume of a cell [m3]."""
        return float(np.prod(self.spacing))

    @property
    def count(self) -> int:
        """Number of cells."""
        return int(np.prod(self.cells))

    def measure_from_corner(self, points: np.ndarray) -> np.ndarray:
        """`points` (n, 3) [m] as seen from the corner of the box; the same array where that is the zero point."""
        return points - np.array(self.origin) if any(self.origin) else points

    def indices(self, points: np.ndarray) -> np.ndarray:
        """Index triples, int64 (n, 3), of the cells that hold `points` [m], shape (n, 3).

        Raises ValueError if a point lies outside the box.
        """
        found = np.floor(self.measure_from_corner(points) / self.spacing).astype(np.int64)
        if found.size and (found.min() < 0 or np.any(found.max(axis=0) >= self.cells)):
            raise ValueError(f"a point lies outside the box of {self.size} m")
        return found

    def assemble(self, parts: Iterable[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
        """Put values of cells in their places: pairs of index triples (n, 3) and values (n, components) of a part of
        the cells each -> (components, z, y, x), nan in cells of none; without the first axis if it has one component.
        """
        held = list(parts)
        nx, ny, nz = self.cells
        field = np.full((held[0][1].shape[1], nz, ny, nx), np.nan, dtype=held[0][1].dtype)
        for indices, values in held:
            i, j, k = indices.T
            field[:, k, j, i] = values.T
        return field if len(field) > 1 else field[0]

    def centres(self, axis: int) -> np.ndarray:
        """Coordinates [m] of the cell centres along `axis`."""
        return self.origin[axis] + (np.arange(self.cells[axis]) + 0.5) * self.spacing[axis]

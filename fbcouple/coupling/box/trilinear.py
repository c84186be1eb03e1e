"""Where a particle stands in the local grid, and the trilinear weights that carry values both ways (paper, eq. 28).

Fields live at cell centres. Between the outermost centres and a wall the value of the wall's cell holds; along a
periodic axis the cells go on.
"""

from __future__ import annotations

import numpy as np

from fbcouple.coupling.box.halo import LocalGrid
from fbcouple.errors import DivergedError
from fbcouple.physics.compiler import njit

_BLOCK = 128
"""Particles whose coordinates go through the SIMD loop at once: they stay in the first cache."""


class Weights:
    """Stencils of this rank's particles: `base` (n,) flat place of the lower cell, `upper` (n, 3) weight above it."""

    def __init__(self, local: LocalGrid) -> None:
        self._local = local
        nx, ny, _ = local.shape
        axes = 1.0 / local.grid.spacing, *local.walls, local.low, local.high, (1, nx, nx * ny)
        self._box = np.array([np.tile(values, _BLOCK) for values in axes], dtype=float)
        self._room: int = 0
        self._base = np.empty(0, np.uint64)
        self._upper = np.empty((0, 3))
        self.base, self.upper = self._base, self._upper
        self.highest = 0
        """The largest place in `base`."""

    def locate(self, positions: np.ndarray) -> None:
        """Find the stencils of `positions` (n, 3) [m].

        Raises DivergedError, with the place, if a particle has left the local grid: it moved too far in one step.
        """
        n = len(positions)
        if n > self._room:
            self._room = n + n // 4
            self._base, self._upper = np.empty(self._room, np.uint64), np.empty((self._room, 3))
        self.base, self.upper = self._base[:n], self._upper[:n]
        coordinates = np.ascontiguousarray(positions).ravel()
        strays, self.highest = _locate(coordinates, self._box, self.base, self.upper.ravel())
        if strays:
            report_stray(self._local, positions, _find_stray(coordinates, self._box, self.base, self.upper.ravel()))


def report_stray(local: LocalGrid, positions: np.ndarray, stray: int) -> None:
    """Raise DivergedError with the place of the particle `stray` of `positions` (n, 3) [m]; -1 is none."""
    if stray >= 0:
        x, y, z = positions[stray]
        raise DivergedError(
            f"a particle at ({x:.6g}, {y:.6g}, {z:.6g}) m is outside the cells its rank knows "
            f"({local.low} to {local.high}): "
            "it left the box or moved too far in one fluid step; use a smaller step"
        )


@njit(cache=True, error_model="numpy")
def _locate(coordinates, box, base, upper):
    """Fill `base` (n,) and flat `upper` (3 n,) for the flat `coordinates` (3 n,) [m]; returns how many coordinates
    do not fit, and the largest base.

    The rows of `box` have an entry for each of a block's coordinates, x, y, z in turn, so that the loop over them is a
    SIMD loop: cells a metre, first and last cell between walls, edges of the local grid, flat step in it.
    """
    scale, first, last, low, high, step = box[0], box[1], box[2], box[3], box[4], box[5]
    cell = np.empty(len(scale))
    strays, highest = 0, 0.0
    for start in range(0, len(coordinates), len(scale)):
        n = min(len(scale), len(coordinates) - start)
        here, there = coordinates[start : start + n], upper[start : start + n]
        for q in range(n):
            s = here[q] * scale[q] - 0.5
            held = first[q] if s < first[q] else s
            held = last[q] if held > last[q] else held
            lower = np.floor(held)
            weight = held - lower
            end = lower if weight == 0.0 else lower + 1.0
            fits = (s >= first[q] - 1.0) & (s < last[q] + 1.0) & (lower >= low[q]) & (end < high[q])
            strays += 0 if fits else 1
            there[q] = weight
            cell[q] = (lower - low[q]) * step[q]
        block = base[start // 3 : (start + n) // 3]
        for q in range(n // 3):
            index = cell[3 * q] + cell[3 * q + 1] + cell[3 * q + 2]
            highest = index if index > highest else highest
            block[q] = np.uint64(np.int64(index))
    return strays, int(highest)


def _find_stray(coordinates, box, base, upper):
    """The first particle that does not fit."""
    rows = (slice(3 * p, 3 * p + 3) for p in range(len(base)))
    strays = (_locate(coordinates[three], box, base[p : p + 1], upper[three])[0] for p, three in enumerate(rows))
    return next(p for p, count in enumerate(strays) if count)

"""Where a particle stands in the patch, and the trilinear weights that carry values both ways (paper, eq. 28).

Fields live at cell centres. Between the outermost centres and a wall the value of the wall's cell holds.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fbcouple.errors import DivergedError
from fbcouple.exchange.plan import Patch


class Weights:
    """Stencils of this rank's particles: `base` (n,) flat place of the lower cell, `upper` (n, 3) weight above it."""

    def __init__(self, patch: Patch) -> None:
        self._patch = patch
        self._room = 0
        self._base = np.empty(0, np.int64)
        self._upper = np.empty((0, 3))
        self.base, self.upper = self._base, self._upper

    def locate(self, positions: np.ndarray) -> None:
        """Find the stencils of `positions` (n, 3) [m].

        Raises DivergedError, with the place, if a particle has left the patch: it moved too far in one step.
        """
        n = len(positions)
        if n > self._room:
            self._room = n + n // 4
            self._base, self._upper = np.empty(self._room, np.int64), np.empty((self._room, 3))
        self.base, self.upper = self._base[:n], self._upper[:n]
        patch = self._patch
        low, high = np.array(patch.low), np.array(patch.high)
        stray = _locate(positions, patch.grid.spacing, low, high, np.array(patch.grid.cells), self.base, self.upper)
        if stray >= 0:
            x, y, z = positions[stray]
            raise DivergedError(
                f"a particle at ({x:.6g}, {y:.6g}, {z:.6g}) m is outside the cells its rank knows "
                f"({low} to {high}): it left the box or moved too far in one fluid step; use a smaller step"
            )


@njit(cache=True)
def _locate(positions, spacing, low, high, cells, base, upper):
    ny = high[1] - low[1] + 1
    nz = high[2] - low[2] + 1
    for p in range(len(positions)):
        place = np.int64(0)
        for axis in range(3):
            s = positions[p, axis] / spacing[axis] - 0.5
            if not (-1.0 <= s <= cells[axis]):
                return p
            i = np.int64(np.floor(s))
            w = s - i
            if i < 0:
                i, w = 0, 0.0
            elif i >= cells[axis] - 1:
                i, w = cells[axis] - 1, 0.0
            if i < low[axis] or (i >= high[axis]) or (i + 1 >= high[axis] and w > 0.0):
                return p
            upper[p, axis] = w
            i -= low[axis]
            if axis == 0:
                place = i
            elif axis == 1:
                place = place * ny + i
            else:
                place = place * nz + i
        base[p] = place
    return -1


@njit(cache=True, inline="always")
def corner_weight(corner, w):
    """Trilinear weight of corner 0-7 (bits: x, y, z) for upper weights `w` (3,)."""
    wx = w[0] if corner & 4 else 1.0 - w[0]
    wy = w[1] if corner & 2 else 1.0 - w[1]
    wz = w[2] if corner & 1 else 1.0 - w[2]
    return wx * wy * wz


def corner_offsets(patch: Patch) -> np.ndarray:
    """Flat steps (8,) from the lower cell of a stencil to its corners, in the order of `corner_weight`."""
    _, ny, nz = patch.shape
    return np.array([(c >> 2 & 1) * ny * nz + (c >> 1 & 1) * nz + (c & 1) for c in range(8)])

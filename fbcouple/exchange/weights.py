"""Where a particle stands in the patch, and the trilinear weights that carry values both ways (paper, eq. 28).

Fields live at cell centres. Between the outermost centres and a wall the value of the wall's cell holds; along a
periodic axis the cells go on.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fbcouple.errors import DivergedError
from fbcouple.exchange.plan import Patch


class Weights:
    """Stencils of this rank's particles: `base` (n,) flat place of the lower cell, `upper` (n, 3) weight above it."""

    def __init__(self, patch: Patch) -> None:
        grid, self._patch = patch.grid, patch
        self._box = 1.0 / grid.spacing, np.array(patch.low), np.array(patch.high), patch.walls
        self._room: int = 0
        self._base = np.empty(0, np.uint64)
        self._upper = np.empty((0, 3))
        self.base, self.upper = self._base, self._upper

    def locate(self, positions: np.ndarray) -> None:
        """Find the stencils of `positions` (n, 3) [m].

        Raises DivergedError, with the place, if a particle has left the patch: it moved too far in one step.
        """
        n = len(positions)
        if n > self._room:
            self._room = n + n // 4
            self._base, self._upper = np.empty(self._room, np.uint64), np.empty((self._room, 3))
        self.base, self.upper = self._base[:n], self._upper[:n]
        stray = _locate(positions, *self._box, self.base, self.upper)
        report_stray(self._patch, positions, stray)


def report_stray(patch: Patch, positions: np.ndarray, stray: int) -> None:
    """Raise DivergedError with the place of the particle `stray` of `positions` (n, 3) [m]; -1 is none."""
    if stray >= 0:
        x, y, z = positions[stray]
        raise DivergedError(
            f"a particle at ({x:.6g}, {y:.6g}, {z:.6g}) m is outside the cells its rank knows "
            f"({patch.low} to {patch.high}): "
            "it left the box or moved too far in one fluid step; use a smaller step"
        )


@njit(inline="always")
def _stand(s, low, high, first, last):
    """Lower cell in the patch and weight above it for `s`, the place in cells from the first centre; (-1, 0) if out."""
    i = int(np.floor(s))
    w = s - i
    if i < first:
        inside = i == first - 1
        i, w = first, 0.0
    else:
        inside = i <= last
        if i == last:
            w = 0.0
    inside = inside and i >= low and (i + 1 < high or (i < high and w == 0.0))
    return (i - low, w) if inside else (-1, 0.0)


@njit(cache=True)
def _locate(positions, scale, low, high, walls, base, upper):
    nx = high[0] - low[0] + 1
    ny = high[1] - low[1] + 1
    for p in range(len(positions)):
        i, wx = _stand(positions[p, 0] * scale[0] - 0.5, low[0], high[0], walls[0, 0], walls[1, 0])
        j, wy = _stand(positions[p, 1] * scale[1] - 0.5, low[1], high[1], walls[0, 1], walls[1, 1])
        k, wz = _stand(positions[p, 2] * scale[2] - 0.5, low[2], high[2], walls[0, 2], walls[1, 2])
        if i < 0 or j < 0 or k < 0:
            return p
        base[p] = (k * ny + j) * nx + i
        upper[p, 0] = wx
        upper[p, 1] = wy
        upper[p, 2] = wz
    return -1

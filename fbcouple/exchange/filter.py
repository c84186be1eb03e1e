"""The conservative filter: (1/4, 1/2, 1/4) along each axis, reflected at walls (paper, eq. 33).

It acts on extensive quantities (solids volume, force) before they are divided by the cell volume, so that totals are
kept to rounding (eq. 34). One pass adds a variance of half a cell size squared along each axis. The operator is
symmetric, so filtering what is read at the particles makes reading the transpose of writing.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from fbcouple.exchange.plan import Patch


def filter_field(patch: Patch, field: np.ndarray, passes: int) -> None:
    """Filter patch `field` (x + 1, y + 1, z + 1, c) in place, `passes` times.

    Walls reflect. An edge of the patch inside the domain reflects too, which is wrong there: the patch is widened by
    one cell a pass for that reason.
    """
    x, y, z = patch.shape
    inside = field[: x - 1, : y - 1, : z - 1]
    for _ in range(passes):
        for axis in range(3):
            _smooth(np.moveaxis(inside, axis, 0))


@njit(cache=True)
def _smooth(field):
    n, rows, columns, components = field.shape
    for i in range(rows):
        for j in range(columns):
            for c in range(components):
                before = field[0, i, j, c]
                here = before
                for m in range(n):
                    after = field[m + 1, i, j, c] if m + 1 < n else here
                    field[m, i, j, c] = 0.25 * before + 0.5 * here + 0.25 * after
                    before = here
                    here = after

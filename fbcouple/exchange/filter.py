"""The conservative filter: (1/4, 1/2, 1/4) along each axis, reflected at walls (paper, eq. 33).

It acts on extensive quantities (solids volume, force) before they are divided by the cell volume, so that totals are
kept to rounding (eq. 34). One pass adds a variance of half a cell size squared along each axis. The operator is
symmetric, so filtering what is read at the particles makes reading the transpose of writing.
"""

from __future__ import annotations

import numpy as np

from fbcouple.exchange.compiled import compiled
from fbcouple.exchange.plan import Patch


def filter_field(patch: Patch, field: np.ndarray, passes: int) -> None:
    """Filter patch `field` (z + 1, y + 1, x + 1, c) in place, `passes` times.

    Walls reflect. An edge of the patch inside the domain reflects too, which is wrong there: the patch is widened by
    one cell a pass for that reason.
    """
    x, y, z = patch.shape
    other = np.zeros_like(field)
    for _ in range(passes):
        _smooth(field.reshape(1, z, -1), other.reshape(1, z, -1))
        _smooth(other.reshape(z, y, -1), field.reshape(z, y, -1))
        _smooth(field.reshape(z * y, x, -1), other.reshape(z * y, x, -1))
        field[:] = other


@compiled
def _smooth(source, target):
    """Along the middle axis, whose last layer is the extra one and stays zero; all layers of a block are contiguous."""
    blocks, layers, width = source.shape
    last = (layers - 2) * width
    for a in range(blocks):
        old, new = source[a].ravel(), target[a].ravel()
        for q in range(width, last):
            new[q] = 0.25 * (old[q - width] + old[q + width]) + 0.5 * old[q]
        for q in range(width):
            inner = min(width, last)
            new[q] = 0.75 * old[q] + 0.25 * old[q + inner]
            if last > 0:
                new[last + q] = 0.75 * old[last + q] + 0.25 * old[last + q - width]

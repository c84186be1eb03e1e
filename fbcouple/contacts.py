"""How far particles overlap: the largest overlap of two, by a cell list."""

from __future__ import annotations

import numpy as np
from numba import njit


def find_max_overlap(positions: np.ndarray, radii: np.ndarray, count: int) -> float:
    """Largest overlap of two particles over their mean diameter, 0 if none touch.

    positions, radii: (n, 3) and (n,) [m], this rank's `count` particles first, then its neighbours' near its border.
    """
    return find_worst_overlap(positions, radii, count)[0]


def find_worst_overlap(positions: np.ndarray, radii: np.ndarray, count: int) -> tuple[float, int]:
    """The same, and the row of a particle that has it; row -1 if none touch."""
    if count == 0:
        return 0.0, -1
    low = positions.min(axis=0)
    extent = np.maximum(np.ptp(positions, axis=0), 2.0 * radii.max())
    # Bins no smaller than a contact, and no more of them than particles.
    reach = max(2.0 * float(radii.max()), float(np.prod(extent) / len(positions)) ** (1 / 3))
    bins = np.floor((positions - low) / reach).astype(np.int64)
    shape = bins.max(axis=0) + 1
    flat = (bins[:, 0] * shape[1] + bins[:, 1]) * shape[2] + bins[:, 2]
    order = np.argsort(flat, kind="stable")
    starts = np.searchsorted(flat[order], np.arange(int(np.prod(shape)) + 1))
    worst, row = _scan(positions, radii, count, bins, shape, order, starts)
    return float(worst), int(row)


@njit(cache=True)
def _scan(positions, radii, count, bins, shape, order, starts):
    worst, worst_row = 0.0, -1
    for p in range(count):
        for i in range(max(bins[p, 0] - 1, 0), min(bins[p, 0] + 2, shape[0])):
            for j in range(max(bins[p, 1] - 1, 0), min(bins[p, 1] + 2, shape[1])):
                row = (i * shape[1] + j) * shape[2]
                first = starts[row + max(bins[p, 2] - 1, 0)]
                last = starts[row + min(bins[p, 2] + 2, shape[2])]
                for n in range(first, last):
                    q = order[n]
                    if q == p:
                        continue
                    square = 0.0
                    for axis in range(3):
                        square += (positions[p, axis] - positions[q, axis]) ** 2
                    touch = radii[p] + radii[q]
                    if square < touch * touch and (touch - np.sqrt(square)) / touch > worst:
                        worst, worst_row = (touch - np.sqrt(square)) / touch, p
    return worst, worst_row

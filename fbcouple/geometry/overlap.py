"""How far particles overlap: the largest overlap of two, and how many touch, by a cell list."""

from __future__ import annotations

import numpy as np

from fbcouple.physics.compiler import njit


def find_max_overlap(positions: np.ndarray, radii: np.ndarray, count: int) -> float:
    """Largest overlap of two particles over their mean diameter, 0 if none touch.

    positions, radii: (n, 3) and (n,) [m], this rank's `count` particles first, then its neighbours' near its border.
    """
    return find_worst_overlap(positions, radii, count)[0]


def find_worst_overlap(positions: np.ndarray, radii: np.ndarray, count: int) -> tuple[float, int, int]:
    """The same, and the rows of the two that have it, the lower first; -1 if none touch."""
    if count == 0:
        return 0.0, -1, -1
    low, high = find_bounds(positions)
    extent = np.maximum(high - low, 2.0 * radii.max())
    # Bins no smaller than a contact, and no more of them than particles.
    reach = max(2.0 * float(radii.max()), float(np.prod(extent) / len(positions)) ** (1 / 3))
    shape = np.floor((high - low) / reach).astype(np.int64) + 1
    starts, order, sorted_rows = _sort(positions, radii, low, 1.0 / reach, shape)
    worst, row, other = _scan(sorted_rows, order, count, starts, shape)
    return float(worst), int(row), int(other)


def add_images(positions: np.ndarray, period: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Particles and, behind them, their images across periodic sides that a particle at most `reach` [m] off can meet.

    positions: (n, 3) [m]; period: (3,) [m], 0 along axes that are not periodic.
    Returns: positions (m, 3) [m] and of each the row of its particle, int (m,).
    """
    rows = np.arange(len(positions))
    for axis in np.flatnonzero(period):
        low = np.flatnonzero(positions[:, axis] < reach)
        high = np.flatnonzero(positions[:, axis] > period[axis] - reach)
        images = positions[np.concatenate([low, high])]
        images[: len(low), axis] += period[axis]
        images[len(low) :, axis] -= period[axis]
        positions, rows = np.concatenate([positions, images]), np.concatenate([rows, rows[low], rows[high]])
    return positions, rows


@njit(cache=True)
def find_bounds(positions):
    """Lowest and highest coordinates (3,) of `positions` (n, 3) [m]; inf and -inf if there are none."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for p in range(len(positions)):
        for axis in range(3):
            low[axis], high[axis] = min(low[axis], positions[p, axis]), max(high[axis], positions[p, axis])
    return low, high


@njit(cache=True)
def _sort(positions, radii, low, scale, shape):
    """Bins, z fastest: the first particle of each (bins + 1,), the rows of all, and x, y, z, radius in that order."""
    n = len(positions)
    flat = np.empty(n, np.int64)
    starts = np.zeros(shape[0] * shape[1] * shape[2] + 1, np.int64)
    for p in range(n):
        cell = 0
        for axis in range(3):
            bin_ = min(int((positions[p, axis] - low[axis]) * scale), shape[axis] - 1)
            cell = cell * shape[axis] + bin_
        flat[p] = cell
        starts[cell + 1] += 1
    starts = np.cumsum(starts)
    room, order, rows = starts[:-1].copy(), np.empty(n, np.int64), np.empty((n, 4))
    for p in range(n):
        slot = room[flat[p]]
        room[flat[p]] += 1
        order[slot] = p
        rows[slot, 0], rows[slot, 1], rows[slot, 2] = positions[p, 0], positions[p, 1], positions[p, 2]
        rows[slot, 3] = radii[p]
    return starts, order, rows


@njit(cache=True)
def _scan(rows, order, count, starts, shape):
    """Each pair once: a particle with those behind it in its bin and with the bins after it."""
    worst, row, other = 0.0, -1, -1
    for i in range(shape[0]):
        for j in range(shape[1]):
            for k in range(shape[2]):
                here = (i * shape[1] + j) * shape[2] + k
                if starts[here] == starts[here + 1]:
                    continue
                found = _scan_bin(rows, order, count, starts, shape, i, j, k, worst)
                if found[0] > worst:
                    worst, row, other = found
    return worst, row, other


@njit(cache=True)
def _scan_bin(rows, order, count, starts, shape, i, j, k, worst):
    worst_row, worst_other = -1, -1
    own = (i * shape[1] + j) * shape[2] + k
    for a in range(i, min(i + 2, shape[0])):
        for b in range(max(j - 1, 0) if a > i else j, min(j + 2, shape[1])):
            line = (a * shape[1] + b) * shape[2]
            ahead = a > i or b > j
            last = starts[line + min(k + 2, shape[2])]
            for p in range(starts[own], starts[own + 1]):
                for q in range(starts[line + max(k - 1, 0)] if ahead else p + 1, last):
                    dx, dy, dz = rows[p, 0] - rows[q, 0], rows[p, 1] - rows[q, 1], rows[p, 2] - rows[q, 2]
                    square, touch = dx * dx + dy * dy + dz * dz, rows[p, 3] + rows[q, 3]
                    # Only an overlap worse than the worst so far is looked at closer.
                    if square < (touch * (1.0 - worst)) ** 2:
                        row = min(order[p], order[q])
                        if row < count:
                            worst = 1.0 - np.sqrt(square) / touch
                            worst_row, worst_other = row, max(order[p], order[q])
    return worst, worst_row, worst_other


def count_contacts(positions: np.ndarray, radii: np.ndarray, count: int) -> float:
    """Pairs that touch, of this rank's `count` particles; one with another rank's particle counts half.

    positions, radii: (n, 3) and (n,) [m], as of `find_max_overlap`.
    """
    if count == 0:
        return 0.0
    reach = 2.0 * float(radii.max())
    low, high = find_bounds(positions)
    shape = np.floor((high - low) / reach).astype(np.int64) + 1
    starts, order, rows = _sort(positions, radii, low, 1.0 / reach, shape)
    return float(_count(rows, order, count, starts, shape))


@njit(cache=True)
def _count(rows, order, count, starts, shape):
    """Half a contact for each own particle that touches another, either way round."""
    found = 0.0
    for i in range(shape[0]):
        for j in range(shape[1]):
            for k in range(shape[2]):
                here = (i * shape[1] + j) * shape[2] + k
                for p in range(starts[here], starts[here + 1]):
                    if order[p] < count:
                        found += 0.5 * _count_around(rows, p, starts, shape, i, j, k)
    return found


@njit(cache=True)
def _count_around(rows, p, starts, shape, i, j, k):
    found = 0
    for a in range(max(i - 1, 0), min(i + 2, shape[0])):
        for b in range(max(j - 1, 0), min(j + 2, shape[1])):
            line = (a * shape[1] + b) * shape[2]
            for q in range(starts[line + max(k - 1, 0)], starts[line + min(k + 2, shape[2])]):
                dx, dy, dz = rows[p, 0] - rows[q, 0], rows[p, 1] - rows[q, 1], rows[p, 2] - rows[q, 2]
                if q != p and dx * dx + dy * dy + dz * dz < (rows[p, 3] + rows[q, 3]) ** 2:
                    found += 1
    return found

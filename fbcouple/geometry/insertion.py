"""Random sequential insertion: spheres at random places, each kept if it is clear of those before it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from fbcouple.physics.compiler import njit

ROUNDS = 300
"""Places that are tried for a sphere."""
_ONE_SIZE = 1.2
"""Radii over each other of spheres that are placed in one go."""

Clear = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Which spheres, centres (n, 3) [m] and radii (n,) [m], are clear of walls."""


def insert(
    radii: np.ndarray,
    bounds: np.ndarray,
    period: np.ndarray,
    clear: Clear,
    generator: np.random.Generator,
    rounds: int = ROUNDS,
) -> np.ndarray:
    """Places [m] (n, 3) for spheres of `radii` (n,) [m] that touch neither walls nor each other; nan where none was
    found in so many `rounds`.

    bounds: (2, 3) [m], of the spheres themselves, or along axes with a `period` (3,) [m] (0: none) of their centres.
    The large ones are placed first: among small ones they would find no room.
    """
    centres = np.full((len(radii), 3), np.nan)
    extent = bounds[1] - bounds[0]
    reach = 2.0 * radii.max(initial=0.0)
    shape = np.maximum(np.floor(extent / reach), 1.0).astype(np.int64)
    grid = np.full(tuple(shape), -1), np.full(len(radii), -1)
    for waiting in _sort_by_size(radii):
        for _ in range(rounds):
            if not len(waiting):
                break
            margin = np.where(period > 0.0, 0.0, radii[waiting, None])
            tried = bounds[0] + margin + generator.random((len(waiting), 3)) * (extent - 2.0 * margin)
            fits = clear(tried, radii[waiting]) & (extent >= 2.0 * margin).all(axis=1)
            _place(tried, waiting, fits, centres, radii, bounds[0], extent / shape, period, *grid)
            waiting = waiting[np.isnan(centres[waiting, 0])]  # noqa: PLW2901  (those that are left)
    return centres


def _sort_by_size(radii: np.ndarray) -> list[np.ndarray]:
    """Rows of spheres of about one size, the largest first."""
    order = np.argsort(-radii, kind="stable")
    if not len(order):
        return []
    steps = np.floor(np.log(radii[order[0]] / radii[order]) / math.log(_ONE_SIZE) + 1e-9)
    return np.split(order, np.flatnonzero(np.diff(steps)) + 1)


@njit(cache=True)
def _place(tried, rows, fits, centres, radii, low, edge, period, heads, following):
    """Put the spheres `rows` where they were `tried`, one after the other, if they fit; `heads` and `following` list
    those that are in each bin."""
    shape = heads.shape
    for n in range(len(rows)):
        if not fits[n]:
            continue
        row = rows[n]
        i = min(int((tried[n, 0] - low[0]) / edge[0]), shape[0] - 1)
        j = min(int((tried[n, 1] - low[1]) / edge[1]), shape[1] - 1)
        k = min(int((tried[n, 2] - low[2]) / edge[2]), shape[2] - 1)
        if _is_free(tried[n], radii[row], (i, j, k), centres, radii, period, heads, following):
            centres[row] = tried[n]
            following[row] = heads[i, j, k]
            heads[i, j, k] = row


@njit(cache=True)
def _is_free(point, radius, bin_, centres, radii, period, heads, following):
    shape = heads.shape
    for i in range(bin_[0] - 1, bin_[0] + 2):
        for j in range(bin_[1] - 1, bin_[1] + 2):
            for k in range(bin_[2] - 1, bin_[2] + 2):
                if period[0] == 0.0 and not 0 <= i < shape[0]:
                    continue
                if period[1] == 0.0 and not 0 <= j < shape[1]:
                    continue
                if not 0 <= k < shape[2]:
                    continue
                other = heads[i % shape[0], j % shape[1], k]
                while other >= 0:
                    square = 0.0
                    for axis in range(3):
                        gap = abs(point[axis] - centres[other, axis])
                        if period[axis] > 0.0:
                            gap = min(gap, period[axis] - gap)
                        square += gap * gap
                    if square < (radius + radii[other]) ** 2:
                        return False
                    other = following[other]
    return True

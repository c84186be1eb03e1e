"""Where the start-up of a run ends, or that it is not over yet, by maps and histories in blocks of the whole run.

The test is Geweke's (1992, Bayesian Statistics 4, 169-193): of what is left after a cut the mean of the first part is
held against that of the last, here half and half, in units of their own standard errors. A map is one test: the squares
of all its cells are added up, so that a slow change which is common to many cells shows where no cell alone tells it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fbcouple.results.block_errors import SHORTEST, find_gain_at, find_length, join_pairs

LIMIT = 1.05
"""Drift up to which what is left is steady: both halves differ by no more than chance has them, but for a twentieth
that is not known of the correlation."""
FEWEST_TIMES = 20.0
"""Correlation times that what is left lasts at least."""
FORGOTTEN = 5.0
"""Correlation times that are left out at least: so long is the start remembered."""
LATEST = 1.0 / 3.0
"""Part of the blocks that may be left out at most."""
IN_A_ROW = 1.0 / 6.0
"""Part of the blocks by which the cut may be moved on without more drift, so that no single cut is steady by chance."""
STILL = 1e-3
"""Difference of both halves, over the mean and root mean square over the cells, up to which nothing changes."""
_FEWEST_BLOCKS = 8
"""Blocks that are left where they join."""


@dataclass(frozen=True)
class Start:
    """Where the start-up ends."""

    block: int
    """The first block after it; while it is not over, that of the least drift."""
    is_over: bool
    drift: float
    """The largest from `block` on, see `measure_drift`; nan where what is left is too short to tell."""


def measure_drift(blocks: np.ndarray) -> tuple[float, float]:
    """Squared difference of the means of both halves of `blocks` (blocks, cells), one after another, over the one that
    their standard errors let expect, and the correlation times that all blocks last.

    The drift of a steady record is 1 on average, and 1 + (b/e)^2 where a change that has died away in the first half
    takes the mean by b away and e is the standard error of the mean, both root mean square over the cells. It is 0
    where nothing changes by more than `STILL`, infinite where nothing but the halves differ. Blocks join in pairs until
    they are long enough to tell an error; nan, and the times so far, if they never are.
    """
    while True:
        drift, length = _compare_halves(blocks)
        if length >= SHORTEST:
            return drift, length * len(blocks)
        if len(blocks) < 2 * _FEWEST_BLOCKS:
            return math.nan, length * len(blocks)
        blocks = join_pairs(blocks[len(blocks) % 2 :])


def _compare_halves(blocks: np.ndarray) -> tuple[float, float]:
    """Drift, and length of a block in correlation times."""
    half = len(blocks) // 2
    parts = blocks[-2 * half : -half], blocks[-half:]
    apart = [part - part.mean(axis=0) for part in parts]
    squares = sum(float((values**2).sum()) for values in apart)
    products = sum(float((values[1:] * values[:-1]).sum()) for values in apart)
    first, last = (part.mean(axis=0) for part in parts)
    difference = float(((last - first) ** 2).sum())
    if difference <= STILL**2 * float(((0.5 * (first + last)) ** 2).sum()):
        return 0.0, math.inf
    if not squares > 0.0:
        return math.inf, math.inf
    length = find_length(products / squares, half)
    return difference / (squares / (half - 1) * find_gain_at(length, half)), length


def find_start(maps: Sequence[np.ndarray], histories: Sequence[np.ndarray] = ()) -> Start:
    """Where the start-up ends of `maps`, each (blocks, cells), and `histories`, each (blocks, 1), all of the same
    blocks, equally long and from the start of the run on.

    It is the first block from which on no map drifts more than `LIMIT`, nor do the histories on average, nor if it were
    one of the next, and from which on each lasts `FEWEST_TIMES`, after `FORGOTTEN`. Where there is none up to `LATEST`
    of the blocks the start-up is not over.
    """
    count = len(maps[0])
    latest = int(LATEST * count)
    drifts = np.array([_find_largest(maps, histories, cut) for cut in range(latest + 1)])
    steady = drifts <= LIMIT
    row = max(math.ceil(IN_A_ROW * count), 1)
    for cut in range(latest + 2 - row):
        if steady[cut : cut + row].all():
            return Start(cut, True, float(drifts[cut]))
    if np.isnan(drifts).all():
        return Start(latest, False, math.nan)
    best = int(np.nanargmin(drifts))
    return Start(best, False, float(drifts[best]))


def _find_largest(maps: Sequence[np.ndarray], histories: Sequence[np.ndarray], cut: int) -> float:
    """The largest drift of the maps from the block `cut` on, or that of the histories that move, on average, if it is
    larger; nan where one of all is too short."""
    found = [_drift_from(blocks, cut) for blocks in maps]
    moving = [drift for blocks in histories if (drift := _drift_from(blocks, cut)) > 0.0 or math.isnan(drift)]
    if moving:
        found.append(float(np.mean(moving)))
    return float(np.max(found))


def _drift_from(blocks: np.ndarray, cut: int) -> float:
    """Drift from the block `cut` on; nan where what is left, or what is left out, is too short."""
    drift, times = measure_drift(blocks[cut:])
    forgotten = times * cut / (len(blocks) - cut) if math.isfinite(times) else math.inf
    return drift if times >= FEWEST_TIMES and forgotten >= FORGOTTEN else math.nan


def average_rows(times: np.ndarray, values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Means (blocks, 1) between `edges` (blocks + 1,) [s] of a history whose `values` (rows,) are each of the time
    since the row before, at `times` (rows,) [s]; the first, of the start, is of no time, and the last stands on."""
    grid = np.append(times, max(edges[-1], times[-1]))
    # From the last value on, so that what stands still does so to the last bit.
    lasting = (np.append(values[1:], values[-1]) - values[-1]) * np.diff(grid)
    sums = np.interp(edges, grid, np.concatenate([[0.0], np.cumsum(lasting)]))
    return values[-1] + (np.diff(sums) / np.diff(edges))[:, None]

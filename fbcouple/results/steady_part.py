"""From where on a history is steady, and how far its mean is off by chance."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import xarray as xr

BATCH = 5
"""Values a batch of MSER-5."""
FEWEST = 40
"""Values of a history below which nothing is told of its start-up."""
FEWEST_BLOCKS = 4
FORGOTTEN = 5
"""Correlation times after which a history has forgotten where it started: so many are left out at least."""
FEWEST_TIMES = 20
"""Correlation times that a steady part lasts at least, four strokes of a bed that pulsates."""
STILL = 1e-3
"""Change over the mean below which a history stands still."""
SIGNALS = ("bed_height", "solids_centre_z", "pressure_drop")
"""Histories that are all steady where the start-up is over."""


def find_start_up(values: np.ndarray) -> int | None:
    """Number of values at the start that are best left out; None if the start-up is not seen to be over.

    The cut is that of MSER-5, but not before the history has forgotten its first value, `FORGOTTEN` correlation times
    (until the autocorrelation is below 1/e) of what is left. It counts if it lies in the first half, and what is left
    is `FEWEST_TIMES` of them long and has a standard error. A history that comes to stand still is steady from there.
    """
    still = _find_still(values)
    if still is not None:
        return still
    cut = _cut_least_error(values)
    if cut is None:
        return None
    cut = max(cut, FORGOTTEN * find_correlation(values[cut:]))
    rest = values[cut:]
    if cut > len(values) // 2 or len(rest) < FEWEST_TIMES * find_correlation(rest) or math.isnan(estimate_error(rest)):
        return None
    return cut


def _find_still(values: np.ndarray) -> int | None:
    """First of the values that stay within `STILL` of the last one's size, if it lies in the first half."""
    close = np.abs(values - values[-1]) <= STILL * abs(values[-1])
    moves = np.flatnonzero(~close)
    first = int(moves[-1]) + 1 if moves.size else 0
    return first if first <= len(values) // 2 else None


def find_correlation(values: np.ndarray) -> int:
    """Number of values after which their autocorrelation is below 1/e; all of them if it never is."""
    apart = values - values.mean()
    squares = float(apart @ apart)
    if squares == 0.0:
        return 0
    padded = np.fft.rfft(apart, 2 * len(apart))
    correlation = np.fft.irfft(np.abs(padded) ** 2)[: len(apart)] / squares
    below = np.flatnonzero(correlation < math.exp(-1.0))
    return int(below[0]) if below.size else len(values)


def _cut_least_error(values: np.ndarray) -> int | None:
    """MSER-5: the cut that makes the squared standard error of the rest, as if it were uncorrelated, smallest.

    White 1997, Simulation 69:323; batches of five: White, Cobb and Spratt 2000, Winter Simulation Conference. None if
    that cut is the latest allowed, half of the values: then no steady part is seen.
    """
    batches = values[: len(values) // BATCH * BATCH].reshape(-1, BATCH).mean(axis=1)
    count = len(batches)
    if count < 2:
        return None
    batches = batches - batches.mean()
    left = np.arange(count, 0, -1.0)
    sums, squares = (np.cumsum(series[::-1])[::-1] for series in (batches, batches**2))
    spread = np.maximum(squares - sums**2 / left, 0.0) / left**2
    latest = count // 2
    cut = int(np.argmin(spread[: latest + 1]))
    return None if cut == latest else cut * BATCH


def estimate_error(values: np.ndarray) -> float:
    """Standard error of the mean of correlated `values` by block averaging.

    Neighbours are joined to blocks of 1, 2, 4, ... values (Flyvbjerg and Petersen 1989, J. Chem. Phys. 91:461). The
    blocks taken are the shortest of b values for which b^3 > 2 n (s_b/s_1)^4, with n the number of values and s_b the
    standard error from blocks of b: long against the correlation, which s_b/s_1 tells (Lee et al. 2011, Phys. Rev. E
    83:066706). nan if fewer than `FEWEST_BLOCKS` of them fit.
    """
    count = len(values)
    if count < FEWEST_BLOCKS:
        return math.nan
    if np.ptp(values) == 0.0:
        return 0.0
    blocks, length = values - values.mean(), 1
    uncorrelated = float(blocks.var()) / (count - 1)
    while len(blocks) >= FEWEST_BLOCKS:
        squared = float(blocks.var()) / (len(blocks) - 1)
        if length**3 > 2.0 * count * (squared / uncorrelated) ** 2:
            return math.sqrt(squared)
        blocks = blocks[len(blocks) % 2 :]
        blocks, length = 0.5 * (blocks[::2] + blocks[1::2]), 2 * length
    return math.nan


def list_steady(data: xr.Dataset, names: Iterable[str]) -> dict[str, float | None]:
    """Time [s] from which on each of the histories `names` is steady, None if that is not seen; only of those with
    `FEWEST` rows after the first, before any step, and without holes."""
    found: dict[str, float | None] = {}
    for name in names:
        values = data[name].values[1:].astype(float)
        if len(values) >= FEWEST and np.isfinite(values).all():
            cut = find_start_up(values)
            found[name] = None if cut is None else float(data["time"].values[1 + cut])
    return found

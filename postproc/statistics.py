"""Statistics of histories: where the start-up ends, and how far a time mean is off by chance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fbcouple.results.reader import NotDrawableError, Results

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


@dataclass(frozen=True)
class Steady:
    """A history after its start-up, which ended at `start` [s]: its mean, the standard error of that, its deviation.

    If the start-up is not over, `start` is nan, and so are the numbers: there is no steady part to take them from.
    """

    name: str
    unit: str
    start: float
    end: float
    values: int
    mean: float
    stderr: float
    deviation: float


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


def summarise(results: Results, name: str) -> Steady:
    """Start-up, mean, standard error and deviation of the history `name`; its first row, before any step, is left out.

    Of replicas: mean and standard error over the averaging windows of all, and the rows and deviation of the first.
    Raises: NotDrawableError if the history has too few rows or has holes.
    """
    history = results.history(name)[1:]
    time, values = history["time"].values.astype(float), history.values
    if len(values) < FEWEST:
        raise NotDrawableError([f"`{name}` in {results.path} has {len(values)} rows, {FEWEST} are needed."])
    if not np.isfinite(values).all():
        raise NotDrawableError([f"`{name}` in {results.path} has rows that are not finite."])
    unit = str(history.attrs.get("units", results.data[name].attrs.get("units", "")))
    if (pooled := results.window_mean(name)) and results.window is not None:
        rest = values[time > results.window[0]]
        return Steady(name, unit, results.window[0], float(time[-1]), len(rest), *pooled, float(rest.std()))
    cut = find_start_up(values)
    if cut is None:
        return Steady(name, unit, math.nan, float(time[-1]), 0, math.nan, math.nan, math.nan)
    rest = values[cut:]
    numbers = float(rest.mean()), estimate_error(rest), float(rest.std())
    return Steady(name, unit, float(time[cut]), float(time[-1]), len(rest), *numbers)


def find_steady_time(results: Results) -> float:
    """Time [s] from which all of `SIGNALS` that the run has are steady.

    Raises: NotDrawableError if it has none of them, or the start-up is not over for one.
    """
    found = [summarise(results, name) for name in SIGNALS if name in results.data]
    if not found:
        raise NotDrawableError([f"{results.path} has none of {', '.join(SIGNALS)}."])
    waited = [steady.name for steady in found if math.isnan(steady.start)]
    if waited:
        raise NotDrawableError([format_not_reached(", ".join(waited), found[0].end)])
    return max(steady.start for steady in found)


def format_not_reached(name: str, end: float) -> str:
    """Why there are no numbers of the history `name` of a run that came to `end` [s]."""
    need = f"a steady part of {FEWEST_TIMES} correlation times after it is not seen in the record"
    return f"the start-up is not over at t = {end:.3g} s ({name}: {need}); let the run go on."

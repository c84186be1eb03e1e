"""Statistics of histories: where the start-up ends, and how far a time mean is off by chance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from postproc.dataset import NotDrawableError, Results

BATCH = 5
"""Values a batch of MSER-5."""
FEWEST = 40
"""Values of a history below which nothing is told of its start-up."""
FEWEST_BLOCKS = 4


@dataclass(frozen=True)
class Steady:
    """A history after its start-up, which ended at `start` [s]: its mean, the standard error of that, its deviation.

    `start` is nan if the history was not steady in its second half; then the numbers are those of that half.
    `stderr` is nan if the values are correlated over too long a time for their number.
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
    """Number of values at the start that are best left out: MSER-5.

    The rule takes the cut that makes the squared standard error of the rest, as if it were uncorrelated, smallest
    (White 1997, Simulation 69:323; batches of five: White, Cobb and Spratt 2000, Winter Simulation Conference).
    None if that cut is the latest allowed, half of the values: then no steady part is seen.
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

    Raises: NotDrawableError if the history is too short or has holes.
    """
    history = results.history(name)[1:]
    time, values = history["time"].values.astype(float), history.values
    if len(values) < FEWEST:
        raise NotDrawableError([f"`{name}` in {results.path} has {len(values)} rows, {FEWEST} are needed."])
    if not np.isfinite(values).all():
        raise NotDrawableError([f"`{name}` in {results.path} has rows that are not finite."])
    cut = find_start_up(values)
    first = len(values) // 2 if cut is None else cut
    rest = values[first:]
    start = math.nan if cut is None else float(time[first])
    unit = str(history.attrs.get("units", results.data[name].attrs.get("units", "")))
    mean, deviation = float(rest.mean()), float(rest.std())
    return Steady(name, unit, start, float(time[-1]), len(rest), mean, estimate_error(rest), deviation)


def find_steady_time(results: Results) -> float:
    """Time [s] from which bed height and pressure drop are both steady; where one never is, half of the run.

    Raises: NotDrawableError if the run has neither.
    """
    ends = [_end_of_start_up(results, name) for name in ("bed_height", "pressure_drop") if name in results.data]
    if not ends:
        raise NotDrawableError([f"{results.path} has neither `bed_height` nor `pressure_drop`."])
    return max(ends)


def _end_of_start_up(results: Results, name: str) -> float:
    steady = summarise(results, name)
    return 0.5 * steady.end if math.isnan(steady.start) else steady.start

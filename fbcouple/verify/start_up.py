"""The end of the start-up found against series whose start-up is known: how far what is left of it takes the mean away,
how much is left out, how many bars of two standard errors hold the true mean, and that no end is told of a drift.

Maps of 100 cells of exponential correlation (AR(1)) with a deviation as large as their mean, a common slow mode of five
times that correlation, and a common pattern that dies away as an exponential; beside them a history that is steady from
the start on. Windows end as runs with `averages.until_error` do.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.results.block_errors import estimate_errors, is_sure
from fbcouple.results.start_up import find_start
from fbcouple.verify.registry import Number, check

_TIME = 8.0
"""Samples a correlation time of the fast part."""
_SLOW, _SLOW_TIMES = 0.3, 5.0
"""Deviation of the common slow mode, and its correlation time over the fast one."""
_CELLS, _PIECES, _FEWEST = 100, 20, 20
_WANTED = 0.2
_LONGEST = 640
"""Correlation times after which a series ends."""
_CASES = ((0.0, 1.0), (1.0, 5.0), (1.0, 20.0), (3.0, 20.0), (10.0, 20.0))
"""Deviation of the dying pattern over the cells at the start, and the correlation times in which it dies."""


@dataclass(frozen=True)
class Stopped:
    """A window that ended: begin and end in correlation times, what is left of the start-up in its mean over the told
    error, root mean square, and the part of the bars that hold the true mean."""

    begin: float
    end: float
    bias: float
    held: float


@check("start-up", fast=False)
def check_start_up(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A steady series, four start-ups that die away, and two that do not within the series."""
    generator = np.random.default_rng(17)
    for size, times in _CASES:
        found = [_stop(*make_series(generator, size, times)) for _ in range(_PIECES)]
        ended = [each for each in found if each is not None]
        name = f"start-up of {size:g} deviations and {times:g} correlation times" if size else "no start-up"
        yield Number(f"{name}: windows that end", len(ended) / _PIECES, 1.0, 0.1)
        yield Number(
            f"{name}: true means held by two errors", float(np.mean([each.held for each in ended])), 0.94, 0.04
        )
        if size:
            late = float(np.mean([each.bias > 1.0 for each in ended]))
            yield Number(f"{name}: begins too early, bias above the told error", late, 0.0, 0.05)
        else:
            begin = float(np.median([each.begin for each in ended]))
            yield Number(f"{name}: correlation times left out, median", begin, 5.0, 20.0)
    for size, times in ((3.0, 320.0), (10.0, 640.0)):
        found = [_stop(*make_series(generator, size, times), _LONGEST // 4) for _ in range(_PIECES)]
        told = float(np.mean([each is not None for each in found]))
        name = f"start-up of {size:g} deviations and {times:g} correlation times"
        yield Number(f"{name}: told to be over within {_LONGEST // 4}", told, 0.0, 0.05)


def make_series(
    generator: np.random.Generator, size: float, times: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Map (samples, cells), what its start-up adds to it, a history (samples, 1), and the true mean (cells,)."""
    samples = int(_LONGEST * _TIME)
    mean, pattern, slow = (_draw_pattern(generator) for _ in range(3))
    dying = size * np.exp(-np.arange(samples) / (times * _TIME))[:, None] * pattern
    mode = _SLOW * _correlate(generator.standard_normal((samples, 1)), _SLOW_TIMES * _TIME) * slow
    fast = _correlate(generator.standard_normal((samples, _CELLS)), _TIME)
    history = 10.0 + _correlate(generator.standard_normal((samples, 1)), _TIME)
    return mean + fast + mode + dying, dying, history, mean


def _draw_pattern(generator: np.random.Generator) -> np.ndarray:
    values = generator.standard_normal(_CELLS)
    return values / math.sqrt(float(np.mean(values**2)))


def _correlate(noise: np.ndarray, samples: float) -> np.ndarray:
    """Series of variance 1 with a correlation of that many `samples`, from independent `noise`."""
    decay = math.exp(-1.0 / samples)
    noise[1:] *= math.sqrt(1.0 - decay**2)
    for n in range(1, len(noise)):
        noise[n] += decay * noise[n - 1]
    return noise


def _stop(
    series: np.ndarray, dying: np.ndarray, history: np.ndarray, mean: np.ndarray, longest: int = _LONGEST
) -> Stopped | None:
    """The window that a run looks at when its start-up is over and its error small enough; None if it never is."""
    length = 1
    while 2 * _FEWEST * length <= len(series):
        for count in range(_FEWEST, 2 * _FEWEST + 1, 2):
            samples = count * length
            if samples > longest * _TIME:
                return None
            blocks, beside = (values[:samples].reshape(count, length, -1).mean(axis=1) for values in (series, history))
            start = find_start([blocks], [beside])
            rest = blocks[start.block :]
            if start.is_over and is_sure(rest[..., None], _WANTED):
                error = estimate_errors(rest[..., None])[:, 0]
                left = dying[start.block * length : samples].mean(axis=0)
                bias = math.sqrt(float(np.mean(left**2) / np.mean(error**2)))
                held = float(np.mean(np.abs(rest.mean(axis=0) - mean) <= 2.0 * error))
                return Stopped(start.block * length / _TIME, samples / _TIME, bias, held)
        length *= 2
    return None

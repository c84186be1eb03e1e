"""Standard errors of time means against series whose mean is known: how many bars of two of them hold it.

Series of exponential correlation (AR(1)); of independent normal values 95.4 % would be held.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.results.block_errors import count_held, estimate_errors, is_sure
from fbcouple.verify.registry import Number, check

_TIME = 8.0
"""Samples a correlation time."""
_CELLS, _PIECES, _FEWEST = 30, 20, 10
_WINDOWS = (20, 50, 200)
_WANTED = 0.2
"""Error of the map at which a run stops, of series with a deviation as large as their mean."""


@check("standard-errors")
def check_standard_errors(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Windows of fixed lengths, one that is too short, and windows that end where the error is small enough."""
    generator = np.random.default_rng(11)
    for window in _WINDOWS:
        held = count_held(_make(generator, int(window * _TIME) * _PIECES), _PIECES, 16, np.ones(_CELLS))
        yield Number(f"true means held by two errors, of {window} correlation times", held.part, 0.94, 0.04)
    short = count_held(_make(generator, int(5 * _TIME) * _PIECES), _PIECES, 16)
    yield Number("windows of 5 correlation times that tell an error", short.told, 0.0, 0.0)
    yield Number("true means held where the error ends the window", _hold_stopped(generator), 0.94, 0.04)


def _make(generator: np.random.Generator, length: int) -> np.ndarray:
    """Series (length, _CELLS) of mean and variance 1."""
    decay = math.exp(-1.0 / _TIME)
    series = generator.standard_normal((length, _CELLS))
    series[1:] *= math.sqrt(1.0 - decay**2)
    for n in range(1, length):
        series[n] += decay * series[n - 1]
    return series + 1.0


def _hold_stopped(generator: np.random.Generator) -> float:
    """Part of the true means held by two errors of windows that grow until `_WANTED` is reached."""
    return float(np.mean([_stop(_make(generator, int(320 * _TIME))) for _ in range(_PIECES)]))


def _stop(series: np.ndarray) -> float:
    """Of the cells, those whose bar holds the mean where `series` is sure enough; none if it never is."""
    length, fewest = 1, _FEWEST
    while 2 * fewest * length <= len(series):
        for count in range(fewest, 2 * fewest + 1, 2):
            blocks = series[: count * length].reshape(count, length, -1).mean(axis=1)
            if is_sure(blocks[..., None], _WANTED):
                error = estimate_errors(blocks[..., None])[:, 0]
                return float(np.mean(np.abs(blocks.mean(axis=0) - 1.0) <= 2.0 * error))
        length *= 2
    return 0.0

"""Standard errors of time means against series whose mean is known: how many bars of two of them hold it.

Series of exponential correlation (AR(1)); of independent normal values 95.4 % would be held.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.results.block_errors import count_held, estimate_errors, find_gain_at, is_sure
from fbcouple.results.pooling import combine
from fbcouple.verify.registry import Number, check

_TIME = 8.0
"""Samples a correlation time."""
_CELLS, _PIECES, _FEWEST = 30, 20, 10
_WINDOWS = (20, 50, 200)
_PLACES, _POOLS, _BLOCKS = 20, 60, 20
"""Places of a map, each of its own motion, pools, and blocks of a replica."""
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


@check("pooled-errors")
def check_pooled_errors(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Pools of 2, 3 and 4 replicas with blocks of half a correlation time, whose own errors are too small: the error of
    the map over the true one, and the true means held by two errors, on maps of 20 places that move on their own."""
    generator = np.random.default_rng(17)
    for count in (2, 3, 4):
        ratio, part, alone = np.mean([_pool(generator, count) for _ in range(_POOLS)], axis=0)
        yield Number(f"squared error of {count} replicas over the true one", float(ratio), 1.0, 0.1)
        yield Number(f"true means held by two errors, {count} replicas", float(part), 0.94, 0.04)
    gain = find_gain_at(0.5, _BLOCKS)
    yield Number("squared block error of 4 replicas over the true one", float(alone), 1.0 / (_BLOCKS * gain), 0.05)


def _pool(generator: np.random.Generator, count: int) -> tuple[float, float, float]:
    """Of one pool: its mean squared error over the true one, the part of cells held, and the same ratio of the block
    errors alone."""
    length, blocks = int(10 * _TIME), _BLOCKS
    series = np.array([_make(generator, length, _PLACES) for _ in range(count)])
    values = series.mean(axis=1)
    cut = series.reshape(count, blocks, length // blocks, _PLACES).mean(axis=2)
    within = cut.std(axis=1, ddof=1) / math.sqrt(blocks)
    pooled = combine(values, np.ones_like(values), within, blocks)
    decay = math.exp(-1.0 / _TIME)
    apart = np.arange(1, length)
    true = (1.0 + 2.0 * ((1.0 - apart / length) * decay**apart).sum()) / (length * count)
    held = np.abs(pooled.mean - 1.0) <= 2.0 * pooled.error
    return float(np.mean(pooled.error**2) / true), float(held.mean()), float(np.mean(within**2) / count / true)


def _make(generator: np.random.Generator, length: int, cells: int = _CELLS) -> np.ndarray:
    """Series (length, cells) of mean and variance 1."""
    decay = math.exp(-1.0 / _TIME)
    series = generator.standard_normal((length, cells))
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

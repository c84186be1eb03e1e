"""Standard errors of time means from blocks of the averaging window, corrected for what neighbouring blocks share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

SHORTEST = 1.0
"""Correlation times a block lasts at least where an error is told; in shorter ones nothing is known of it."""
FEWEST_TIMES = 15.0
"""Correlation times that all blocks together last at least where an error is told: bars of two standard errors then
hold nine in ten of the true means or more."""
_LENGTHS = np.geomspace(0.05, 200.0, 400)
"""Lengths of a block, in correlation times, among which the one that a record has is looked for."""

AddUp = Callable[[np.ndarray], np.ndarray]
"""Adds an array up over the ranks."""


@lru_cache(maxsize=512)
def tabulate_gains(blocks: int) -> tuple[np.ndarray, np.ndarray]:
    """For `blocks` blocks of `_LENGTHS` correlation times each: the ratio of the sum of products of neighbouring
    deviations to that of their squares, and the squared standard error of the mean over the variance of the blocks.

    The deviations are from the mean of the same blocks, so both are what such a record shows, without bias of a short
    one. The correlation is exponential: the means of blocks of b correlation times have the correlations
    (1 - e)^2 e^(k - 1) / (2 (b - 1 + e)), e = exp(-b), at k blocks apart.
    """
    apart = np.abs(np.subtract.outer(np.arange(blocks), np.arange(blocks)))
    centre = np.eye(blocks) - 1.0 / blocks
    neighbours, gains = np.empty(len(_LENGTHS)), np.empty(len(_LENGTHS))
    for n, length in enumerate(_LENGTHS):
        decay = np.exp(-length)
        first = (1.0 - decay) ** 2 / (2.0 * (length - 1.0 + decay))
        correlation = np.where(apart == 0, 1.0, first * decay ** np.maximum(apart - 1, 0))
        seen = centre @ correlation @ centre
        neighbours[n] = np.trace(seen, 1) / np.trace(seen)
        gains[n] = correlation.mean() / (np.trace(seen) / (blocks - 1))
    return neighbours, gains


def find_gain(products: float, squares: float, blocks: int, surely: bool = False) -> float:
    """Squared standard error of the mean of `blocks` blocks over their variance; nan where one is shorter than
    `SHORTEST` correlation times, or all are than `FEWEST_TIMES`.

    products, squares: sums, over everything that is averaged alike, of the products of neighbouring deviations from
    the mean of the blocks, and of their squares. surely: nan also where the blocks would be too short if the
    correlation were higher than it is seen by what chance makes of it in one cell, 1/sqrt(blocks).
    """
    if not squares > 0.0:
        return 1.0 / blocks
    seen = products / squares
    length, least = (find_length(correlation, blocks) for correlation in (seen, seen + surely / np.sqrt(blocks)))
    if least < max(SHORTEST, FEWEST_TIMES / blocks):
        return np.nan
    return find_gain_at(length, blocks)


def find_length(seen: float, blocks: int) -> float:
    """Length of each of `blocks` blocks in correlation times, by the ratio `seen` of the sum of products of
    neighbouring deviations to that of their squares."""
    return float(np.interp(-seen, -tabulate_gains(blocks)[0], _LENGTHS))


def find_gain_at(length: float, blocks: int) -> float:
    """Squared standard error of the mean of `blocks` blocks of `length` correlation times over their variance."""
    return float(np.interp(length, _LENGTHS, tabulate_gains(blocks)[1]))


def estimate_errors(blocks: np.ndarray, add_up: AddUp = lambda sums: sums, surely: bool = False) -> np.ndarray:
    """Standard errors (cells, components) of the means of `blocks` (blocks, cells, components), equally long and one
    after another; nan where a block has no value for a cell means that it does not count there (collective).

    How long a block is against the correlation follows from all cells of all ranks together, a component at a time,
    because that of a cell alone is too short a record to tell it. Errors are nan with fewer than three blocks, and
    where blocks are too short; `surely`: or may be, see `find_gain`.
    """
    count, _, components = blocks.shape
    known = np.isfinite(blocks)
    held = known.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(known, blocks, 0.0).sum(axis=0) / held
        apart = np.where(known, blocks - mean, 0.0)
        variance = (apart**2).sum(axis=0) / (held - 1)
    whole = held == count
    products = np.where(whole, (apart[1:] * apart[:-1]).sum(axis=0), 0.0).sum(axis=0)
    squares = np.where(whole, (apart**2).sum(axis=0), 0.0).sum(axis=0)
    products, squares = add_up(np.array([products, squares]))
    if count < 3:
        return np.full(mean.shape, np.nan)
    gains = np.array([find_gain(products[n], squares[n], count, surely) for n in range(components)])
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(held > 1, np.sqrt(variance * gains * count / held), np.nan)


def join_pairs(blocks: np.ndarray) -> np.ndarray:
    """Half as many blocks, twice as long, of the means of equally long ones; a last one without another is left out."""
    paired = blocks[: len(blocks) // 2 * 2]
    return 0.5 * (paired[::2] + paired[1::2])


def compare_with_map(mean: np.ndarray, error: np.ndarray) -> float:
    """Root mean square of the standard errors of a map over that of the map; nan where no error is known, or the map is
    zero."""
    size = float(np.sqrt(np.nansum(mean**2)))
    if not size or not np.isfinite(error).any():
        return np.nan
    return float(np.sqrt(np.nansum(error**2))) / size


def list_errors(
    blocks: np.ndarray, joined: np.ndarray, add_up: AddUp = lambda sums: sums
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What has to be small for a run to end: the errors by `blocks`, by them `joined` in pairs, and by `blocks` where
    they are surely long enough, each (cells, components) (collective)."""
    return (
        estimate_errors(blocks, add_up),
        estimate_errors(joined, add_up),
        estimate_errors(blocks, add_up, surely=True),
    )


def is_sure(blocks: np.ndarray, wanted: float) -> bool:
    """Is the error of the map of `blocks` (blocks, cells, 1) at most `wanted`, by all of `list_errors`?"""
    errors = list_errors(blocks, join_pairs(blocks))
    mean = blocks.mean(axis=0)
    return bool(np.max([compare_with_map(mean, error) for error in errors]) <= wanted)


@dataclass(frozen=True)
class Held:
    """How right the standard errors of pieces of a record are."""

    part: float
    """Of the bars of two standard errors the part that holds the mean of the whole record; nan if there are none."""
    told: float
    """Of the pieces the part that tells an error."""


def count_held(series: np.ndarray, pieces: int, blocks: int, truth: np.ndarray | None = None) -> Held:
    """Cut `series` (samples, cells) into `pieces`, each into `blocks`, and hold their errors against the mean of it
    all, or against `truth` (cells,) where it is known."""
    length = len(series) // (pieces * blocks)
    if not length:
        return Held(np.nan, 0.0)
    cut = series[: pieces * blocks * length].reshape(pieces, blocks, length, -1).mean(axis=2)
    truth = series.mean(axis=0) if truth is None else truth
    errors = np.array([estimate_errors(piece[..., None])[:, 0] for piece in cut])
    told = np.isfinite(errors).any(axis=1)
    away = np.abs(cut.mean(axis=1) - truth)[told]
    known = np.isfinite(errors[told])
    part = float((away <= 2.0 * errors[told])[known].mean()) if told.any() else np.nan
    return Held(part, float(told.mean()))

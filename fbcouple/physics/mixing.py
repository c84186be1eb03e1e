"""How well particles are mixed."""

from __future__ import annotations

import math

import numpy as np


def find_lacey_index(marked: np.ndarray, samples: np.ndarray) -> float:
    """Lacey's mixing index of the `marked` particles (n,) among all, of which each is in one of the `samples` (n,).

    M = (s0^2 - s^2)/(s0^2 - sr^2): 0 where every sample holds marked particles or others alone, 1 in the mean where
    each particle is marked by chance, whatever its place. With p the part of all N particles that is marked, p_c that
    of the n_c particles of sample c, and C samples,

        s^2 = sum_c n_c/N (p_c - p)^2,  s0^2 = p (1 - p),  sr^2 = p (1 - p) (C - 1)/(N - 1).

    Lacey 1954 (J. Appl. Chem. 4:257) has samples of equal size n, for which sr^2 = p (1 - p)/n where there are many;
    here samples count by their size, and sr^2 is the exact mean of s^2 over all ways to choose the marked ones. A
    single mixed bed differs from 1 by chance, below it or above.

    nan where none or all are marked, or where there are fewer than two samples, or none of two particles.
    """
    _, sample = np.unique(samples, return_inverse=True)
    held, own = np.bincount(sample), np.bincount(sample, np.asarray(marked, float))
    count, groups = len(sample), len(held)
    part = float(own.sum()) / count if count else 0.0
    if not 0.0 < part < 1.0 or not 1 < groups < count:
        return math.nan
    apart = part * (1.0 - part)
    found = float((held * (own / held - part) ** 2).sum()) / count
    return (apart - found) / (apart - apart * (groups - 1) / (count - 1))


def number_samples(positions: np.ndarray, low: np.ndarray, edge: float) -> np.ndarray:
    """Which cube of an `edge` [m], counted from the corner `low` (3,), each of `positions` (n, 3) [m] is in, (n,)."""
    places = np.floor((positions - low) / edge).astype(np.int64)
    if not len(places):
        return np.empty(0, np.int64)
    places -= places.min(axis=0)
    return np.asarray(np.ravel_multi_index(tuple(places.T), tuple((places.max(axis=0) + 1).tolist())))

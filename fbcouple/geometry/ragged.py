"""Rows of unequal length in two flat arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Ragged:
    """Row n is `values[starts[n] : starts[n + 1]]`; `starts` has one entry more than there are rows."""

    starts: np.ndarray
    values: np.ndarray

    def __len__(self) -> int:
        return len(self.starts) - 1

    @property
    def lengths(self) -> np.ndarray:
        """Length of each row."""
        return np.diff(self.starts)

    def take(self, rows: np.ndarray, backward: np.ndarray | None = None) -> Ragged:
        """These rows in this order; those marked in `backward` (n,) from their end to their start."""
        lengths = self.lengths[rows]
        starts = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
        steps = np.arange(starts[-1]) - np.repeat(starts[:-1], lengths)
        indices = np.repeat(self.starts[rows], lengths) + steps
        if backward is not None:
            last = np.repeat(self.starts[np.asarray(rows) + 1] - 1, lengths) - steps
            indices = np.where(np.repeat(backward, lengths), last, indices)
        return Ragged(starts, self.values[indices])


def pile_up(lengths: np.ndarray, values: np.ndarray) -> Ragged:
    """Rows of these `lengths`, one after the other in `values`."""
    return Ragged(np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64), values)


def concatenate_ragged(parts: Sequence[Ragged]) -> Ragged:
    """All rows of `parts`, one after the other."""
    lengths = np.concatenate([part.lengths for part in parts])
    return pile_up(lengths, np.concatenate([part.values for part in parts]))

"""Time means over a window whose end or begin is not known: blocks that join in pairs where there are too many."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from fbcouple.results.block_errors import AddUp, estimate_errors, join_pairs, list_errors
from fbcouple.simulation.tasks.means import QUANTITIES, Block, count_columns


class GrowingMeans:
    """Sums of one phase's rows over blocks of as many samples each.

    There are up to twice `fewest` blocks. When that many are full, neighbours join, so that from then on a block has
    twice the samples: the blocks always cover everything since the first sample, in a memory that does not grow. The
    window begins with the block `first`, which whoever looks for it may move.
    """

    _NUMBERS = ("full", "per_block", "_open", "first", "begins")

    def __init__(self, phase: str, cells: int, fewest: int) -> None:
        self._fewest = fewest
        self._quantities = {name: q for name, q in QUANTITIES.items() if q.phase == phase}
        self._blocks = np.zeros((2 * fewest + 1, cells, count_columns(phase)))
        self.full = 0
        """Blocks that are full; the one behind them is being filled."""
        self.per_block = 1
        """Samples a block."""
        self.first = 0
        """The first block of the window."""
        self.begins: list[float] = []
        """Time of the first sample of each block [s]."""
        self._open = 0

    @property
    def samples(self) -> int:
        """Samples of the window so far."""
        return (self.full - self.first) * self.per_block + self._open

    @property
    def is_look(self) -> bool:
        """Is it time to look at the blocks? Every second one, from `fewest` on, once it is full."""
        return not self._open and self.full >= self._fewest and self.full % 2 == 0

    def add(self, rows: np.ndarray, time: float) -> None:
        """Take a sample: `rows` (cells, columns) at `time` [s]."""
        if self.full == 2 * self._fewest and not self._open:
            self._join()
        if not self._open:
            self.begins.append(time)
        self._blocks[self.full] += rows
        self._open += 1
        if self._open == self.per_block:
            self.full, self._open = self.full + 1, 0

    def _join(self) -> None:
        for n in range(self._fewest):
            self._blocks[n] = self._blocks[2 * n] + self._blocks[2 * n + 1]
        self._blocks[self._fewest :] = 0.0
        self.full, self.per_block = self._fewest, 2 * self.per_block
        self.begins, self.first = self.begins[::2], (self.first + 1) // 2

    def collect(self, final: bool, add_up: AddUp) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Name -> mean and standard error, (cells, components) each; the error is nan where the blocks are too short
        against the correlation to tell it (collective)."""
        total = self._blocks[self.first :].sum(axis=0) / max(self.samples, 1)
        rows = self._blocks[self.first : self.full] / self.per_block
        return {
            name: (quantity.derive(total), estimate_errors(self._derive_blocks(name, rows), add_up))
            for name, quantity in self._quantities.items()
        }

    def judge(self, name: str, add_up: AddUp) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Mean of the quantity `name` and its standard errors as `list_errors` has them, each (cells, components)
        (collective)."""
        rows = self._blocks[self.first : self.full] / self.per_block
        mean = self._quantities[name].derive(self._blocks[self.first :].sum(axis=0) / self.samples)
        joined = self._derive_blocks(name, join_pairs(rows))
        return mean, *list_errors(self._derive_blocks(name, rows), joined, add_up)

    def list_blocks(self, name: str) -> np.ndarray:
        """The quantity `name` of each full block from the first sample on (blocks, cells), of a vector its component
        along z."""
        return self._derive_blocks(name, self._blocks[: self.full] / self.per_block)[..., -1]

    def split_window(self) -> Iterator[Block]:
        """The blocks of the window one after another; the last one may not be full."""
        counts = [self.per_block] * (self.full - self.first) + [self._open]
        for number, count in enumerate(counts[: len(self.begins) - self.first], start=self.first):
            yield Block(self.begins[number], count, self._blocks[number] / count)

    def _derive_blocks(self, name: str, rows: np.ndarray) -> np.ndarray:
        quantity = self._quantities[name]
        values = [quantity.derive(block) for block in rows]
        return np.array(values).reshape(len(rows), rows.shape[1], quantity.components)

    def save(self) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        """Counts, the same on every rank, and the blocks, a row a cell."""
        return {name: getattr(self, name) for name in self._NUMBERS}, {"blocks": np.moveaxis(self._blocks, 1, 0)}

    def load(self, counts: dict[str, Any], sums: dict[str, np.ndarray]) -> None:
        """Go on from what `save` gave, with the rows of this rank's cells."""
        for name in self._NUMBERS:
            setattr(self, name, counts[name])
        self.begins = list(self.begins)
        self._blocks[:] = np.moveaxis(sums["blocks"], 0, 1)

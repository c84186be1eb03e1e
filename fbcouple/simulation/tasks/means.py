"""Time means of solids and gas in each cell, with block-averaged standard errors.

A sample of a cell is a row of densities (per cell volume, so that means add up); quantities such as velocities are
ratios of their means. Particles count in the cell that holds their centre, as the paper averages (section 4).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fbcouple.results.block_errors import AddUp

SOLIDS_COLUMNS = 7
"""sum V_p, sum m_p, sum m_p v (3), sum m_p v.v, sum m_p |v - cell mean|^2, each over the cell volume."""
GAS_COLUMNS = 8
"""eps, u (3), eps u (3), p."""
HEAT_COLUMNS = 2
"""Of solids sum m_p, sum m_p T_p, each over the cell volume; of gas eps, eps T: they are phases of their own."""

_BESIDE = 1e-9
"""Part of a block that a sample may lie behind its end by rounding."""

Derive = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Quantity:
    """A result formed from mean rows: `derive(rows)` gives (cells, components)."""

    components: int
    phase: str
    derive: Derive


def _velocity(rows: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return rows[:, 2:5] / rows[:, 1:2]


def _agitation(rows: np.ndarray) -> np.ndarray:
    velocity = _velocity(rows)
    with np.errstate(invalid="ignore"):
        return rows[:, 5:6] / rows[:, 1:2] - np.sum(velocity**2, axis=1, keepdims=True)


def _granular_temperature(rows: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return rows[:, 6:7] / rows[:, 1:2] / 3.0


def _temperature(rows: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return rows[:, 1:2] / rows[:, :1]


QUANTITIES: dict[str, Quantity] = {
    "solids_fraction": Quantity(1, "solids", lambda rows: rows[:, :1]),
    "solids_flux": Quantity(3, "solids", lambda rows: rows[:, 2:5]),
    "solids_velocity": Quantity(3, "solids", _velocity),
    "agitation": Quantity(1, "solids", _agitation),
    "granular_temperature": Quantity(1, "solids", _granular_temperature),
    "voidage": Quantity(1, "gas", lambda rows: rows[:, :1]),
    "gas_velocity": Quantity(3, "gas", lambda rows: rows[:, 1:4]),
    "gas_flux": Quantity(3, "gas", lambda rows: rows[:, 4:7]),
    "pressure": Quantity(1, "gas", lambda rows: rows[:, 7:8]),
    "solids_temperature": Quantity(1, "solids_heat", _temperature),
    "gas_temperature": Quantity(1, "gas_heat", _temperature),
}


class Block(NamedTuple):
    """A part of the averaging window: the time of its `start` [s], its `samples`, and their mean `rows` (cells,
    columns)."""

    start: float
    samples: int
    rows: np.ndarray


def count_columns(phase: str) -> int:
    """Columns of a row of `phase`: solids or gas, or the heat of one of them."""
    return {"solids": SOLIDS_COLUMNS, "gas": GAS_COLUMNS}.get(phase, HEAT_COLUMNS)


class Means:
    """Running sums of one phase's rows over the averaging window, and of its quantities over blocks of the window; of
    the solids the rows of each block, too."""

    _NUMBERS = ("_samples", "_block_samples", "_block_number", "_length", "_starts", "_counts")

    def __init__(self, phase: str, cells: int, window: tuple[float, float], blocks: int) -> None:
        """The `window` [s] is cut into `blocks` equal blocks."""
        columns = count_columns(phase)
        self._quantities = {name: q for name, q in QUANTITIES.items() if q.phase == phase}
        self._start = window[0]
        self._length = (window[1] - window[0]) / blocks
        self._total, self._block = np.zeros((cells, columns)), np.zeros((cells, columns))
        self._samples = self._block_samples = self._block_number = 0
        self._sums = {name: np.zeros((3, cells, q.components)) for name, q in self._quantities.items()}
        self._keeps_rows = phase == "solids"
        self._rows: list[np.ndarray] = []
        self._starts: list[float] = []
        self._counts: list[int] = []

    @property
    def samples(self) -> int:
        """Samples taken so far."""
        return self._samples

    def add(self, rows: np.ndarray, time: float) -> None:
        """Take a sample: `rows` (cells, columns) at `time` [s]."""
        # A block has its end, not its start: the last sample of the window belongs to the last block.
        block = max(math.ceil((time - self._start) / self._length - _BESIDE) - 1, 0)
        if block != self._block_number:
            self._close_block()
            self._block_number = block
        if not self._block_samples:
            self._starts = [*self._starts, time]
        self._total += rows
        self._block += rows
        self._samples += 1
        self._block_samples += 1

    def save(self) -> tuple[dict[str, float], dict[str, np.ndarray]]:
        """Counts and the length of a block, the same on every rank, and sums, a row a cell."""
        counts = {name: getattr(self, name) for name in self._NUMBERS}
        sums = {name: np.moveaxis(values, 1, 0) for name, values in self._sums.items()}
        if self._keeps_rows:
            kept: np.ndarray = np.array(self._rows, dtype=np.float32).reshape(len(self._rows), *self._total.shape)
            sums["rows"] = kept.swapaxes(0, 1)
        return counts, {"total": self._total, "block": self._block, **sums}

    def load(self, counts: dict[str, float], sums: dict[str, np.ndarray]) -> None:
        """Go on from what `save` gave, with the rows of this rank's cells and blocks as long as before, also where the
        window is longer now."""
        for name in self._NUMBERS:
            setattr(self, name, counts[name])
        self._total[:], self._block[:] = sums["total"], sums["block"]
        for name, values in self._sums.items():
            values[:] = np.moveaxis(sums[name], 0, 1)
        if self._keeps_rows:
            self._rows = list(sums["rows"].swapaxes(0, 1))

    def split_window(self) -> Iterator[Block]:
        """The blocks of the solids one after another; the last one may not be full."""
        yield from map(Block, self._starts, self._counts, self._rows)
        if self._block_samples:
            yield Block(self._starts[-1], self._block_samples, self._block / self._block_samples)

    def _close_block(self) -> None:
        if self._block_samples:
            for name, quantity in self._quantities.items():
                value = quantity.derive(self._block / self._block_samples)
                known = np.isfinite(value)
                value = np.where(known, value, 0.0)
                self._sums[name] += np.stack([known, value, value**2])
            self._counts = [*self._counts, self._block_samples]
            if self._keeps_rows:
                self._rows.append((self._block / self._block_samples).astype(np.float32))
        self._block[:] = 0.0
        self._block_samples = 0

    def collect(self, final: bool, add_up: AddUp | None = None) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Name -> mean and standard error, (cells, components) each; the error is nan before two blocks are full.

        `final`: the window is over, and its last block is full; `add_up` is not needed.
        """
        if final:
            self._close_block()
        return {name: (self._mean(quantity), self._error(name)) for name, quantity in self._quantities.items()}

    def _mean(self, quantity: Quantity) -> np.ndarray:
        return quantity.derive(self._total / max(self._samples, 1))

    def _error(self, name: str) -> np.ndarray:
        count, total, squares = self._sums[name]
        with np.errstate(invalid="ignore", divide="ignore"):
            variance = np.maximum(squares / count - (total / count) ** 2, 0.0)
            return np.where(count > 1, np.sqrt(variance / (count - 1)), np.nan)

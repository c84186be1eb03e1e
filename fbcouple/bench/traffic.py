"""Messages and bytes of the exchange halo on any number of ranks, by making every rank's halo in this process."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np

from fbcouple.case.bed.derived import wraps
from fbcouple.case.bed.particle_types import largest_diameter
from fbcouple.case.schema.sections import Case
from fbcouple.coupling.box.halo import HaloExchange, find_local_grid
from fbcouple.geometry.grid import Grid
from fbcouple.geometry.partition import find_rank_grid, locate_rank

_COMPONENTS = 12
"""Numbers a cell in a coupling step: solids, voidage, K and S (4), velocity and pressure gradient (6)."""
_BYTES = 8


class _Board:
    """What the stand-ins of all ranks see of each other."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.values: list[Any] = [None] * size
        self.barrier = threading.Barrier(size)


class StandIn:
    """A rank's communicator in a thread: what a halo asks of one while it is made.

    `sent[r]` is the number of cells that this rank owns and rank r's local grid holds.
    """

    def __init__(self, board: _Board, rank: int) -> None:
        self.rank, self.size = rank, board.size
        self.sent: list[int] = []
        self._board = board

    def allgather(self, value: Any) -> list[Any]:
        """Every rank's value."""
        self._board.values[self.rank] = value
        self._board.barrier.wait()
        values = list(self._board.values)
        self._board.barrier.wait()
        return values

    def alltoall(self, values: list[Any]) -> list[Any]:
        """What every rank has for this one."""
        self.sent = [len(value) for value in values]
        return [theirs[self.rank] for theirs in self.allgather(values)]


def cut_cells(grid: Grid, ranks: int) -> list[np.ndarray]:
    """Index triples of each rank's cells, as the decks cut them: equal counts along y, and of each of these along x."""
    cells = np.stack(np.meshgrid(*map(np.arange, grid.cells), indexing="ij"), axis=-1).reshape(-1, 3)
    nx, ny = find_rank_grid(grid.size, ranks)
    rows = [_split(row, nx, 0) for row in _split(cells, ny, 1)]
    return [row[place] for place in range(nx) for row in rows]


def _split(cells: np.ndarray, parts: int, axis: int) -> list[np.ndarray]:
    return np.array_split(cells[np.argsort(cells[:, axis], kind="stable")], parts)


def cut_box(grid: Grid, ranks: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Corners [m] of each rank's particle box, as the decks cut it: columns of equal width and depth."""
    shape = find_rank_grid(grid.size, ranks)
    width, depth, height = grid.size
    step = np.array([width / shape[0], depth / shape[1], height])
    lows = [np.array([*locate_rank(rank, shape), 0]) * step for rank in range(ranks)]
    return [(low, low + step) for low in lows]


def count_traffic(case: Case, ranks: int) -> dict[str, Any]:
    """Messages and bytes that a rank sends in a coupling step, the most and the mean over the ranks.

    Bytes are those of whole local cells: a run sends only the layers up to the top of its bed.
    """
    assert case.particles is not None and case.exchange is not None
    grid = Grid(case.domain.cells, case.domain.size, wraps(case.domain))
    board = _Board(ranks)
    stand_ins = [StandIn(board, rank) for rank in range(ranks)]
    halos: dict[int, HaloExchange] = {}
    reach, widen = largest_diameter(case.particles), case.exchange.filter_passes
    parts = list(zip(stand_ins, cut_cells(grid, ranks), cut_box(grid, ranks), strict=True))

    def make(comm: StandIn, owned: np.ndarray, box: tuple[np.ndarray, np.ndarray]) -> None:
        try:
            halos[comm.rank] = HaloExchange(comm, find_local_grid(grid, *box, reach, widen), owned)  # type: ignore[arg-type]
        except BaseException:
            board.barrier.abort()
            raise

    threads = [threading.Thread(target=make, args=part) for part in parts]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    cells = [sum(n for rank, n in enumerate(one.sent) if rank != one.rank) for one in stand_ins]
    messages = [halos[rank].messages for rank in range(ranks)]
    # Forward gives owned cells, reverse the held ones back; what one rank owns another holds.
    held = [sum(one.sent[rank] for one in stand_ins if one.rank != rank) for rank in range(ranks)]
    numbers = [7 * owned + (_COMPONENTS - 7) * back for owned, back in zip(cells, held, strict=True)]
    return {
        "ranks": ranks,
        "cells": grid.count,
        "messages_most": max(messages),
        "messages_mean": sum(messages) / ranks,
        "bytes_most": max(numbers) * _BYTES,
        "bytes_mean": sum(numbers) * _BYTES / ranks,
        "bytes_over_own_cells": sum(numbers) / (_COMPONENTS * grid.count),
    }

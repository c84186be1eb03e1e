"""Who needs which cells of a mesh of polyhedra: made once, neighbour to neighbour, no global arrays.

Gas cells belong to ranks by OpenFOAM's decomposition, particles by LIGGGHTS' boxes. Each rank keeps `LocalCells`: the
cells that its LIGGGHTS box touches, and rings of cells around them for weights and filter. At the start each rank hands
the cells near a box to the box's rank, which chooses from them by the points that they share.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from fbcouple.coupling.box.halo import Traffic, open_traffic
from fbcouple.geometry.polyhedra import Polyhedra, join
from fbcouple.physics.jit import compiled


@dataclass(frozen=True)
class _Link:
    """Cells shared with one rank: `owned` rows here that are local to it, `held` rows here that it owns."""

    rank: int
    owned: np.ndarray
    held: np.ndarray

    @property
    def owned_count(self) -> int:
        return len(self.owned)

    @property
    def held_count(self) -> int:
        return len(self.held)


@dataclass(frozen=True)
class LocalCells:
    """The cells that this rank's particles may touch, in the order of their numbers.

    `inner` are the rows of those that a particle may lie in. Fields on it are arrays (cells + 1, components): one more
    row, as a box's local grid has one more layer.
    """

    cells: Polyhedra
    inner: np.ndarray

    def make_field(self, components: int) -> np.ndarray:
        """Zeros, shape (cells + 1, components)."""
        return np.zeros((len(self.cells) + 1, components))


class CellHaloExchange:
    """The exchange of cell fields between this rank and the ranks that share cells with it."""

    def __init__(self, comm: MPI.Comm, own: Polyhedra, low: np.ndarray, high: np.ndarray, rings: int) -> None:
        """`own`: this rank's gas cells; particles lie in the box `low` to `high` [m]; `rings` of cells around those
        that the box touches belong to the local cells (collective)."""
        self._comm = comm
        self.owned_count = len(own)
        bottom, top = own.find_bounds()
        widest = comm.allreduce(float((top - bottom).max(initial=0.0)), MPI.MAX)
        near = [
            np.flatnonzero(_touches(bottom, top, a - rings * widest, b + rings * widest))
            for a, b in comm.allgather((low, high))
        ]
        # A rank without a cell near its box gets an empty part from itself.
        given = comm.alltoall(
            [(own.select(rows), rows) if len(rows) or rank == comm.rank else None for rank, rows in enumerate(near)]
        )
        parts = [(rank, *part) for rank, part in enumerate(given) if part is not None]
        cells = join([part for _, part, _ in parts])
        source = np.concatenate([np.full(len(rows), rank) for rank, _, rows in parts])
        rows_there = np.concatenate([rows for _, _, rows in parts])
        inner = _touches(*cells.find_bounds(), low, high)
        kept = np.flatnonzero(_grow(cells, inner, rings))
        kept = kept[np.argsort(cells.ids[kept])]
        self.local = LocalCells(cells.select(kept), np.flatnonzero(inner[kept]))
        source, rows_there = source[kept], rows_there[kept]
        asked = comm.alltoall([rows_there[source == rank] for rank in range(comm.size)])
        links = [_Link(rank, asked[rank], np.flatnonzero(source == rank)) for rank in range(comm.size)]
        self._own = links[comm.rank]
        self._links = [link for link in links if link.rank != comm.rank and link.owned_count + link.held_count]
        self._traffic: dict[tuple[int, str], Traffic] = {}

    @property
    def messages(self) -> int:
        """Messages that this rank sends one way."""
        return len(self._links)

    def forward(self, cells: np.ndarray, field: np.ndarray, name: str = "") -> None:
        """Fill local `field` (local + 1, c) from the cell values `cells` (n, c) of their owners (collective)."""
        traffic = self._find_traffic(cells.shape[1], name)
        MPI.Prequest.Startall(traffic.take_held)
        for link, (owned, _) in zip(self._links, traffic.buffers, strict=True):
            np.take(cells, link.owned, axis=0, out=owned)
        MPI.Prequest.Startall(traffic.give_owned)
        _put(cells, self._own.owned, field, self._own.held)
        MPI.Prequest.Waitall(traffic.take_held + traffic.give_owned)
        for link, (_, held) in zip(self._links, traffic.buffers, strict=True):
            field[link.held] = held

    def refill(self, cells: np.ndarray, field: np.ndarray, name: str = "") -> None:
        """Nothing is to be done: a `forward` of a mesh fills all local cells."""

    def reverse(self, field: np.ndarray, cells: np.ndarray) -> None:
        """Set `cells` (n, c) to the sum of every rank's local `field` (>= local, c) over the cells (collective)."""
        traffic = self._find_traffic(cells.shape[1])
        MPI.Prequest.Startall(traffic.take_owned)
        for link, (_, held) in zip(self._links, traffic.buffers, strict=True):
            np.take(field, link.held, axis=0, out=held)
        MPI.Prequest.Startall(traffic.give_held)
        cells[:] = 0.0
        _put(field, self._own.held, cells, self._own.owned)
        MPI.Prequest.Waitall(traffic.take_owned + traffic.give_held)
        for link, (owned, _) in zip(self._links, traffic.buffers, strict=True):
            cells[link.owned] += owned

    def _find_traffic(self, components: int, name: str = "") -> Traffic:
        key = components, name
        if key not in self._traffic:
            self._traffic[key] = open_traffic(self._comm, self._links, components)
        return self._traffic[key]


def _touches(bottom: np.ndarray, top: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Does the box of each cell (n, 3) share a place with the box `low` to `high`?"""
    return np.all((bottom <= high) & (top >= low), axis=1)


def _grow(cells: Polyhedra, marked: np.ndarray, rings: int) -> np.ndarray:
    """Mark also the cells that share a point with one that is marked, `rings` times."""
    corners = cells.corners
    cell = np.repeat(np.arange(len(cells)), corners.lengths)
    for _ in range(rings):
        points = np.zeros(len(cells.points), bool)
        points[corners.values[marked[cell]]] = True
        marked = np.bincount(cell, points[corners.values], minlength=len(cells)) > 0
    return marked


@compiled
def _put(source, rows, target, target_rows):
    for n in range(len(rows)):
        for q in range(source.shape[1]):
            target[target_rows[n], q] = source[rows[n], q]

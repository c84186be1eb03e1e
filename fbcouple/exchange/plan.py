"""Who needs which cells: made once, neighbour to neighbour, no global arrays.

Gas cells belong to ranks by OpenFOAM's decomposition, particles by LIGGGHTS' boxes; the two differ. Each rank keeps a
`Patch`, the block of cells that its LIGGGHTS box touches, widened for the stencil and the filter. `fetch` fills the
patch from the cells' owners, `deposit` adds the patch to the cells' owners.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI
from numba import njit

from fbcouple.errors import SolverError
from fbcouple.grid import Grid

_TAG = 17


@dataclass(frozen=True)
class Patch:
    """A block of cells: the cells `low` to `high` (exclusive) of `grid`, index triples.

    Fields on it are arrays (x + 1, y + 1, z + 1, components): one more layer at the upper ends, so that a stencil at
    the last cell may name its neighbour with weight zero.
    """

    grid: Grid
    low: tuple[int, int, int]
    high: tuple[int, int, int]

    @property
    def shape(self) -> tuple[int, int, int]:
        """Layers along x, y and z, the upper extra layer included."""
        x, y, z = (high - low + 1 for low, high in zip(self.low, self.high, strict=True))
        return x, y, z

    def make_field(self, components: int) -> np.ndarray:
        """Zeros, shape (x + 1, y + 1, z + 1, components)."""
        return np.zeros((*self.shape, components))


def find_patch(grid: Grid, low: np.ndarray, high: np.ndarray, reach: float, widen: int) -> Patch:
    """Patch for particles in the box `low` to `high` [m] that may stray by `reach` [m], widened by `widen` cells."""
    first = np.floor((low - reach) / grid.spacing - 0.5).astype(int) - widen
    last = np.floor((high + reach) / grid.spacing - 0.5).astype(int) + 2 + widen
    first, last = np.clip(first, 0, grid.cells), np.clip(last, 0, grid.cells)
    return Patch(grid, tuple(first.tolist()), tuple(last.tolist()))


@dataclass(frozen=True)
class _Link:
    """Cells shared with one rank: `owned` rows here that its patch holds, `held` patch places that it owns."""

    rank: int
    owned: np.ndarray
    held: np.ndarray


class Plan:
    """The exchange of cell fields between this rank and the ranks that share cells with it."""

    def __init__(self, comm: MPI.Comm, patch: Patch, owned: np.ndarray) -> None:
        """`owned` (n, 3): index triples of this rank's gas cells, in their own order (collective)."""
        self.patch = patch
        self.owned_count = len(owned)
        self._comm = comm
        blocks = comm.allgather((patch.low, patch.high))
        sends = [_inside(owned, *block) for block in blocks]
        triples = comm.alltoall([owned[rows] for rows in sends])
        places = [_places(patch, cells) for cells in triples]
        found = sum(map(len, places))
        wanted = int(np.prod(np.array(patch.high) - patch.low))
        if found != wanted:
            raise SolverError(f"rank {comm.rank}: {wanted} cells of its patch, {found} found among the gas cells")
        pairs = zip(sends, places, strict=True)
        links = [_Link(rank, rows, held) for rank, (rows, held) in enumerate(pairs) if len(rows) or len(held)]
        self._links = [link for link in links if link.rank != comm.rank]
        self._own = next((link for link in links if link.rank == comm.rank), None)
        self._buffers: dict[int, list[tuple[np.ndarray, np.ndarray]]] = {}

    @property
    def messages(self) -> int:
        """Messages that this rank sends in one fetch or deposit."""
        return len(self._links)

    def fetch(self, cells: np.ndarray, field: np.ndarray) -> None:
        """Fill patch `field` (..., c) from the cell values `cells` (n, c) of their owners (collective)."""
        components = cells.shape[1]
        flat = field.reshape(-1, components)
        buffers = self._find_buffers(components)
        requests = [
            self._comm.Irecv(held, link.rank, _TAG) for link, (_, held) in zip(self._links, buffers, strict=True)
        ]
        for link, (owned, _) in zip(self._links, buffers, strict=True):
            _pack(cells, link.owned, owned)
            requests.append(self._comm.Isend(owned, link.rank, _TAG))
        if self._own:
            _copy(cells, self._own.owned, flat, self._own.held)
        MPI.Request.Waitall(requests)
        for link, (_, held) in zip(self._links, buffers, strict=True):
            _unpack(held, link.held, flat)

    def deposit(self, field: np.ndarray, cells: np.ndarray) -> None:
        """Set `cells` (n, c) to the sum of every rank's patch `field` (..., c) over the cells (collective)."""
        components = cells.shape[1]
        flat = field.reshape(-1, components)
        buffers = self._find_buffers(components)
        requests = [
            self._comm.Irecv(owned, link.rank, _TAG) for link, (owned, _) in zip(self._links, buffers, strict=True)
        ]
        for link, (_, held) in zip(self._links, buffers, strict=True):
            _pack(flat, link.held, held)
            requests.append(self._comm.Isend(held, link.rank, _TAG))
        cells[:] = 0.0
        if self._own:
            _copy(flat, self._own.held, cells, self._own.owned)
        MPI.Request.Waitall(requests)
        for link, (owned, _) in zip(self._links, buffers, strict=True):
            _add(owned, link.owned, cells)

    def _find_buffers(self, components: int) -> list[tuple[np.ndarray, np.ndarray]]:
        if components not in self._buffers:
            self._buffers[components] = [
                (np.empty((len(link.owned), components)), np.empty((len(link.held), components)))
                for link in self._links
            ]
        return self._buffers[components]


def _inside(cells: np.ndarray, low: tuple[int, int, int], high: tuple[int, int, int]) -> np.ndarray:
    return np.flatnonzero(np.all((cells >= low) & (cells < high), axis=1))


def _places(patch: Patch, cells: np.ndarray) -> np.ndarray:
    x, y, z = (cells - patch.low).T
    _, ny, nz = patch.shape
    return (x * ny + y) * nz + z


@njit(cache=True)
def _pack(source, rows, buffer):
    for n in range(len(rows)):
        for c in range(source.shape[1]):
            buffer[n, c] = source[rows[n], c]


@njit(cache=True)
def _unpack(buffer, rows, target):
    for n in range(len(rows)):
        for c in range(target.shape[1]):
            target[rows[n], c] = buffer[n, c]


@njit(cache=True)
def _add(buffer, rows, target):
    for n in range(len(rows)):
        for c in range(target.shape[1]):
            target[rows[n], c] += buffer[n, c]


@njit(cache=True)
def _copy(source, rows, target, places):
    for n in range(len(rows)):
        for c in range(target.shape[1]):
            target[places[n], c] = source[rows[n], c]

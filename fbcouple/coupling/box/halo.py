"""Who needs which cells: made once, neighbour to neighbour, no global arrays.

Gas cells belong to ranks by OpenFOAM's decomposition, particles by LIGGGHTS' boxes; the two differ. Each rank keeps a
`LocalGrid`, the block of cells that its LIGGGHTS box touches, widened for the stencil and the filter. `forward` fills
the local from the cells' owners, `reverse` adds the local grid to the cells' owners.

Along a periodic axis a local grid goes on past the domain: its cells there are images of the domain's, further copies
of what it may hold already. Only the halo knows whose images they are.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.errors import SolverError
from fbcouple.geometry.grid import Grid
from fbcouple.physics.jit import compiled

_FORWARD, _REVERSE = 17, 18
_NEVER = 2**40
"""A cell number that no local grid reaches."""


@dataclass(frozen=True)
class LocalGrid:
    """A block of cells: the cells `low` to `high` (exclusive) of `grid` or their images, index triples.

    Fields on it are arrays (z + 1, y + 1, x + 1, components): one more layer at the upper ends, so that a stencil at
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

    @property
    def walls(self) -> np.ndarray:
        """First and last cell along each axis that values stay constant beyond, (2, 3); out of reach if periodic."""
        last = np.array(self.grid.cells) - 1
        return np.where(self.grid.periodic, [[-_NEVER], [_NEVER]], [np.zeros(3, int), last])

    def make_field(self, components: int) -> np.ndarray:
        """Zeros, shape (z + 1, y + 1, x + 1, components)."""
        return np.zeros((*self.shape[::-1], components))


def find_local_grid(grid: Grid, low: np.ndarray, high: np.ndarray, reach: float, widen: int | np.ndarray) -> LocalGrid:
    """Local grid for particles in the box `low` to `high` [m] that may stray by `reach` [m], widened by `widen` cells
    (all axes or (3,))."""
    low, high = grid.measure_from_corner(low), grid.measure_from_corner(high)
    first = np.floor((low - reach) / grid.spacing - 0.5).astype(int) - widen
    last = np.floor((high + reach) / grid.spacing - 0.5).astype(int) + 2 + widen
    inside = np.clip([first, last], 0, grid.cells)
    first, last = np.where(grid.periodic, [first, last], inside)
    return LocalGrid(grid, tuple(first.tolist()), tuple(last.tolist()))


class _Link:
    """Cells shared with one rank: `owned` rows here that its local grid holds, `held` local cells that it owns."""

    def __init__(self, rank: int, owned: np.ndarray, held: np.ndarray, local: LocalGrid) -> None:
        self.rank = rank
        self.owned_count, self.held_count = len(owned), len(held)
        self.pack_owned = _find_runs(owned, np.arange(len(owned)))
        self.unpack_owned = self.pack_owned[:, [1, 0, 2]]
        self.held = _Layered(held, np.arange(len(held)), local)


@dataclass(frozen=True)
class Traffic:
    """For each link its buffers (owned cells, held places), and the persistent requests on them."""

    buffers: list[tuple[np.ndarray, np.ndarray]]
    take_held: list[MPI.Prequest]
    give_owned: list[MPI.Prequest]
    take_owned: list[MPI.Prequest]
    give_held: list[MPI.Prequest]


class HaloExchange:
    """The exchange of cell fields between this rank and the ranks that share cells with it."""

    def __init__(self, comm: MPI.Comm, local: LocalGrid, owned: np.ndarray) -> None:
        """`owned` (n, 3): index triples of this rank's gas cells, in their own order (collective)."""
        self.local = local
        self.owned_count = len(owned)
        self._comm = comm
        blocks = comm.allgather((local.low, local.high))
        sends = [_find_images(owned, local.grid.cells, *block) for block in blocks]
        triples = comm.alltoall([images for _, images in sends])
        indices = [_places(local, cells) for cells in triples]
        found = sum(map(len, indices))
        wanted = int(np.prod(np.array(local.high) - local.low))
        if found != wanted:
            raise SolverError(f"rank {comm.rank}: {wanted} cells of its local grid, {found} found among the gas cells")
        self._links = []
        for rank, ((rows, _), held) in enumerate(zip(sends, indices, strict=True)):
            if rank == comm.rank:
                once = _mark_first(rows)
                self._own = _Layered(held, rows, local)
                self._first, self._images = (_Layered(held[which], rows[which], local) for which in (once, ~once))
            elif len(rows) or len(held):
                self._links.append(_Link(rank, rows, held, local))
        self._traffic: dict[tuple[int, str], Traffic] = {}

    @property
    def messages(self) -> int:
        """Messages that this rank sends one way."""
        return len(self._links)

    def forward(self, cells: np.ndarray, field: np.ndarray, name: str = "") -> None:
        """Fill local `field` (z, .., .., c) from the cell values `cells` (n, c) of their owners (collective).

        `field` may be cut to the lowest layers of the local grid; each rank may take another number of them. What came
        by `name` can be had again from `refill`.
        """
        traffic = self._find_traffic(cells.shape[1], name)
        MPI.Prequest.Startall(traffic.take_held)
        for link, (owned, _) in zip(self._links, traffic.buffers, strict=True):
            _copy(cells, owned, link.pack_owned)
        MPI.Prequest.Startall(traffic.give_owned)
        MPI.Prequest.Waitall(traffic.take_held + traffic.give_owned)
        self.refill(cells, field, name)

    def refill(self, cells: np.ndarray, field: np.ndarray, name: str = "") -> None:
        """Fill `field`, now of more or fewer layers, as the last `forward` of `name` did; no message is sent."""
        flat, layers = field.reshape(-1, cells.shape[1]), len(field)
        _copy(cells, flat, self._own.to_patch(layers))
        for link, (_, held) in zip(self._links, self._find_traffic(cells.shape[1], name).buffers, strict=True):
            _copy(held, flat, link.held.to_patch(layers))

    def reverse(self, field: np.ndarray, cells: np.ndarray) -> None:
        """Set `cells` (n, c) to the sum of every rank's local grid `field` (z, .., .., c) over the cells (collective).

        `field` may be cut to the lowest layers of the local grid: those above it count as zero.
        """
        flat, layers = field.reshape(-1, cells.shape[1]), len(field)
        traffic = self._find_traffic(cells.shape[1])
        MPI.Prequest.Startall(traffic.take_owned)
        for link, (_, held) in zip(self._links, traffic.buffers, strict=True):
            held[:] = 0.0
            _copy(flat, held, link.held.from_patch(layers))
        MPI.Prequest.Startall(traffic.give_held)
        cells[:] = 0.0
        _copy(flat, cells, self._first.from_patch(layers))
        _add(flat, cells, self._images.from_patch(layers))
        MPI.Prequest.Waitall(traffic.take_owned + traffic.give_held)
        for link, (owned, _) in zip(self._links, traffic.buffers, strict=True):
            _add(owned, cells, link.unpack_owned)

    def _find_traffic(self, components: int, name: str = "") -> Traffic:
        key = components, name
        if key not in self._traffic:
            self._traffic[key] = open_traffic(self._comm, self._links, components)
        return self._traffic[key]


def open_traffic(comm: MPI.Comm, links: Sequence[Any], components: int) -> Traffic:
    """Buffers and persistent requests, made once for each number of components."""
    buffers = [(np.empty((k.owned_count, components)), np.empty((k.held_count, components))) for k in links]
    pairs = list(zip(links, buffers, strict=True))
    return Traffic(
        buffers,
        take_held=[comm.Recv_init(held, link.rank, _FORWARD) for link, (_, held) in pairs],
        give_owned=[comm.Send_init(owned, link.rank, _FORWARD) for link, (owned, _) in pairs],
        take_owned=[comm.Recv_init(owned, link.rank, _REVERSE) for link, (owned, _) in pairs],
        give_held=[comm.Send_init(held, link.rank, _REVERSE) for link, (_, held) in pairs],
    )


def _find_images(
    cells: np.ndarray, period: tuple[int, int, int], low: tuple[int, int, int], high: tuple[int, int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Rows (n,) of `cells` that lie in a block or have an image there, again for each image, and the images (n, 3)."""
    first = [-((n - 1 - a) // n) for n, a in zip(period, low, strict=True)]
    last = [(b - 1) // n for n, b in zip(period, high, strict=True)]
    shifts = itertools.product(*(range(a, b + 1) for a, b in zip(first, last, strict=True)))
    images = [cells + np.multiply(shift, period) for shift in shifts] or [cells[:0]]
    rows = [np.flatnonzero(np.all((image >= low) & (image < high), axis=1)) for image in images]
    return np.concatenate(rows), np.concatenate([image[found] for image, found in zip(images, rows, strict=True)])


def _mark_first(rows: np.ndarray) -> np.ndarray:
    """True (n,) where a row stands for the first time."""
    first = np.zeros(len(rows), dtype=bool)
    first[np.unique(rows, return_index=True)[1]] = True
    return first


def _places(local: LocalGrid, cells: np.ndarray) -> np.ndarray:
    x, y, z = (cells - local.low).T
    nx, ny, _ = local.shape
    return (z * ny + y) * nx + x


def _find_runs(sources: np.ndarray, targets: np.ndarray) -> np.ndarray:
    """Rows (n, 3) of source, target and length: stretches where both places go up by one, which copy as one block."""
    if len(sources) == 0:
        return np.empty((0, 3), np.int64)
    breaks = np.flatnonzero((np.diff(sources) != 1) | (np.diff(targets) != 1)) + 1
    starts = np.concatenate([[0], breaks])
    lengths = np.diff(np.concatenate([starts, [len(sources)]]))
    return np.column_stack([sources[starts], targets[starts], lengths]).astype(np.int64)


class _Layered:
    """Cells of the local grid grid beside rows elsewhere, as runs sorted by layer, so that the lower layers copy
    alone."""

    def __init__(self, indices: np.ndarray, rows: np.ndarray, local: LocalGrid) -> None:
        order = np.argsort(indices, kind="stable")
        self._from_local = _find_runs(indices[order], rows[order])
        self._to_local = self._from_local[:, [1, 0, 2]]
        self._layers = self._from_local[:, 0] // (local.shape[0] * local.shape[1])

    def from_patch(self, layers: int) -> np.ndarray:
        """Runs whose source is in the lowest `layers` of the local grid."""
        return self._from_local[: np.searchsorted(self._layers, layers)]

    def to_patch(self, layers: int) -> np.ndarray:
        """Runs whose target is in the lowest `layers` of the local grid."""
        return self._to_local[: np.searchsorted(self._layers, layers)]


@compiled
def _copy(source, target, runs):
    width = source.shape[1]
    here, there = source.ravel(), target.ravel()
    for n in range(len(runs)):
        given, taken = here[runs[n, 0] * width :], there[runs[n, 1] * width :]
        for q in range(runs[n, 2] * width):
            taken[q] = given[q]


@compiled
def _add(source, target, runs):
    width = source.shape[1]
    here, there = source.ravel(), target.ravel()
    for n in range(len(runs)):
        given, taken = here[runs[n, 0] * width :], there[runs[n, 1] * width :]
        for q in range(runs[n, 2] * width):
            taken[q] += given[q]

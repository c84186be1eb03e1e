"""The ways to share a particle among cells, by the word of `exchange.voidage`.

A method writes particle values to the cells of a local grid and reads cell values back with the same weights, so that
one is the transpose of the other and what is written adds up to what the particles have, next to walls too. The kernels
of the forces (kernels.py) know trilinear stencils only. A method whose weights are none reads the cells into one row a
particle before a kernel runs, lets the kernel write such rows, and shares them among the cells itself: for the kernel,
each particle then stands on a cell of its own.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fbcouple.case.bed.particle_types import find_ratio, largest_diameter
from fbcouple.case.schema.sections import Case
from fbcouple.coupling.box.corners import Stencil, corner_offsets
from fbcouple.coupling.box.halo import LocalGrid
from fbcouple.coupling.box.stencils import CUT, block_offsets, divide, gather, satellites, scatter, spread_out
from fbcouple.coupling.box.trilinear import Weights, report_stray

"""Of the kernels in kernels.py: lower cell (n,), weights of the upper cells (n, 3), steps to the corners (8,)."""


@dataclass(frozen=True)
class Widths:
    """How far a particle reaches: the largest radius, the bandwidths of the Gaussian kernel and of the diffusion [m].

    A bandwidth is 0 where there is none.
    """

    radius: float
    bandwidth: float
    diffusion: float = 0.0


def find_widths(case: Case) -> Widths:
    """The largest radius of the case's particles and the bandwidths that it asks for."""
    assert case.exchange is not None
    if case.particles is None:
        return Widths(0.0, 0.0)
    relative = case.exchange.kernel_width or 0.0, case.exchange.diffusion_width or 0.0
    diameter = find_ratio(case.particles) * case.particles.diameter
    return Widths(largest_diameter(case.particles) / 2.0, *(part * diameter for part in relative))


class Mapping(ABC):
    """How particles and the cells of a local grid exchange values."""

    def __init__(self, local: LocalGrid, widths: Widths) -> None:
        self.local = local

    @staticmethod
    def find_reach(widths: Widths) -> float:
        """Distance [m] from its centre at which a particle still has weight in the cell there."""
        return 0.0

    @abstractmethod
    def locate(self, positions: np.ndarray, radii: np.ndarray) -> None:
        """Find the weights of particles at `positions` (n, 3) [m] with `radii` (n,) [m].

        Raises DivergedError, with the place, if a particle has left the local grid.
        """

    @property
    @abstractmethod
    def stencil(self) -> Stencil:
        """Where the kernels find the particles' values in what `read` and `open` return."""

    @property
    @abstractmethod
    def layers(self) -> int:
        """Layers of the local grid, from its lowest, that this rank's particles have weight in."""

    @abstractmethod
    def read(self, field: np.ndarray, columns: int) -> np.ndarray:
        """Rows (places, >= columns) for the kernels to read: the first columns of local `field` (.., .., .., c).

        Valid until the next call with as many columns.
        """

    @abstractmethod
    def open(self, field: np.ndarray) -> np.ndarray:
        """Rows (places, c) for the kernels to add to, before `write`; sets `field` to 0."""

    @abstractmethod
    def write(self, rows: np.ndarray, field: np.ndarray) -> None:
        """Add the rows of `open` to local `field`."""


def find_layers(local: LocalGrid, highest: int, height: int) -> int:
    """Layers of `local` up to the top of the highest block, of `height` layers from the place `highest` on."""
    nx, ny, _ = local.shape
    return highest // (nx * ny) + height


VOIDAGE_METHODS: dict[str, type[Mapping]] = {}


def voidage_method(name: str) -> Callable[[type[Mapping]], type[Mapping]]:
    """Register a method under the word `name` of `exchange.voidage` (its words stand in the schema too)."""

    def register(method: type[Mapping]) -> type[Mapping]:
        VOIDAGE_METHODS[name] = method
        return method

    return register


@voidage_method("trilinear")
class Trilinear(Mapping):
    """To the eight cells around the centre (paper, eq. 28)."""

    def __init__(self, local: LocalGrid, widths: Widths) -> None:
        super().__init__(local, widths)
        self._weights, self._offsets = Weights(local), corner_offsets(local)

    def locate(self, positions: np.ndarray, radii: np.ndarray) -> None:
        self._weights.locate(self.local.grid.measure_from_corner(positions))

    @property
    def stencil(self) -> Stencil:
        return Stencil(self._weights.base, self._weights.upper, self._offsets)

    @property
    def layers(self) -> int:
        return find_layers(self.local, self._weights.highest, 2)

    def read(self, field: np.ndarray, columns: int) -> np.ndarray:
        return field.reshape(-1, field.shape[-1])

    def open(self, field: np.ndarray) -> np.ndarray:
        field.fill(0.0)
        return field.reshape(-1, field.shape[-1])

    def write(self, rows: np.ndarray, field: np.ndarray) -> None:
        """Nothing is left to do: the rows are the field."""


class _Gathered(Mapping):
    """A method with weights of its own: a kernel sees one row a particle."""

    _by_axes = False
    """Is the weight of a cell the product of one of each axis?"""

    def __init__(self, local: LocalGrid, widths: Widths) -> None:
        super().__init__(local, widths)
        self._room = -1
        self._count = 0
        self._corners = np.zeros(8, np.uint64)
        grid = local.grid
        self._box = 1.0 / grid.spacing, np.array(local.low), np.array(local.high), local.walls
        self._lengths = np.minimum(self._count_cells(widths), np.subtract(local.high, local.low))
        self._offsets = block_offsets(local, self._lengths)

    @abstractmethod
    def _count_cells(self, widths: Widths) -> np.ndarray:
        """The most cells (3,) that a particle touches along each axis."""

    @abstractmethod
    def _fill(self, positions: np.ndarray, radii: np.ndarray) -> int:
        """Fill `_base` and `_table`; returns the first particle that does not fit into the local grid, or -1."""

    def locate(self, positions: np.ndarray, radii: np.ndarray) -> None:
        self._count = len(positions)
        if self._count > self._room:
            self._room = self._count + self._count // 4
            self._own, self._upper = np.arange(self._room, dtype=np.uint64), np.zeros((self._room, 3))
            self._bases = np.empty(self._room, np.uint64)
            self._tables = np.empty((self._room, self._lengths.sum() if self._by_axes else self._lengths.prod()))
            self._rows: dict[tuple[int, str], np.ndarray] = {}
        self._base, self._table = self._bases[: self._count], self._tables[: self._count]
        coordinates = self.local.grid.measure_from_corner(positions)
        report_stray(self.local, positions, self._fill(coordinates, radii))

    @property
    def stencil(self) -> Stencil:
        return Stencil(self._own[: self._count], self._upper[: self._count], self._corners)

    @property
    def layers(self) -> int:
        return find_layers(self.local, int(self._base.max(initial=0)), int(self._lengths[2]))

    def read(self, field: np.ndarray, columns: int) -> np.ndarray:
        rows = self._find_rows(columns, "read")
        gather(*self._weights, field.reshape(-1, field.shape[-1]), rows)
        return rows

    def open(self, field: np.ndarray) -> np.ndarray:
        field.fill(0.0)
        rows = self._find_rows(field.shape[-1], "written")
        rows.fill(0.0)
        return rows

    def write(self, rows: np.ndarray, field: np.ndarray) -> None:
        scatter(*self._weights, rows, field.reshape(-1, field.shape[-1]))

    @property
    def _weights(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, bool, np.ndarray]:
        return self._base, self._offsets, self._lengths, self._by_axes, self._table

    def _find_rows(self, components: int, purpose: str) -> np.ndarray:
        key = components, purpose
        if key not in self._rows:
            self._rows[key] = np.empty((self._room, components))
        return self._rows[key][: self._count]


@voidage_method("centre")
class Centre(_Gathered):
    """All of a particle to the cell that holds its centre (particle centre method)."""

    def _count_cells(self, widths: Widths) -> np.ndarray:
        return np.ones(3, np.int64)

    def _fill(self, positions: np.ndarray, radii: np.ndarray) -> int:
        return divide(
            positions, radii, np.zeros((1, 3)), *self._box, self._lengths, self.local.shape, self._base, self._table
        )


@voidage_method("divided")
class Divided(_Gathered):
    """In 29 equal parts, each to the cell that holds its satellite point (`stencils.satellites`)."""

    @staticmethod
    def find_reach(widths: Widths) -> float:
        return widths.radius

    def _count_cells(self, widths: Widths) -> np.ndarray:
        return np.ceil(2.0 * widths.radius * self._box[0]).astype(np.int64) + 1

    def _fill(self, positions: np.ndarray, radii: np.ndarray) -> int:
        points = satellites()
        return divide(positions, radii, points, *self._box, self._lengths, self.local.shape, self._base, self._table)


@voidage_method("gaussian")
class Gaussian(_Gathered):
    """By a Gaussian kernel exp(-r^2/b^2) around the centre, b the bandwidth, integrated over each cell.

    What would lie beyond a wall is reflected. Each axis has its own weights, whose product is that of the cell. The
    kernel ends at 3 b, where 2e-5 of it is left an axis; the rest is scaled up to all of the particle. b is the
    bandwidth of Sun and Xiao 2015 (Int. J. Multiphase Flow 77, 142). The cost grows as (b/cell)^3; diffusion of the
    same b is nearly the same kernel for a small part of it (diffusion.py).
    """

    _by_axes = True

    @staticmethod
    def find_reach(widths: Widths) -> float:
        return CUT * widths.bandwidth

    def __init__(self, local: LocalGrid, widths: Widths) -> None:
        super().__init__(local, widths)
        self._bandwidth = widths.bandwidth

    def _count_cells(self, widths: Widths) -> np.ndarray:
        return np.ceil(2.0 * CUT * widths.bandwidth * self._box[0]).astype(np.int64) + 1

    def _fill(self, positions: np.ndarray, radii: np.ndarray) -> int:
        return spread_out(
            positions, self._bandwidth, *self._box, self._lengths, self.local.shape, self._base, self._table
        )

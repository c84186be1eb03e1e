"""One coupling step between the move of the particles and the next: map, drag, react (engine-free)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from fbcouple.case.schema import Case
from fbcouple.exchange import momentum
from fbcouple.exchange.drag import DRAG_LAWS
from fbcouple.exchange.filter import filter_field
from fbcouple.exchange.plan import Plan, find_patch
from fbcouple.exchange.weights import Weights, corner_offsets
from fbcouple.grid import Grid

_AVERAGES = {"exponential": momentum.average_exactly, "semi-implicit": momentum.average_implicitly}


@dataclass(frozen=True)
class Particles:
    """This rank's particles as the solver shows them now: positions, velocities (n, 3), radii, masses (n,)."""

    positions: np.ndarray
    velocities: np.ndarray
    radii: np.ndarray
    masses: np.ndarray


NOBODY = Particles(np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty(0))


class Coupling:
    """The exchange between this rank's particles and gas cells.

    `voidage` (cells,), `drag_coefficient` (cells,) [kg m-3 s-1] and `drag_source` (cells, 3) [N m-3] are what the gas
    step takes.
    """

    def __init__(self, case: Case, comm: MPI.Comm, centres: np.ndarray, bounds: np.ndarray, reach: float) -> None:
        """`centres` (cells, 3) [m] of this rank's gas cells; `bounds` (2, 3) [m] of its particles' box, which they
        may leave by `reach` [m] (collective)."""
        assert case.gas is not None and case.exchange is not None
        self._gas, self._options = case.gas, case.exchange
        grid = Grid(case.domain.cells, case.domain.size)
        patch = find_patch(grid, bounds[0], bounds[1], reach, case.exchange.filter_passes)
        self.plan = Plan(comm, patch, grid.indices(centres))
        self.weights = Weights(patch)
        self._offsets = corner_offsets(patch)
        self._cell_volume = grid.cell_volume
        self._law = DRAG_LAWS[case.exchange.drag]
        self._push = float(case.exchange.pressure_gradient)
        self._lift = self._push * case.gas.density * case.gravity
        cells = len(centres)
        self.voidage = np.ones(cells)
        self.drag_coefficient, self.drag_source = np.zeros(cells), np.zeros((cells, 3))
        self._deposit = {1: np.empty((cells, 1)), 4: np.empty((cells, 4))}
        self._gas_cells = np.empty((cells, 6))
        self._fields = {c: patch.make_field(c) for c in (1, 4, 6)}
        self._voidage_field = patch.make_field(1)
        self._room = 0

    def map(self, particles: Particles) -> None:
        """Voidage of the cells from the particles' places: eps = 1 - sum w V_p/dV (eqs 30, 33, 34)."""
        self.weights.locate(particles.positions)
        self._make_room(len(particles.positions))
        self._write(1, momentum.write_volume, particles.radii)
        np.subtract(1.0, self._deposit[1][:, 0] / self._cell_volume, out=self.voidage)

    def drag(self, particles: Particles, dt: float) -> None:
        """K and S of the next gas step from slip and voidage at the particles, averaged over `dt` [s]."""
        n = len(particles.positions)
        self.plan.fetch(self.voidage[:, None], self._voidage_field)
        voidage, slip, wind = self._voidage[:n], self._slip[:n], self._wind[:n]
        flat = self._fields[6].reshape(-1, 6), self._voidage_field.reshape(-1, 1)
        momentum.read_slip(*self._stencil, particles.velocities, *flat, voidage, slip, wind)
        self.beta = self._beta[:n]
        self._law.kernel(voidage, slip, 2.0 * particles.radii, self._gas.density, self._gas.viscosity, self.beta)
        if self._options.scheme == "explicit":
            self._write(4, momentum.write_drag_explicitly, self.beta, particles.velocities, wind)
        else:
            _AVERAGES[self._options.scheme](self.beta, particles.masses, dt)
            self._write(4, momentum.write_drag, self.beta, particles.velocities)
        np.divide(self._deposit[4][:, 0], self._cell_volume, out=self.drag_coefficient)
        np.divide(self._deposit[4][:, 1:], self._cell_volume, out=self.drag_source)

    def react(
        self,
        particles: Particles,
        velocity: np.ndarray,
        pressure_gradient: np.ndarray,
        factor: float,
        held: np.ndarray,
        current: np.ndarray,
    ) -> float:
        """Put the particles under `factor` times the force of the new gas (cells, 3 each), in place.

        held (n, 3) [N]: the gas force of their next sub-steps; current (n, 3) [N]: the total force that their next
        half kick starts from. Returns the summed drag magnitude [N] without the factor (collective).
        """
        self.read_gas(velocity, pressure_gradient)
        return momentum.react(
            *self._stencil,
            self._fields[6].reshape(-1, 6),
            self.beta,
            particles.velocities,
            self._wind[: len(held)],
            self._options.scheme == "explicit",
            particles.radii,
            self._push,
            self._lift,
            factor,
            held,
            current,
        )

    def read_gas(self, velocity: np.ndarray, pressure_gradient: np.ndarray) -> None:
        """Bring the gas (cells, 3 each) to the particles' patches, filtered (collective)."""
        self._gas_cells[:, :3], self._gas_cells[:, 3:] = velocity, pressure_gradient
        self.plan.fetch(self._gas_cells, self._fields[6])
        filter_field(self.plan.patch, self._fields[6], self._options.filter_passes)

    @property
    def gas_input(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Voidage, K and S of the next gas step."""
        return self.voidage, self.drag_coefficient, self.drag_source

    def find_gas_loss(self, velocity: np.ndarray, pressure_gradient: np.ndarray) -> np.ndarray:
        """Force [N], shape (3,), that this rank's cells gave up by the last step: drag and pressure gradient."""
        loss = np.zeros(3)
        momentum.find_loss(velocity, pressure_gradient, *self.gas_input, self._push, self._lift, loss)
        return self._cell_volume * loss

    @property
    def _stencil(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return self.weights.base, self.weights.upper, self._offsets

    def _write(self, components: int, kernel, *values: np.ndarray) -> None:
        """Write particles' values to the patch, filter them there, and add them up at the cells' owners."""
        field = self._fields[components]
        field.fill(0.0)
        kernel(*self._stencil, *values, field.reshape(-1, components))
        filter_field(self.plan.patch, field, self._options.filter_passes)
        self.plan.deposit(field, self._deposit[components])

    def _make_room(self, count: int) -> None:
        if count > self._room:
            self._room = count + count // 4
            self._voidage, self._slip, self._beta = (np.empty(self._room) for _ in range(3))
            self._wind = np.empty((self._room, 3))

"""One coupling step between the move of the particles and the next: map, drag, react (engine-free)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.case.derived import wraps
from fbcouple.case.schema import Case
from fbcouple.exchange import momentum
from fbcouple.exchange.diffusion import Diffusion, find_margin
from fbcouple.exchange.drag import choose_law
from fbcouple.exchange.filter import filtered
from fbcouple.exchange.forces import Forces, choose_forces
from fbcouple.exchange.momentum import DRAG_SCHEMES
from fbcouple.exchange.particles import Particles
from fbcouple.exchange.plan import Plan, find_patch
from fbcouple.exchange.voidage import VOIDAGE_METHODS, find_spread
from fbcouple.grid import Grid


class Coupling:
    """The exchange between this rank's particles and gas cells.

    `voidage` (cells,), `drag_coefficient` (cells,) [kg m-3 s-1] and `drag_source` (cells, 3) [N m-3] are what the gas
    step takes.
    """

    def __init__(self, case: Case, comm: MPI.Comm, centres: np.ndarray, bounds: np.ndarray, reach: float) -> None:
        """`centres` (cells, 3) [m] of this rank's gas cells; `bounds` (2, 3) [m] of its particles' box, which they
        may leave by `reach` [m]; a drag file lies in the current folder (collective)."""
        assert case.gas is not None and case.exchange is not None
        self._gas, self._options = case.gas, case.exchange
        grid = Grid(case.domain.cells, case.domain.size, wraps(case.domain))
        method, spread = VOIDAGE_METHODS[case.exchange.voidage], find_spread(case)
        reach += method.find_reach(spread)
        self._widen = case.exchange.filter_passes + find_margin(grid.spacing, spread.diffusion)
        patch = find_patch(grid, bounds[0], bounds[1], reach, self._widen)
        self.plan = Plan(comm, patch, grid.indices(centres))
        self._mapping = method(patch, spread)
        self._diffusion = Diffusion(patch, spread.diffusion) if spread.diffusion else None
        self._cell_volume = grid.cell_volume
        self._law = choose_law(case.exchange, Path())
        self._explicit = case.exchange.scheme == "explicit"
        self._push = float(case.exchange.pressure_gradient)
        self._lift = self._push * case.gas.density * case.gravity
        self.forces = None
        if names := choose_forces(case):
            self.forces = Forces(case, names, self.plan, self._smooth_field)
            self._lift += self.forces.weight
        cells = len(centres)
        self.voidage = np.ones(cells)
        self.drag_coefficient, self.drag_source = np.zeros(cells), np.zeros((cells, 3))
        self._deposit = {1: np.empty((cells, 1)), 4: np.empty((cells, 4))}
        self._fields = {c: patch.make_field(c) for c in (1, 4, 6)}
        self._scratch = {c: patch.make_field(c) for c in (1, 4, 6)} if case.exchange.filter_passes else self._fields
        # Velocity, voidage and pressure gradient of a cell side by side, and one number more: two vectors of four.
        self._gas_rows = patch.make_field(8)
        self._room = -1
        self._layers = self._read_layers = len(self._gas_rows)
        self._state = np.zeros((cells, 6))

    def map(self, particles: Particles) -> None:
        """Voidage of the cells from the particles' places: eps = 1 - sum w V_p/dV (eqs 30, 33, 34)."""
        self._mapping.locate(particles.positions, particles.radii)
        self._make_room(len(particles.positions))
        self._layers = self._count_layers()
        field = self._fields[1][: self._layers]
        rows = self._mapping.open(field)
        momentum.write_volume(*self._mapping.stencil, particles.radii, rows)
        self._mapping.write(rows, field)
        self._add_up(1)
        np.subtract(1.0, self._deposit[1][:, 0] / self._cell_volume, out=self.voidage)

    def drag(self, particles: Particles, dt: float) -> None:
        """K and S of the next gas step from slip and voidage at the particles, averaged over `dt` [s]."""
        if self._layers > self._read_layers:
            self.plan.refill(self._state, self._fields[6][: self._layers], "gas")
            self._line_up_gas()
        voidage = self._fields[1][: self._layers]
        self.plan.fetch(self.voidage[:, None], voidage)
        self._gas_rows[: self._layers, ..., 3] = voidage[..., 0]
        self.beta = self._beta[: len(particles.positions)]
        field = self._fields[4][: self._layers]
        rows, gas_rows = self._mapping.open(field), self._mapping.read(self._gas_rows, 4)
        momentum.exert(
            self._law.kernel,
            DRAG_SCHEMES[self._options.scheme],
            self._explicit,
            *self._mapping.stencil,
            particles.velocities,
            particles.radii,
            particles.masses,
            gas_rows,
            self._gas.density,
            self._gas.viscosity,
            dt,
            self.beta,
            rows,
        )
        if self.forces:
            self.forces.exert(particles, self._mapping, gas_rows, dt, rows)
        self._mapping.write(rows, field)
        self._add_up(4)
        momentum.spread_over_volume(self._deposit[4], self._cell_volume, *self.gas_input[1:])

    def react(
        self, particles: Particles, gas: np.ndarray, factor: float, held: np.ndarray, current: np.ndarray
    ) -> float:
        """Put the particles under `factor` times the force of the new gas, in place.

        gas (cells, 6): velocity [m/s] and pressure gradient [Pa/m]; held (n, 3) [N]: the gas force of the next
        sub-steps; current (n, 3) [N]: the total force that their next half kick starts from. Returns the sum of the
        magnitudes [N] of drag and extra forces without the factor (collective).
        """
        before = self._gas_rows[..., :3].copy() if self._explicit else None
        self.read_gas(gas)
        rows = self._gas_rows
        if before is not None:
            rows = rows.copy()
            rows[..., :3] = before
        drag = momentum.react(
            *self._mapping.stencil,
            self._mapping.read(rows, 8),
            self.beta,
            particles.velocities,
            particles.radii,
            self._push,
            self._lift,
            factor,
            held,
            current,
        )
        if self.forces:
            drag += self.forces.hand_over(self._mapping, self._mapping.read(self._gas_rows, 4), factor, held, current)
        return drag

    def read_gas(self, gas: np.ndarray) -> None:
        """Bring velocity and pressure gradient (cells, 6) to the particles' patch, filtered (collective)."""
        self._state = gas
        self.plan.fetch(gas, self._fields[6][: self._layers], "gas")
        self._line_up_gas()

    def _line_up_gas(self) -> None:
        field = self._smooth(6)
        momentum.line_up(field.reshape(-1, 6), self._gas_rows[: self._layers].reshape(-1, 8))
        self._read_layers = self._layers

    def _smooth(self, components: int) -> np.ndarray:
        """Diffuse and filter a patch field as far as the case asks for it; the operators commute."""
        return self._smooth_field(*(fields[components][: self._layers] for fields in (self._fields, self._scratch)))

    def _smooth_field(self, field: np.ndarray, scratch: np.ndarray) -> np.ndarray:
        if self._diffusion:
            self._diffusion.smooth(field)
        return filtered(field, self._options.filter_passes, scratch)

    def _count_layers(self) -> int:
        """Lowest layers of the patch that hold all that particles write, and exact values where they read.

        Filter and diffusion carry what they write up, by a layer a pass and by a margin, and the reflection at the cut
        down by as much what they read; the last layer is the extra one of a patch.
        """
        return min(self._mapping.layers + int(self._widen[2]) + 1, len(self._gas_rows))

    @property
    def gas_input(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Voidage, K and S of the next gas step."""
        return self.voidage, self.drag_coefficient, self.drag_source

    def find_gas_loss(self, gas: np.ndarray) -> np.ndarray:
        """Force [N], shape (3,), that this rank's cells gave up by the step to `gas` (cells, 6) and the particles are
        still to get."""
        loss = np.zeros(3)
        momentum.find_loss(gas, *self.gas_input, self._push, self._lift, loss)
        return self._cell_volume * loss - (self.forces.moved if self.forces else 0.0)

    def _add_up(self, components: int) -> None:
        """Smooth a patch field and add it up at the owners of the cells (collective)."""
        # The last layer, the extra one, holds nothing that counts: what a higher bed left there.
        self.plan.deposit(self._smooth(components)[:-1], self._deposit[components])

    def _make_room(self, count: int) -> None:
        if count > self._room:
            self._room = count + count // 4
            self._beta = np.empty(self._room)

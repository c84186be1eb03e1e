"""One coupling step between the move of the particles and the next: voidage, drag, gas force (engine-free)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from fbcouple.case.bed.particle_types import find_ratio, grains_per_parcel
from fbcouple.case.schema.sections import Case
from fbcouple.case.user_laws import choose_drag
from fbcouple.coupling import kernels
from fbcouple.coupling.discretisation import Space
from fbcouple.coupling.forces import Forces, choose_forces
from fbcouple.coupling.heat import HeatExchange
from fbcouple.coupling.kernels import DRAG_SCHEMES, Bed, Drag, GasForce, Prediction
from fbcouple.coupling.negative import ROUNDING, Negative
from fbcouple.coupling.particles import Particles
from fbcouple.physics.jit import find_address


class Coupling:
    """The exchange between this rank's particles and gas cells.

    `voidage` (cells,) and `drag_sums` (cells, 4), the sums of beta~ [kg/s] and beta~ v [N] over the particles of each
    cell, are what the gas step takes. `negative` is the particle that the drag of the last step pushes hardest against
    its slip, if it does so to one of this rank.
    """

    def __init__(self, case: Case, space: Space, held_gravity: float = 0.0) -> None:
        """`space` has the cells; a drag file lies in the current folder; held_gravity [m/s2]: whose weight the held
        force brings along with the force of the gas (collective)."""
        assert case.gas is not None and case.exchange is not None
        self.space, self.halo, self.mapping = space, space.halo, space.mapping
        self.law, self._law_name = choose_drag(case.exchange, Path()), case.exchange.drag
        self.negative: Negative | None = None
        self._explicit = case.exchange.scheme == "explicit"
        addresses = find_address(self.law.kernel), find_address(DRAG_SCHEMES[case.exchange.scheme])
        self._polydisperse = case.exchange.polydisperse != "none"
        self._expands = case.heat is not None and case.heat.has_ideal_gas
        gas, parcels = (case.gas.density, case.gas.viscosity), (1.0, 1.0)
        if case.particles:
            parcels = find_ratio(case.particles), grains_per_parcel(case.particles)
        self._drag = Drag(*addresses, self._explicit, self._polydisperse, self._expands, *gas, *parcels)
        self._held_gravity = held_gravity
        self._gradient_factor = float(case.exchange.pressure_gradient)
        self._buoyancy = self._gradient_factor * case.gas.density * case.gravity
        self.forces = None
        if names := choose_forces(case):
            self.forces = Forces(case, names, space)
            self._buoyancy += self.forces.weight
        self._heat = HeatExchange(case, space) if case.heat else None
        cells = self.halo.owned_count
        self.voidage, self._solids, self.drag_sums = np.ones(cells), np.zeros((cells, 1)), np.zeros((cells, 4))
        self._fields = {c: space.make_field(c) for c in (1, 4, 6)}
        self._scratch = {c: space.make_field(c) for c in (1, 4, 6)} if space.needs_scratch else self._fields
        self._areas = np.zeros((cells if self._polydisperse else 0, 1))
        # Velocity, voidage and pressure gradient of a cell side by side, and one number more, which polydisperse drag
        # and an ideal gas have a use for, a case one of them: two vectors of four.
        self._gas_rows = space.make_field(8)
        self._room = -1
        self._nobody = np.empty((0, 3))
        self._dt = 0.0
        self._prediction = Prediction(self._nobody, 1.0, self._nobody)
        self._layers = self._read_layers = len(self._gas_rows)
        self._state = np.zeros((cells, 6))

    def map(self, particles: Particles) -> None:
        """Voidage of the cells from the particles' places: eps = 1 - sum w V_p/dV (eqs 30, 33, 34)."""
        self.mapping.locate(particles.positions, particles.radii)
        self._make_room(len(particles.positions))
        self._layers = self._count_layers()
        self._map(kernels.write_volume, particles.radii, self._solids)
        np.divide(self._solids[:, 0], self.space.volumes, out=self.voidage)
        np.subtract(1.0, self.voidage, out=self.voidage)
        if self._polydisperse:
            self._map(kernels.write_area, particles.radii, self._areas)
            self._areas /= self.space.volumes[:, None]

    def _map(self, write: Callable[..., None], radii: np.ndarray, sums: np.ndarray) -> None:
        """Set `sums` (cells, 1) to what the kernel `write` makes of the particles."""
        field = self._fields[1][: self._layers]
        rows = self.mapping.open(field)
        write(self.mapping.stencil, radii, rows)
        self.mapping.write(rows, field)
        self._add_up(sums)

    def deposit_drag(
        self, particles: Particles, dt: float, last_dt: float = 0.0, densities: np.ndarray | None = None
    ) -> None:
        """The drag of the next gas step from slip and voidage at the particles, averaged over `dt` [s].

        last_dt [s]: length of the step in which the particles came by their velocities, of which what other forces did
        in it is known; 0: as long as the next. densities (cells,): of an ideal gas, over that of the case.
        """
        if self._layers > self._read_layers:
            self.halo.refill(self._state, self._fields[6][: self._layers], "gas")
            self._line_up_gas()
        voidage = self._fields[1][: self._layers]
        self.halo.forward(self.voidage[:, None], voidage)
        self._gas_rows[: self._layers, ..., 3] = voidage[..., 0]
        if self._polydisperse:
            self.halo.forward(self._areas, voidage)
            self._gas_rows[: self._layers, ..., 7] = voidage[..., 0]
        if densities is not None:
            self.halo.forward(densities[:, None], voidage)
            self._gas_rows[: self._layers, ..., 7] = voidage[..., 0]
        self.beta = self._beta[: len(particles.positions)]
        field = self._fields[4][: self._layers]
        columns = 8 if self._polydisperse or self._expands else 4
        rows, gas_rows = self.mapping.open(field), self.mapping.read(self._gas_rows, columns)
        self._seen = gas_rows
        drag_only, effective = self._nobody, particles.velocities
        if particles.drag_only_velocities is not None:
            drag_only, effective = particles.drag_only_velocities, self._effectives[: len(particles.positions)]
        self._dt, self._prediction = dt, Prediction(drag_only, dt / (last_dt or dt), effective)
        bed = Bed(particles.velocities, particles.radii, particles.masses)
        about = self._drag, self.mapping.stencil, bed, gas_rows, dt, self.beta, self._prediction, rows
        self.negative = self._describe(kernels.deposit_drag(*about), particles)
        if self.forces:
            self.forces.deposit(particles, self.mapping, gas_rows, (last_dt or dt, dt), rows)
        self.mapping.write(rows, field)
        self._add_up(self.drag_sums)

    def _describe(self, lowest: tuple[float, int, float, float, float], particles: Particles) -> Negative | None:
        """What `kernels.deposit_drag` has found; None for rounding."""
        beta, particle, voidage, slip, size = lowest
        drag = self._drag
        if not beta < -ROUNDING * drag.grains * 3.0 * np.pi * drag.viscosity * size:
            return None
        reynolds = voidage * drag.density * slip * size / drag.viscosity
        what, place = f"a drag coefficient of {beta:.4g} kg/s", particles.positions[particle].copy()
        return Negative(what, "exchange.drag", self._law_name, place, voidage, reynolds, slip)

    def apply_gas_force(
        self, particles: Particles, gas: np.ndarray, coupling_force: np.ndarray, total_force: np.ndarray
    ) -> float:
        """Put the particles under the force of the new gas, in place.

        gas (cells, 6): velocity [m/s] and pressure gradient [Pa/m]; coupling_force (n, 3) [N]: the gas force of the DEM
        steps to come, with the weight where it is held; total_force (n, 3) [N]: the force that their next half kick
        starts from. Returns the sum of the magnitudes [N] of drag and extra forces (collective).
        """
        before = self._gas_rows[..., :3].copy() if self._explicit else None
        self.read_gas(gas)
        rows = self._gas_rows
        if before is not None:
            rows = rows.copy()
            rows[..., :3] = before
        bed = Bed(particles.velocities, particles.radii, particles.masses)
        force = GasForce(self._gradient_factor, self._buoyancy, coupling_force, self._held_gravity, total_force)
        drag = kernels.apply_gas_force(
            self.mapping.stencil, bed, self.mapping.read(rows, 8), self.beta, force, self._dt, self._prediction
        )
        if self.forces:
            drag += self.forces.hand_over(
                self.mapping, self.mapping.read(self._gas_rows, 4), coupling_force, total_force
            )
        return drag

    def deposit_heat(self, particles: Particles, heat: tuple[np.ndarray, np.ndarray], dt: float) -> None:
        """The heat of the next gas step, averaged over `dt` [s], by the gas that the drag has seen; heat: masses (n,)
        [kg] and temperatures (n,) [K] of the particles (collective)."""
        if self._heat:
            self._heat.deposit(particles, heat, (self.mapping, self._layers), self._seen, dt)

    def give_heat(self, temperatures: np.ndarray, heat: tuple[np.ndarray, np.ndarray]) -> float:
        """Give the particles what the gas, of the new `temperatures` (cells,) [K], loses to them in the step: masses
        and temperatures as in `deposit_heat`, which change. Returns the heat [J] (collective)."""
        return self._heat.give(temperatures, heat, (self.mapping, self._layers)) if self._heat else 0.0

    @property
    def negative_heat(self) -> Negative | None:
        """The particle that the heat transfer of the last step takes hardest against its direction, if it does so."""
        return self._heat.negative if self._heat else None

    @property
    def heat_sums(self) -> np.ndarray:
        """Sums (cells, 2) of H [W/K] and H T_p [W] over the particles of each cell, for the next gas step."""
        return self._heat.sums if self._heat else np.zeros((len(self.voidage), 2))

    def read_gas(self, gas: np.ndarray) -> None:
        """Bring velocity and pressure gradient (cells, 6) to the particles' local grid, filtered (collective)."""
        self._state = gas
        self.halo.forward(gas, self._fields[6][: self._layers], "gas")
        self._line_up_gas()

    def _line_up_gas(self) -> None:
        field = self.space.average(*self._cut_fields(6))
        kernels.pack_gas(field.reshape(-1, 6), self._gas_rows[: self._layers].reshape(-1, 8))
        self._read_layers = self._layers

    def _cut_fields(self, components: int) -> tuple[np.ndarray, np.ndarray]:
        """A local field and one to work in, as far up as they hold something."""
        return self._fields[components][: self._layers], self._scratch[components][: self._layers]

    def _count_layers(self) -> int:
        """Lowest layers of the local grid that hold all that particles write, and exact values where they read.

        Filter and diffusion carry what they write up, by a layer a pass and by a margin, and the reflection at the cut
        down by as much what they read; the last layer is the extra one of a local grid.
        """
        return min(self.mapping.layers + self.space.rise + 1, len(self._gas_rows))

    @property
    def gas_input(self) -> tuple[np.ndarray, np.ndarray]:
        """Voidage and sums of the drag of the next gas step."""
        return self.voidage, self.drag_sums

    def find_gas_loss(self, momentum_loss: np.ndarray) -> np.ndarray:
        """Force [N], shape (3,), that this rank's cells lost and the particles are still to get.

        momentum_loss (7,): sums over the cells, after the gas step, of V (K u - S) [N], V alpha grad P [N], V alpha
        [m3].
        """
        loss = momentum_loss[:3] - self._gradient_factor * momentum_loss[3:6]
        loss[2] += self._buoyancy * momentum_loss[6]
        return loss - (self.forces.moved if self.forces else 0.0)

    def _add_up(self, sums: np.ndarray) -> None:
        """Smooth the local field of as many components as `sums` (cells, c) and add it up at the owners of the cells,
        in `sums` (collective)."""
        # The last layer, the extra one, holds nothing that counts: what a higher bed left there.
        self.halo.reverse(self.space.filter_written(*self._cut_fields(sums.shape[1]))[:-1], sums)

    def _make_room(self, count: int) -> None:
        if count > self._room:
            self._room = count + count // 4
            self._beta, self._effectives = np.empty(self._room), np.empty((self._room, 3))

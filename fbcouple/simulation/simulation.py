"""A run in one MPI rank: both solvers, the coupling between them, and the stages of a coupling step (`loop.step`).

A step is a gas step of whole DEM steps. Views of the solvers' arrays are valid until the next step.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TypeVar

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.feeds import has_traffic
from fbcouple.case.schema.sections import Case
from fbcouple.coupling.coupling import Coupling
from fbcouple.coupling.particles import NOBODY, Particles
from fbcouple.errors import CaseError
from fbcouple.geometry.grid import Grid
from fbcouple.results.variables import STAGES
from fbcouple.simulation.conservation import Conservation
from fbcouple.simulation.heat import Heat
from fbcouple.simulation.opening import start_solvers
from fbcouple.simulation.particle_step import ParticleStep
from fbcouple.simulation.soundness import (
    require_closed_ledger,
    require_finite_gas,
    require_forward_heat,
    require_sound_exchange,
)
from fbcouple.simulation.temperatures import set_start_temperatures
from fbcouple.simulation.timers import Timers
from fbcouple.simulation.traffic import Traffic
from fbcouple.solvers.liggghts import Liggghts
from fbcouple.solvers.openfoam.gas import Gas, GasReport

Part = TypeVar("Part")
UNTIL = "--until"
"""Why a run stops that has come as far as it was asked to."""


class Simulation:
    """The solvers of a case and the parts between them; all methods are collective."""

    def __init__(self, case: Case, run: Path, comm: MPI.Comm, end: float, restart: Path | None = None) -> None:
        """Start the solvers on the decks in `run`, the current folder; end [s]: where the run ends; restart: LIGGGHTS'
        restart file in place of the start positions."""
        parts = start_solvers(case, run, comm, end, restart)
        self.case, self.comm, self.clock, self.cells = case, comm, parts.clock, parts.cells
        self._gas, self._liggghts, self._coupling = parts.gas, parts.liggghts, parts.coupling
        self._run, self._accelerated = run, parts.accelerated
        self.conservation, self.timers = Conservation(comm), Timers(STAGES)
        self.traffic: Traffic | None = None
        """Particles that come and go; None where the case has neither feeds nor outlets of particles."""
        if has_traffic(case):
            self.traffic = Traffic(case, run, comm, self.grid, self.liggghts, self._accelerated)
        self._particle_step: ParticleStep | None = None
        if self.is_coupled:
            self._particle_step = ParticleStep(case, comm, self.gas, self.liggghts)
        self.heat: Heat | None = None
        """Temperatures, and the ledger of heat; None where the case has no heat."""
        if case.heat:
            self.heat = Heat(case, comm, self._gas, self._liggghts, self._coupling)
        self.particles: Particles = NOBODY
        """This rank's particles as they are now; valid until the next move."""
        self.gas_report: GasReport | None = None
        """What the last gas step was like."""
        self.dt = self.moved = 0.0
        """The coupling step under way or just taken, and the one in which the particles made its voidage [s]."""
        self.substeps = 0
        """DEM steps of the step under way or just taken."""
        self.stop = ""
        """Why the run has to end before its end, if it has."""
        self.checkpoint: Path | None = None
        """The newest checkpoint that this run has."""

    def initialise(self) -> None:
        """Set LIGGGHTS up and see the particles from the gas: at the start of a run, and at each step at which a
        checkpoint may be written, because a run that goes on from one starts by this."""
        if self.has_particles:
            with self.timers("dem"):
                if self.traffic:
                    self.traffic.prepare(self.clock)
                self.liggghts.advance(0, first=True)
                if self.traffic and self.clock.steps == 0:
                    self.traffic.number_start()
                if self.case.heat and self.clock.steps == 0:
                    set_start_temperatures(self.case, self._run, self.comm, self.liggghts)
            self.look_at_particles()
            self.conservation.count(self.liggghts.count)
        self.map_solids()
        if self.is_coupled:
            if self.clock.steps == 0:
                self.gas.start(self.coupling.voidage)
                self._remember_velocities()
            self.coupling.read_gas(self.gas.state)
            self._derive_fields()
        self.deposit_drag()
        self.deposit_heat()

    @property
    def proceed(self) -> bool:
        """Is there time left, and no reason to stop?"""
        return self.clock.running and not self.stop

    def step_gas(self) -> None:
        """The step that the clock has chosen begins: one PISO step of the gas, under voidage and drag as they are."""
        self.dt, self.substeps = self.clock.dt, self.clock.substeps
        self.moved = self.clock.last_dt or self.dt
        if not self.has_gas:
            return
        with self.timers("wait"):
            self.comm.Barrier()
        with self.timers("cfd"):
            given = self.coupling.gas_input if self.is_coupled else self.gas.clean_input
            self.gas.step(self.dt, *given, moved=self.moved)
            self.gas_report = self.gas.measure()
            if self.heat:
                self.heat.step_gas(self.time, self.gas.voidage)
        require_finite_gas(self.time, self.owned, self.gas)

    def apply_gas_force(self) -> None:
        """What the gas lost by drag and pressure gradient is the particles' impulse over the same step."""
        if not self.is_coupled:
            return
        with self.timers("react"):
            forces = self.liggghts.held_force, self.liggghts.forces
            drag = self.coupling.apply_gas_force(self.particles, self.gas.state, *forces)
            self.conservation.give(self.coupling.find_gas_loss(self.gas.momentum_loss), drag, self.dt)
            self._derive_fields()

    def apply_gas_heat(self) -> None:
        """What heat the gas lost to the particles in the step they have at once."""
        if self.heat:
            with self.timers("react"):
                self.heat.give()

    def move_particles(self) -> None:
        """The particles take the DEM steps of the step under the force of the gas."""
        if not self.has_particles:
            return
        with self.timers("dem"):
            self.liggghts.advance(self.substeps)
        self.look_at_particles()
        with self.timers("wait"):
            self.comm.Barrier()
        with self.timers("react"):
            if self.heat:
                self.heat.close_ledger()
            if self.is_coupled:
                own = self.liggghts
                weight = float(own.weights.sum()) if own.held_gravity else 0.0
                carried = own.carried_mass * self.case.gravity
                self.conservation.receive(own.held_force, self.dt, self._find_momentum, weight, carried)
            else:
                self.conservation.count(self.liggghts.count)

    def choose_step(self) -> None:
        """The step is done; the Courant and Fourier numbers of the gas and the fastest particle choose the next."""
        self.clock.tick()
        if self.gas_report and self.case.gas:
            limits = self.case.gas.max_courant, self.case.gas.max_fourier
            longest = self._particle_step.find_longest() if self._particle_step else math.inf
            self.clock.choose(self.gas_report.courant, self.gas_report.fourier, *limits, longest)

    def exchange_particles(self) -> None:
        """Particles that are in an outlet leave, and those that are due come in."""
        if not self.traffic:
            return
        with self.timers("dem"):
            changed = self.traffic.exchange(self.clock)
        if changed:
            self.look_at_particles()
            self.conservation.count(self.liggghts.count)
        require_closed_ledger(self.time, self.case.monitors, self.traffic.ledger)

    def map_solids(self) -> None:
        """Solids to the cells: the voidage of the next gas step."""
        if self.is_coupled:
            with self.timers("map"):
                self.coupling.map(self.particles)

    def deposit_drag(self) -> None:
        """The drag of every particle, averaged over the next step, to the cells."""
        if self.is_coupled:
            with self.timers("drag"):
                densities = self.heat.densities if self.heat else None
                self.coupling.deposit_drag(self.particles, self.clock.dt, self.clock.last_dt, densities)
                require_sound_exchange(self.time, self.case.monitors, self.owned, self.gas, self.coupling)

    def deposit_heat(self) -> None:
        """The heat that each particle is to get from the gas in the next step, to the cells."""
        if self.heat:
            with self.timers("drag"):
                self.heat.deposit(self.particles, self.clock.dt)
                if self.is_coupled:
                    require_forward_heat(self.time, self.owned, self.gas, self.coupling)

    @property
    def stopped_early(self) -> bool:
        """Has the run to end before its end, other than where it was asked to?"""
        return self.stop not in ("", UNTIL)

    def write_fields(self) -> None:
        """Write the gas as it is into the case folder of OpenFOAM, unless the run stopped early (collective)."""
        if self.has_gas and not self.stopped_early:
            self.gas.write()

    def close(self) -> None:
        """End LIGGGHTS (collective)."""
        if self.has_particles:
            self.liggghts.close()

    def _derive_fields(self) -> None:
        """What lift, viscous force and virtual mass of the next step need of the gas."""
        if self.coupling.forces:
            self.coupling.forces.read(self.gas.derive(self.coupling.forces.fields))

    @property
    def has_gas(self) -> bool:
        """Does OpenFOAM take part?"""
        return self._gas is not None

    @property
    def has_particles(self) -> bool:
        """Does LIGGGHTS take part?"""
        return self._liggghts is not None

    @property
    def is_coupled(self) -> bool:
        """Do both, with an exchange between them?"""
        return self._coupling is not None

    @property
    def gas(self) -> Gas:
        """OpenFOAM in this rank. Raises: CaseError where the case has no [gas]."""
        return _require(self._gas, "[gas]")

    @property
    def liggghts(self) -> Liggghts:
        """LIGGGHTS in this rank. Raises: CaseError where the case has no [particles]."""
        return _require(self._liggghts, "[particles]")

    @property
    def coupling(self) -> Coupling:
        """The exchange in this rank. Raises: CaseError where the case lacks one of both phases."""
        return _require(self._coupling, "[exchange]")

    @property
    def grid(self) -> Grid:
        """The box grid, or the one on which results of a mesh of polyhedra are sampled."""
        return self.cells.grid

    @property
    def owned(self) -> np.ndarray:
        """Numbers of this rank's cells, index triples (n, 3) in a box."""
        return self.cells.owned

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.clock.time

    def look_at_particles(self) -> None:
        """See this rank's particles as they are now, in `particles`."""
        if self.has_particles:
            own = self.liggghts
            last = own.last_velocities if own.remembers else None
            driven = own.drag_only_velocities if self._accelerated else None
            self.particles = Particles(own.positions, own.velocities, own.radii, own.masses, last, driven)

    @property
    def rows_inside(self) -> np.ndarray | slice:
        """Rows of this rank's particles that are in the region, not behind an open wall on their way out."""
        return self.traffic.list_inside(self.liggghts.positions) if self.traffic else slice(None)

    def _remember_velocities(self) -> None:
        """At the start of a run the step before it is one without a force, for whoever asks for velocities of then."""
        for earlier in (self.particles.last_velocities, self.particles.drag_only_velocities):
            if earlier is not None:
                earlier[:] = self.particles.velocities

    def _find_momentum(self) -> float:
        """Sum of m |v| [kg m/s] of this rank's particles."""
        return float(self.particles.masses @ np.linalg.norm(self.particles.velocities, axis=1))


def _require(part: Part | None, section: str) -> Part:
    if part is None:
        raise CaseError([f"the case has no {section}"])
    return part

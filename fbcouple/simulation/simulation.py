"""What takes part in a run: the solvers and the parts between them that this case needs, in one MPI rank."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed import derived
from fbcouple.case.bed.acceleration import choose_acceleration
from fbcouple.case.bed.particle_types import largest_diameter
from fbcouple.case.schema.sections import Case
from fbcouple.coupling.box.halo import Plan, find_patch
from fbcouple.coupling.cells import BoxCells, Cells, MeshCells
from fbcouple.coupling.coupling import Coupling
from fbcouple.coupling.discretisation import BoxSpace, MeshSpace, Space
from fbcouple.coupling.forces import ADDED_MASS
from fbcouple.coupling.particles import NOBODY, Particles
from fbcouple.geometry.grid import Grid
from fbcouple.geometry.polyhedra import Polyhedra
from fbcouple.results.writer import STAGES
from fbcouple.simulation.clock import Cadence, Clock
from fbcouple.simulation.conservation import Conservation
from fbcouple.simulation.tasks.averages import CellSampler, Means, SolidsSampler
from fbcouple.simulation.timers import Timers
from fbcouple.solvers.liggghts import Liggghts
from fbcouple.solvers.openfoam.gas import Gas, GasReport

# Gas velocity [m/s] that the first step of a gas without inflow is chosen for; the Courant number takes over.
_SLOWEST = 1e-3


@dataclass
class Averaging:
    """The means of each phase that is there, and when they take their samples."""

    cadence: Cadence
    solids: Means | None
    gas: Means | None
    sampler: SolidsSampler | CellSampler | None


@dataclass
class Simulation:
    """A run in this rank; a phase that the case does not have is None."""

    case: Case
    comm: MPI.Comm
    clock: Clock
    grid: Grid
    liggghts: Liggghts | None
    gas: Gas | None
    coupling: Coupling | None
    averaging: Averaging | None
    cells: Cells
    """This rank's cells, by which records and results are kept."""
    conservation: Conservation
    timers: Timers
    particles: Particles = NOBODY
    gas_report: GasReport | None = None
    accelerated: bool = False
    """Does the drag of a step know the other forces of the last one?"""
    dt: float = 0.0
    """The coupling step under way or just taken [s]; the next is the clock's."""
    substeps: int = 0
    """Its DEM steps."""
    moved: float = 0.0
    """The step in which the particles made the voidage of this one [s]."""
    stop: str = ""
    """Why the run has to end before its end, if it has."""
    checkpoint: Path | None = None
    """The newest checkpoint that this run has."""

    @property
    def owned(self) -> np.ndarray:
        """Numbers of this rank's cells, index triples (n, 3) in a box."""
        return self.cells.owned

    @property
    def running(self) -> bool:
        """Is there time left, and no reason to stop?"""
        return self.clock.running and not self.stop

    def look_at_particles(self) -> None:
        """See this rank's particles as they are now, in `particles`; valid until the next move."""
        if self.liggghts:
            liggghts = self.liggghts
            last = liggghts.last_velocities if liggghts.remembers else None
            driven = liggghts.driven_velocities if self.accelerated else None
            self.particles = Particles(
                liggghts.positions, liggghts.velocities, liggghts.radii, liggghts.masses, last, driven
            )

    def remember_velocities(self) -> None:
        """At the start of a run the step before it is one without a force, for whoever asks for velocities of then."""
        for earlier in (self.particles.last_velocities, self.particles.driven_velocities):
            if earlier is not None:
                earlier[:] = self.particles.velocities

    def find_momentum(self) -> float:
        """Sum of m |v| [kg m/s] of this rank's particles."""
        return float(self.particles.masses @ np.linalg.norm(self.particles.velocities, axis=1))


def open_simulation(case: Case, run: Path, comm: MPI.Comm, end: float, restart: Path | None = None) -> Simulation:
    """Start the solvers that `case` needs on the decks in `run`, and join them (collective).

    restart: LIGGGHTS' restart file in place of the start positions; OpenFOAM starts from its latest time directory.
    """
    logs = run / "logs"
    gas = liggghts = coupling = None
    if case.gas:
        log = logs / "openfoam.log" if comm.rank == 0 else Path("/dev/null")
        gas = Gas(run / "CFD", log, case.gas.density, case.gas.correctors, comm.rank if comm.size > 1 else None)
    if case.particles:
        virtual_mass = case.exchange is not None and case.exchange.virtual_mass
        liggghts = Liggghts(Path("DEM/in.liggghts"), logs / "liggghts.log", comm, restart, remembers=virtual_mass)
        if virtual_mass and case.gas:
            liggghts.add_inertia(ADDED_MASS * case.gas.density)
    polyhedra = gas.read_polyhedra() if gas and not case.domain.is_plain_box else None
    cells = _open_cells(case, comm, gas, liggghts, polyhedra)
    if gas and liggghts and case.particles:
        reach = largest_diameter(case.particles)
        space: Space
        if polyhedra:
            space = MeshSpace(case, comm, polyhedra, gas.volumes, liggghts.bounds, reach)
        else:
            space = BoxSpace(case, comm, gas.centres, liggghts.bounds, reach)
        coupling = Coupling(case, space)
    averaging = _open_averaging(case, comm, cells, liggghts, coupling)
    conservation, timers = Conservation(comm), Timers(STAGES)
    clock = _start_clock(case, end, _find_smallest(comm, cells))
    sim = Simulation(case, comm, clock, cells.grid, liggghts, gas, coupling, averaging, cells, conservation, timers)
    sim.accelerated = coupling is not None and choose_acceleration(case)[0]
    return sim


def _open_cells(
    case: Case, comm: MPI.Comm, gas: Gas | None, liggghts: Liggghts | None, polyhedra: Polyhedra | None
) -> Cells:
    domain = case.domain
    if polyhedra is not None and gas:
        low = np.min(comm.allgather(polyhedra.points.min(axis=0)), axis=0)
        high = np.max(comm.allgather(polyhedra.points.max(axis=0)), axis=0)
        size, origin = (tuple(corner.tolist()) for corner in (high - low, low))
        return MeshCells(comm, Grid(domain.cells, size, origin=origin), polyhedra, gas.volumes)
    grid = Grid(domain.cells, domain.size, derived.wraps(domain))
    return BoxCells(grid, grid.indices(gas.centres) if gas else _own_cells(grid, liggghts))


def _find_smallest(comm: MPI.Comm, cells: Cells) -> float:
    """Shortest edge [m] of a cell; of a polyhedron the cube root of its volume."""
    if isinstance(cells, BoxCells):
        return float(cells.grid.spacing.min())
    return comm.allreduce(float(cells.volumes.min(initial=math.inf)), MPI.MIN) ** (1.0 / 3.0)


def _start_clock(case: Case, end: float, edge: float) -> Clock:
    """With both phases the first step is one DEM step, and the Courant number takes over from there.

    It knows nothing of a ramp's gas to come: steps are then never longer than the ramp's fastest gas allows.
    """
    dem_step = derived.dem_step(case.contact, case.particles) if case.contact and case.particles else None
    first = min(case.output.record_every, case.averages.every if case.averages else math.inf)
    longest = math.inf
    if case.gas:
        speed = max(derived.open_velocity(case), _SLOWEST)
        room = case.gas.max_courant * edge / speed
        longest = min(room if case.gas.inlet_ramp else math.inf, case.gas.max_step or math.inf)
        first = dem_step or min(room, longest)
    return Clock(end, dem_step, first, longest)


def _own_cells(grid: Grid, liggghts: Liggghts | None) -> np.ndarray:
    """Without gas the cells of the averages belong to the rank whose particles' box holds their centre."""
    assert liggghts is not None
    low, high = liggghts.bounds
    axes = [np.flatnonzero((grid.centres(axis) >= low[axis]) & (grid.centres(axis) < high[axis])) for axis in range(3)]
    return np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)


def _open_averaging(
    case: Case, comm: MPI.Comm, cells: Cells, liggghts: Liggghts | None, coupling: Coupling | None
) -> Averaging | None:
    if case.averages is None:
        return None
    options, window = case.averages, (case.averages.start, case.end_time)
    solids = gas = sampler = None
    if liggghts and case.particles:
        sampler = _open_sampler(comm, cells, liggghts, coupling, largest_diameter(case.particles))
        solids = Means("solids", len(cells.owned), window, options.blocks)
    if case.gas:
        gas = Means("gas", len(cells.owned), window, options.blocks)
    return Averaging(Cadence(options.every, options.start), solids, gas, sampler)


def _open_sampler(
    comm: MPI.Comm, cells: Cells, liggghts: Liggghts, coupling: Coupling | None, reach: float
) -> SolidsSampler | CellSampler:
    if coupling is None:
        low, high = liggghts.bounds
        return SolidsSampler(Plan(comm, find_patch(cells.grid, low, high, reach, 0), cells.owned))
    if isinstance(coupling.space, MeshSpace):
        return CellSampler(coupling.space.mapping, coupling.space.plan, coupling.space.volumes)
    return SolidsSampler(coupling.space.plan)

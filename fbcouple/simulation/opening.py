"""From decks in a run folder to the parts of a simulation: solvers are started and joined."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed import derived
from fbcouple.case.bed.acceleration import choose_acceleration
from fbcouple.case.bed.feeds import find_clearing_time, has_traffic
from fbcouple.case.bed.fluid_step import fourier_step
from fbcouple.case.bed.jets import find_jet_range
from fbcouple.case.bed.outlets import find_longest_step
from fbcouple.case.bed.particle_types import largest_diameter
from fbcouple.case.bed.streams import has_own_condition, list_tables
from fbcouple.case.schema.sections import Case
from fbcouple.coupling.coupling import Coupling
from fbcouple.coupling.discretisation import BoxCells, BoxSpace, Cells, MeshCells, MeshSpace, Space
from fbcouple.coupling.forces import ADDED_MASS
from fbcouple.coupling.polyhedral.bricks import find_grid
from fbcouple.geometry.grid import Grid
from fbcouple.geometry.polyhedra import Polyhedra
from fbcouple.simulation.clock import Clock
from fbcouple.solvers.liggghts import Liggghts
from fbcouple.solvers.openfoam.gas import Gas

# Gas velocity [m/s] that the first step of a gas without inflow is chosen for; the Courant number takes over.
_SLOWEST = 1e-3

_ON_THE_WAY = 0.1
"""Diameters that a particle may move in a DEM step, after which its lists are found to be old."""


class Parts(NamedTuple):
    """What a simulation is made of; None is a part that the case does not need."""

    clock: Clock
    cells: Cells
    gas: Gas | None
    liggghts: Liggghts | None
    coupling: Coupling | None
    accelerated: bool
    """Does the drag of a step know what other forces did in the last one?"""


def start_solvers(case: Case, run: Path, comm: MPI.Comm, end: float, restart: Path | None = None) -> Parts:
    """Start the solvers that `case` needs on the decks in `run`, the current folder, and join them (collective).

    end [s]: where the run ends; restart: LIGGGHTS' restart file in place of the start positions; OpenFOAM starts from
    its latest time directory.
    """
    logs = run / "logs"
    gas = liggghts = coupling = None
    if case.gas:
        log = logs / "openfoam.log" if comm.rank == 0 else Path("/dev/null")
        gas = Gas(run / "CFD", log, case.gas.density, case.gas.correctors, comm.rank if comm.size > 1 else None)
        if restart and has_own_condition(case):
            gas.set_inlet(list_tables(case))
    if case.particles:
        virtual_mass = case.exchange is not None and case.exchange.virtual_mass
        log = logs / "liggghts.log"
        traffic = has_traffic(case)
        liggghts = Liggghts(Path("DEM/in.liggghts"), log, comm, restart, remembers=virtual_mass, identifies=traffic)
        if virtual_mass and case.gas:
            liggghts.add_inertia(ADDED_MASS * case.gas.density)
    polyhedra = gas.read_polyhedra() if gas and not case.domain.is_plain_box else None
    bricks = find_grid(comm, polyhedra, gas.volumes) if gas and polyhedra is not None else None
    cells = _open_cells(case, comm, gas, liggghts, polyhedra, bricks)
    if gas and liggghts and case.particles:
        reach = _find_stray(case)
        space: Space
        if bricks:
            space = BoxSpace(case, comm, gas.centres, liggghts.bounds, reach, (bricks, gas.volumes))
        elif polyhedra is not None:
            space = MeshSpace(case, comm, polyhedra, gas.volumes, liggghts.bounds, reach)
        else:
            space = BoxSpace(case, comm, gas.centres, liggghts.bounds, reach)
        # A deck of the user's own (`--trust`) may have a gravity of its own.
        liggghts.held_gravity = 0.0 if liggghts.has_own_gravity() else case.gravity
        coupling = Coupling(case, space, liggghts.held_gravity)
    clock = _start_clock(case, end, cells.find_shortest_edge(comm))
    accelerated = coupling is not None and choose_acceleration(case)[0]
    return Parts(clock, cells, gas, liggghts, coupling, accelerated)


def _find_stray(case: Case) -> float:
    """How far [m] outside of a rank's box, or of a periodic one, its particles may be: LIGGGHTS hands one over when its
    lists are made anew, after it has moved half the skin at the latest, and the step then."""
    assert case.particles is not None
    diameter = largest_diameter(case.particles)
    skin = derived.neighbour_skin(case.contact, case.particles) if case.contact else 0.0
    return max(diameter, 0.5 * skin + _ON_THE_WAY * diameter)


def _open_cells(
    case: Case,
    comm: MPI.Comm,
    gas: Gas | None,
    liggghts: Liggghts | None,
    polyhedra: Polyhedra | None,
    bricks: Grid | None,
) -> Cells:
    domain = case.domain
    if polyhedra is not None and gas:
        low = np.min(comm.allgather(polyhedra.points.min(axis=0)), axis=0)
        high = np.max(comm.allgather(polyhedra.points.max(axis=0)), axis=0)
        size, origin = (tuple(corner.tolist()) for corner in (high - low, low))
        return MeshCells(comm, Grid(domain.cells, size, origin=origin), polyhedra, gas.volumes, bricks)
    grid = Grid(domain.cells, domain.size, derived.wraps(domain))
    return BoxCells(grid, grid.indices(gas.centres) if gas else _own_cells(grid, liggghts))


def _start_clock(case: Case, end: float, edge: float) -> Clock:
    """With both phases the first step is one DEM step, and the Courant number takes over from there. No particle
    crosses an outlet of particles in a step. Without gas a step is as long as the shortest time between two outputs,
    and no longer than what a feed brings takes to leave its place.

    It knows nothing of a ramp's gas to come: steps are then never longer than the ramp's fastest gas allows.
    """
    dem_step = derived.dem_step(case.contact, case.particles) if case.contact and case.particles else None
    longest = find_longest_step(case)
    first = min(*_list_cadences(case), find_clearing_time(case), longest)
    if case.gas:
        speed = max(*map(abs, find_jet_range(case, None)), _SLOWEST)
        room = case.gas.max_courant * edge / speed
        longest = min(longest, room if derived.has_ramp(case.gas) else math.inf, case.gas.max_step or math.inf)
        first = dem_step or min(room, longest, fourier_step(case))
    return Clock(end, dem_step, first, longest)


def _list_cadences(case: Case) -> list[float]:
    """Times [s] between two outputs of each kind that the case asks for by simulated time."""
    output = case.output
    times = [output.record_every, output.particles_every, output.snapshots_every, *(one.every for one in output.probes)]
    times += [case.averages.every if case.averages else None, case.checkpoint.every]
    return [time for time in times if time is not None]


def _own_cells(grid: Grid, liggghts: Liggghts | None) -> np.ndarray:
    """Without gas the cells of the averages belong to the rank whose particles' box holds their centre."""
    assert liggghts is not None
    low, high = liggghts.bounds
    axes = [np.flatnonzero((grid.centres(axis) >= low[axis]) & (grid.centres(axis) < high[axis])) for axis in range(3)]
    return np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)

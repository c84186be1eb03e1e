"""What coupled steps take of the processor by phase, and what there was to do in them, in one MPI rank."""

from __future__ import annotations

import resource
import statistics
import time
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.bench.measure import TotalWatch, open_run
from fbcouple.case.bed.derived import neighbour_skin
from fbcouple.case.cost.prediction import PHASES
from fbcouple.case.schema.sections import Case
from fbcouple.geometry.overlap import count_contacts
from fbcouple.simulation.loop import step
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.task import Task

UNITS = {"dem": "dem_steps", "cfd": "fluid_steps", "exchange": "fluid_steps"}
"""Steps that a phase is of."""
_PIECES = 6


@dataclass(frozen=True)
class StepCosts:
    """Processor seconds of the slowest rank by phase, and the work that they were for; of a run or a piece of one.

    rebuilds: new lists of neighbours, by the way of the fastest particle; contacts: mean number of pairs that touch;
    phases_left: of means, records and waiting; setting_up: processor seconds before the first step; memory: bytes of
    all ranks; spread: largest over least processor time of a step of the pieces, by phase.
    """

    ranks: int
    particles: int
    cells: int
    seconds: float
    fluid_steps: int
    dem_steps: int
    rebuilds: float
    contacts: float
    phases: dict[str, float]
    phases_left: float
    setting_up: float
    memory: float
    spread: dict[str, float]

    @property
    def contacts_each(self) -> float:
        """Contacts a particle."""
        return self.contacts / self.particles if self.particles else 0.0


def measure_costs(case: Case, comm: MPI.Comm, warm: float, seconds: float) -> dict[str, Any]:
    """`StepCosts` of the steps from `warm` to `warm + seconds` [s] of simulated time (collective)."""
    sim, tasks = open_run(case, comm)
    setting_up = time.process_time()
    while sim.clock.time < warm:
        step(sim, tasks)
    pieces = [_take_piece(sim, tasks, warm + seconds * (n + 1) / _PIECES) for n in range(_PIECES)]
    pieces = [piece for piece in pieces if piece["fluid_steps"]]
    phases = {phase: sum(piece[phase] for piece in pieces) for phase in PHASES}
    found = StepCosts(
        ranks=comm.size,
        particles=comm.allreduce(sim.liggghts.count if sim.has_particles else 0),
        cells=comm.allreduce(len(sim.owned)) if sim.has_gas else 0,
        contacts=statistics.mean(piece["contacts"] for piece in pieces),
        seconds=sum(piece["seconds"] for piece in pieces),
        fluid_steps=round(sum(piece["fluid_steps"] for piece in pieces)),
        dem_steps=round(sum(piece["dem_steps"] for piece in pieces)),
        rebuilds=sum(piece["rebuilds"] for piece in pieces),
        phases=phases,
        phases_left=sum(piece["left"] for piece in pieces),
        setting_up=comm.allreduce(setting_up, MPI.MAX),
        memory=comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0),
        spread={phase: _find_spread(pieces, phase) for phase in UNITS if phases[phase] > 0.0},
    )
    return asdict(found)


def _take_piece(sim: Simulation, tasks: list[Task], end: float) -> dict[str, float]:
    """Steps up to `end` [s], on the clock of the processor (collective)."""
    watch = TotalWatch(time.process_time)
    sim.timers = watch
    begin, steps, substeps, rebuilds, half = sim.clock.time, 0, 0, 0.0, _halve_skin(sim.case)
    contacts = [_count(sim)]
    while sim.clock.time < end:
        step(sim, tasks)
        steps += 1
        substeps += sim.substeps
        rebuilds += min(_find_fastest(sim) * sim.dt / half, sim.substeps) if half else 0.0
    contacts.append(_count(sim))
    watch.restart()
    mine = {phase: sum(watch.total[stage] for stage in stages) for phase, stages in PHASES.items()}
    mine["left"] = sum(watch.total.values()) - sum(mine.values())
    phases = {phase: sim.comm.allreduce(value, MPI.MAX) for phase, value in mine.items()}
    counts = {"fluid_steps": steps, "dem_steps": substeps, "rebuilds": rebuilds, "contacts": statistics.mean(contacts)}
    return phases | counts | {"seconds": sim.clock.time - begin}


def _count(sim: Simulation) -> float:
    """Pairs that touch, over all ranks (collective)."""
    if not sim.has_particles:
        return 0.0
    own = sim.liggghts
    return sim.comm.allreduce(count_contacts(own.ghost_positions(), own.ghost_radii(), own.count))


def _halve_skin(case: Case) -> float:
    """Way [m] of a particle after which the lists of neighbours are made anew."""
    return 0.5 * neighbour_skin(case.contact, case.particles) if case.contact and case.particles else 0.0


def _find_fastest(sim: Simulation) -> float:
    """Speed [m/s] of the fastest particle (collective)."""
    squares = np.einsum("ij,ij->i", sim.liggghts.velocities, sim.liggghts.velocities)
    return sim.comm.allreduce(float(squares.max(initial=0.0)), MPI.MAX) ** 0.5


def _find_spread(pieces: list[dict[str, float]], phase: str) -> float:
    """Largest over least processor time of a step."""
    values = [piece[phase] / piece[UNITS[phase]] for piece in pieces]
    return max(values) / min(values) if min(values) > 0.0 else 1.0

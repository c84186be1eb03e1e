"""Coupled steps on the clock, and then the same steps of each solver alone, in one MPI rank."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.bench.lammps import SETTLE
from fbcouple.case.schema.sections import Case
from fbcouple.results.variables import STAGES
from fbcouple.simulation.loop import start, step
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.task_list import list_tasks
from fbcouple.simulation.tasks.task import Task
from fbcouple.simulation.timers import Timers

_FIRST = 5
"""Steps that are never timed: lists, buffers and compiled code are made in them."""
_BLOCKS = 10
_HELD = 20
"""Steps that LIGGGHTS takes alone: some 10 ms, in which a particle under a held force goes astray by a diameter."""
_REPLAYED = 50
"""Steps, after those on the clock, whose gas input is kept for the gas alone."""


class TotalWatch(Timers):
    """A stopwatch whose totals stand through restarts."""

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        super().__init__(STAGES, clock)
        self.total = dict.fromkeys(STAGES, 0.0)

    def restart(self) -> dict[str, float]:
        """The seconds since the last call, which are added to the totals as well."""
        seconds = super().restart()
        for stage, value in seconds.items():
            self.total[stage] += value
        return seconds


@dataclass(frozen=True)
class Taken:
    """What coupled steps took: wall seconds together, stages of this rank, and each step's length [s] and DEM steps."""

    wall: float
    stages: dict[str, float]
    steps: list[tuple[float, int]]


def open_run(case: Case, comm: MPI.Comm, warm: float = 0.0) -> tuple[Simulation, list[Task]]:
    """Open the run in the current folder, and take it through its first steps and through `warm` [s] (collective)."""
    sim = Simulation(case, Path("."), comm, 1e9)
    _, tasks = list_tasks(sim, Path("."), Path("case.toml").read_text(encoding="utf-8-sig"))
    sim.initialise()
    start(sim, tasks)
    for _ in range(_FIRST):
        step(sim, tasks)
    while sim.clock.time < warm:
        step(sim, tasks)
    return sim, tasks


def time_coupled(sim: Simulation, tasks: list[Task], steps: int) -> Taken:
    """Take coupled steps on the clock (collective)."""
    watch = TotalWatch()
    sim.timers = watch
    taken = []

    def run() -> None:
        for _ in range(steps):
            step(sim, tasks)
            taken.append((sim.dt, sim.substeps))

    wall = _clock(sim.comm, run)
    watch.restart()
    return Taken(wall, dict(watch.total), taken)


def time_coupled_for(sim: Simulation, tasks: list[Task], seconds: float) -> Taken:
    """Take coupled steps on the clock until `seconds` of wall time are over, whatever a step costs as the bed begins to
    move (collective)."""
    parts = [time_coupled(sim, tasks, _FIRST)]
    while sim.comm.bcast(sum(part.wall for part in parts) < seconds):
        parts.append(time_coupled(sim, tasks, _FIRST))
    return Taken(
        sum(part.wall for part in parts),
        {stage: sum(part.stages[stage] for part in parts) for stage in STAGES},
        [taken for part in parts for taken in part.steps],
    )


def time_dem(sim: Simulation, steps: list[tuple[float, int]]) -> tuple[float, float]:
    """Wall seconds, of all ranks together and of this one, of LIGGGHTS alone on the same particles and steps.

    What the gas does to a particle stays as it is, which takes the bed apart in time: only the first steps are taken,
    and count for all by their DEM steps (collective).
    """
    liggghts, first = sim.liggghts, steps[:_HELD]

    def run() -> None:
        for _, substeps in first:
            liggghts.advance(substeps)

    share = sum(substeps for _, substeps in first) / sum(substeps for _, substeps in steps)
    wall, own = _clock_own(sim.comm, run)
    return wall / share, own / share


def time_gas(sim: Simulation, steps: list[tuple[float, int]], kept: list[list[np.ndarray]]) -> tuple[float, float]:
    """The same of the gas solver alone on the same mesh and steps, with the voidage and drag of the steps after them,
    `kept`, there and back again: a bed that moves, for a bed at rest takes fewer iterations."""
    gas = sim.gas
    there_and_back = cycle([*reversed(kept), *kept] or [list(gas.clean_input)])

    def run() -> None:
        for (dt, _), given in zip(steps, there_and_back, strict=False):
            gas.step(dt, *given)
            gas.measure()

    return _clock_own(sim.comm, run)


def _clock(comm: MPI.Comm, run: Callable[[], None]) -> float:
    return _clock_own(comm, run)[0]


def _clock_own(comm: MPI.Comm, run: Callable[[], None]) -> tuple[float, float]:
    """Wall seconds until all ranks are through, of the one that began first, and until this one is."""
    comm.Barrier()
    begin = time.perf_counter()
    run()
    own = time.perf_counter() - begin
    comm.Barrier()
    return comm.allreduce(time.perf_counter() - begin, MPI.MAX), own


def measure_overhead(case: Case, comm: MPI.Comm, warm: float, seconds: float, steps: int = 0) -> dict[str, Any]:
    """`steps` coupled steps after `warm` [s] of simulated time, or those of about `seconds` of wall time, and the
    floors of the same steps; rows a rank and their totals, on every rank (collective)."""
    sim, tasks = open_run(case, comm, warm)
    coupled = time_coupled(sim, tasks, steps) if steps else time_coupled_for(sim, tasks, seconds)
    kept: list[list[np.ndarray]] = []
    if sim.is_coupled:
        for _ in range(_REPLAYED):
            step(sim, tasks)
            kept.append([field.copy() for field in sim.coupling.gas_input])
    own: dict[str, Any] = {"rank": comm.rank, "particles": sim.liggghts.count if sim.has_particles else 0}
    own |= {"cells": len(sim.owned)} | coupled.stages
    floors = 0.0
    if sim.has_particles:
        wall, own["dem alone"] = time_dem(sim, coupled.steps)
        floors += wall
    if sim.has_gas:
        wall, own["cfd alone"] = time_gas(sim, coupled.steps, kept)
        floors += wall
    rows = comm.allgather(own)
    solvers = sum(max(row[stage] for row in rows) for stage in ("dem", "cfd"))
    total = {
        "ranks": comm.size,
        "steps": len(coupled.steps),
        "simulated_seconds": sum(dt for dt, _ in coupled.steps),
        "wall_seconds": coupled.wall,
        "floor_seconds": floors,
        "wall_over_floors": coupled.wall / floors,
        "not_in_a_solver": 1.0 - solvers / coupled.wall,
    }
    return {"ranks": rows, "total": total}


def measure_peer(case: Case, comm: MPI.Comm, warm: float, steps: int) -> dict[str, Any]:
    """Wall seconds of a coupled step after `warm` [s] of simulated time, the mean of `steps`, and after that of as many
    DEM steps of LIGGGHTS without the gas. Place and velocity of the particles at the start of each are left in
    bed.npy and alone.npy (collective)."""
    sim, tasks = open_run(case, comm, warm)
    _save_bed(sim, "bed.npy")
    taken = time_coupled(sim, tasks, steps)
    span = sum(dt for dt, _ in taken.steps)
    substeps = sum(count for _, count in taken.steps)
    liggghts = sim.liggghts
    liggghts.held_force[:] = 0.0
    liggghts.held_force[:, 2] = -liggghts.weights
    _save_bed(sim, "alone.npy")
    liggghts.advance(SETTLE, first=True)
    return {
        "step": span / steps,
        "substeps": substeps / steps,
        "particles": sim.conservation.particles,
        "seconds": taken.wall / steps,
        "alone": {"steps": substeps, "seconds": _clock(comm, lambda: liggghts.advance(substeps))},
    }


def _save_bed(sim: Simulation, file: str) -> None:
    """Place [m] and velocity [m/s] of all particles, (n, 6), to `file` (collective)."""
    rows = sim.comm.gather(np.hstack([sim.particles.positions, sim.particles.velocities]))
    if rows is not None:
        np.save(file, np.concatenate(rows))


def measure_dem(case: Case, comm: MPI.Comm, warm: float, steps: int) -> dict[str, Any]:
    """Wall seconds of the slowest rank in LIGGGHTS a simulated second, after `warm` [s] of it: the mean of `steps`
    coupled steps and the cheapest tenth of them (collective)."""
    sim, tasks = open_run(case, comm, warm)
    blocks = []
    for _ in range(_BLOCKS):
        taken = time_coupled(sim, tasks, max(1, steps // _BLOCKS))
        span = sum(dt for dt, _ in taken.steps)
        blocks.append(comm.allreduce(taken.stages["dem"], MPI.MAX) / span)
    return {"seconds_per_second": float(np.mean(blocks)), "cheapest": min(blocks)}


def measure_steps(case: Case, comm: MPI.Comm, steps: int, warm: float = 0.0) -> dict[str, Any]:
    """Wall seconds of a coupled step after `warm` [s] of simulated time, the mean of `steps` (collective)."""
    sim, tasks = open_run(case, comm, warm)
    taken = time_coupled(sim, tasks, steps)
    return {
        "step": sum(dt for dt, _ in taken.steps) / steps,
        "ranks": comm.size,
        "seconds": taken.wall / steps,
        "particles": comm.allreduce(sim.liggghts.count if sim.has_particles else 0),
        "cells": comm.allreduce(len(sim.owned)),
        "substeps": sim.substeps,
    }

"""History rows, the checks of every step, and results.nc, written by rank 0."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed.particle_types import mean_density, solids_volume
from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.speeds import SETTLED
from fbcouple.case.schema.sections import Case
from fbcouple.errors import SolverError
from fbcouple.paths import FRAMES
from fbcouple.results.writer import append_line, read_log, write_results
from fbcouple.run_folder.checkpoint import word_newest
from fbcouple.simulation.clock import Cadence
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.averages import Means
from fbcouple.simulation.tasks.diagnostics import find_weight, measure_dem, measure_height, measure_voidage
from fbcouple.simulation.tasks.frames import Frames, look_at
from fbcouple.simulation.tasks.gas_continuity import HeightFlux
from fbcouple.simulation.tasks.inlet_flow import Inflow
from fbcouple.simulation.tasks.monitors import (
    JUDGED_ONLY,
    LostParticles,
    find_breaches,
    judge,
    require_finite,
    require_inside,
)
from fbcouple.simulation.tasks.outlet import Outlet
from fbcouple.simulation.tasks.snapshots import Snapshots

# What is kept from row to row.
_NUMBERS = (
    "_momentum_error",
    "_mass_error",
    "_inflow_error",
    "_courant",
    "_elapsed",
    "_pressure_time",
    "_support_time",
    "_displaced_wrongly",
)


class Recorder:
    """Observes every step; a row when one is due, results.nc by wall time and at the end."""

    def __init__(self, sim: Simulation, run: Path, case_text: str, made_with: dict[str, str] | None = None) -> None:
        """`made_with`: what results.nc says of the programs that the run is made with."""
        self._run, self._made_with = run, made_with or {}
        self._case_text = case_text
        self._rows: list[dict[str, Any]] = []
        self._cadence = Cadence(sim.case.output.record_every)
        self._momentum_error = self._mass_error = self._inflow_error = self._courant = 0.0
        self._elapsed = self._pressure_time = self._support_time = self._displaced_wrongly = 0.0
        self._lost = LostParticles(sim)
        self._flux, self._inflow, self._outlet = HeightFlux(), Inflow(sim, run), Outlet(sim, run)
        self._inspected: tuple[int, dict[str, Any]] = (-1, {})
        self._begin = self._saved = time.monotonic()
        self._busy_begin, self._busy_earlier = time.process_time(), 0.0
        every = sim.case.output.snapshots_every
        self._snapshots = Snapshots(sim.comm, sim.grid, sim.owned, every) if every else None
        between = sim.case.output.particles_every
        self._frames = Frames(sim.comm, sim.grid, sim.owned, run / FRAMES, between) if between else None
        self._earlier = 0.0
        self._log = (run / "logs/run.jsonl").open("a", encoding="utf-8") if sim.comm.rank == 0 else None

    def observe(self, sim: Simulation) -> None:
        """Check the step that was taken; record it if a row is due, and save if it is time (collective)."""
        self._check(sim)
        if self._snapshots and sim.coupling:
            with sim.timers("record"):
                self._snapshots.take(sim.coupling.voidage, sim.clock.time)
        if self._frames and self._frames.cadence.due(sim.clock.time):
            with sim.timers("record"), self._writing(FRAMES):
                self._frames.write(sim.clock.time, *look_at(sim))
        if self._cadence.due(sim.clock.time) or not sim.clock.running:
            self._record(sim)
        if self._looks_next(sim):
            self._flux.prepare(sim)

    def inspect(self, sim: Simulation) -> dict[str, Any]:
        """Hold the state as it is against its limits; returns what was measured for it (collective).

        Raises DivergedError with the reason and the place.
        """
        if self._inspected[0] == sim.clock.steps:
            return self._inspected[1]
        numbers: dict[str, Any] = {}
        require_finite(sim)
        if sim.liggghts:
            require_inside(sim)
            numbers |= measure_dem(sim) | measure_height(sim) | self._outlet.measure(sim)
        if sim.coupling:
            numbers |= measure_voidage(sim)
        if sim.gas:
            numbers |= self._flux.measure(sim) | self._inflow.measure_outlet(sim)
        judge(sim, numbers)
        self._inspected = sim.clock.steps, numbers
        if sim.liggghts:
            self._lost.take(sim)
        return numbers

    def _looks_next(self, sim: Simulation) -> bool:
        """Will the step to come be recorded, or be a moment for a checkpoint?"""
        clock = sim.clock
        is_moment = (clock.steps + 1) % sim.case.checkpoint.moment_steps == 0
        return is_moment or self._cadence.is_due(clock.time + clock.dt)

    def _record(self, sim: Simulation) -> None:
        with sim.timers("record"):
            row = self._measure(sim)
        row["wall"] = self._share_walls(sim)
        self._rows.append(row)
        if self._log:
            with self._writing("logs/run.jsonl"):
                append_line(self._log, row)
        late = time.monotonic() - self._saved > sim.case.output.save_every
        if sim.comm.bcast(late):
            self.save(sim)

    def _check(self, sim: Simulation) -> None:
        """Keep the extremes since the last row; raise DivergedError if a number of the step breaks its limit."""
        state, conservation = sim.gas_report, sim.conservation
        numbers: dict[str, Any] = {}
        if state and sim.case.gas:
            numbers = self._inflow.judge(sim.case.gas, state, sim.clock.time)
            numbers["courant_ratio"] = state.courant / sim.case.gas.max_courant
            self._inflow_error = max(self._inflow_error, numbers["inflow_error"])
            self._courant = max(self._courant, state.courant)
            self._mass_error = max(self._mass_error, self._inflow.find_loss(state, sim.dt))
            self._elapsed += sim.dt
            self._pressure_time += state.inlet_pressure * sim.dt
            self._support_time += conservation.support * sim.dt
            self._displaced_wrongly += state.displaced_wrongly
        self._momentum_error = max(self._momentum_error, conservation.momentum_error)
        self._lost.require_all(sim)
        if sim.coupling:
            numbers |= {"momentum_error": conservation.momentum_error, "substeps": sim.substeps}
        if find_breaches(sim, numbers):
            self.inspect(sim)  # what is wrong with the state says more than what came of it
            judge(sim, numbers)

    def _measure(self, sim: Simulation) -> dict[str, Any]:
        row: dict[str, Any] = {"time": sim.clock.time, "steps": sim.clock.steps, "substeps": sim.substeps}
        numbers = self.inspect(sim)
        row |= {name: value for name, value in numbers.items() if name not in JUDGED_ONLY}
        if sim.gas:
            row.setdefault("gas_flux_error", float("nan"))
            mean = self._pressure_time / self._elapsed if self._elapsed else float("nan")
            row |= {"pressure_drop": mean, "gas_mass_error": self._mass_error, "max_courant": self._courant}
            row["gas_inflow_error"] = self._inflow_error
        if sim.coupling:
            row["momentum_error"] = self._momentum_error
            row["displaced_gas_error"] = self._displaced_wrongly / row["solids_volume"]
            row["gas_support"] = self._support_time / self._elapsed / find_weight(sim) if self._elapsed else 0.0
        self._momentum_error = self._mass_error = self._inflow_error = self._courant = 0.0
        self._elapsed = self._pressure_time = self._support_time = self._displaced_wrongly = 0.0
        return row

    def _share_walls(self, sim: Simulation) -> dict[str, float]:
        mine = sim.timers.restart()
        return {stage: sim.comm.allreduce(seconds, max) for stage, seconds in mine.items()}

    def save(self, sim: Simulation) -> None:
        """Write results.nc (collective)."""
        means: dict[str, np.ndarray] = {}
        if sim.averaging:
            for phase in (sim.averaging.solids, sim.averaging.gas):
                if phase and phase.samples:
                    means |= _gather(sim, phase)
        about = sim.cells.describe(sim.comm)
        if sim.comm.rank == 0:
            taken = self._snapshots.taken if self._snapshots else ()
            place = self._run / "results.nc"
            with self._writing("results.nc"):
                write_results(place, sim.grid, means, self._rows, self._describe(sim), taken, **about)
        self._saved = time.monotonic()

    @contextmanager
    def _writing(self, name: str) -> Iterator[None]:
        """Say what could not be written, and what the run goes on from."""
        try:
            yield
        except OSError as error:
            raise SolverError(f"{name} cannot be written: {error}; {word_newest(self._run)}") from error

    def _count_core_seconds(self, sim: Simulation) -> float:
        return self._earlier + (time.monotonic() - self._begin) * sim.comm.size

    def _count_cpu_seconds(self, sim: Simulation) -> float:
        """Processor time of rank 0, times the ranks: what core-seconds are where the machine does nothing else."""
        return self._busy_earlier + (time.process_time() - self._busy_begin) * sim.comm.size

    def save_state(self, sim: Simulation, folder: Path) -> list[Path]:
        """Write what `load_state` needs into the checkpoint `folder`, on rank 0; returns the files' names."""
        numbers = {name: getattr(self, name) for name in _NUMBERS}
        numbers |= {"core_seconds": self._count_core_seconds(sim), "next": self._cadence.next}
        numbers["cpu_seconds"] = self._count_cpu_seconds(sim)
        numbers["flux"] = self._flux.save()
        with (folder / "history.jsonl").open("w", encoding="utf-8") as file:
            for row in self._rows:
                append_line(file, row)
        if self._snapshots:
            numbers["next_snapshot"] = self._snapshots.cadence.next
            self._snapshots.save(folder / "snapshots.npz")
        if self._frames:
            numbers |= {"next_frame": self._frames.cadence.next, "frames": self._frames.count}
        (folder / "recorder.json").write_text(json.dumps(numbers), encoding="utf-8")
        files = [Path("history.jsonl"), Path("recorder.json")]
        return [*files, Path("snapshots.npz")] if self._snapshots else files

    def load_state(self, folder: Path) -> None:
        """Go on from the checkpoint in `folder`."""
        numbers = json.loads((folder / "recorder.json").read_text(encoding="utf-8"))
        for name in _NUMBERS:
            setattr(self, name, numbers[name])
        self._earlier, self._cadence.next = numbers["core_seconds"], numbers["next"]
        self._busy_earlier = numbers.get("cpu_seconds", math.nan)
        if "flux" in numbers:
            self._flux.load(numbers["flux"])
        self._rows = read_log(folder / "history.jsonl")
        if self._snapshots:
            self._snapshots.cadence.next = numbers["next_snapshot"]
            self._snapshots.load(folder / "snapshots.npz")
        if self._frames:
            self._frames.cadence.next = numbers["next_frame"]
            self._frames.cut(numbers["frames"])

    def _describe(self, sim: Simulation) -> dict[str, Any]:
        options, now, bed = sim.case.averages, sim.clock.time, sim.case.particles
        return {
            **self._made_with,
            "title": sim.case.title,
            "case": self._case_text,
            "averaging_start": options.start if options else float("nan"),
            "averaging_end": now,
            "core_seconds": self._count_core_seconds(sim),
            "cpu_seconds": self._count_cpu_seconds(sim),
            "ranks": sim.comm.size,
            **(_describe_bed(sim.case, self._run) if bed else {}),
            "complete": int(now >= sim.case.end_time * (1 - 1e-9)),
        }


def _describe_bed(case: Case, run: Path) -> dict[str, float]:
    """Mass [kg], volume [m3] and, at rest, mean horizontal cross-section [m2] of the bed."""
    assert case.particles is not None
    solids = solids_volume(case.particles)
    section = solids / SETTLED / find_region(case, run).find_level(solids / SETTLED)
    return {"solids_mass": mean_density(case.particles) * solids, "solids_volume": solids, "bed_section": section}


def _gather(sim: Simulation, means: Means) -> dict[str, np.ndarray]:
    """Means and standard errors of all ranks on rank 0, as the cells arrange them."""
    collected = means.collect(final=sim.clock.time >= sim.case.end_time * (1 - 1e-9))
    parts = sim.comm.gather((sim.owned, collected))
    if parts is None:
        return {}
    return {
        name + suffix: sim.cells.arrange([(owned, values[name][which]) for owned, values in parts])
        for name in collected
        for which, suffix in enumerate(("", "_stderr"))
    }

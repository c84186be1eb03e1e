"""results.nc while the run goes on, by wall time, and at its end."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.bed.drag_balance import tabulate_onset
from fbcouple.case.bed.particle_types import mean_density, solids_volume
from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.speeds import SETTLED
from fbcouple.results.writer import Extras, MeshTable, write_results
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.averages import Averages
from fbcouple.simulation.tasks.history import History
from fbcouple.simulation.tasks.ledger import LedgerKeeper
from fbcouple.simulation.tasks.probes import Probes
from fbcouple.simulation.tasks.snapshots import Snapshots
from fbcouple.simulation.tasks.task import Saved, Task
from fbcouple.simulation.tasks.writing import writing

_NAME = "results.nc"


class ResultsFile(Task):
    """Writes what the other tasks have: history, means and snapshots, with the case and what the run cost."""

    def __init__(
        self,
        run: Path,
        case_text: str,
        history: History,
        averages: Averages | None,
        snapshots: Snapshots | None,
        made_with: dict[str, Any],
        ledger: LedgerKeeper | None = None,
        probes: Probes | None = None,
    ) -> None:
        """`made_with`: what the file says of the programs that the run is made with."""
        self._run, self._case_text, self._made_with = run, case_text, made_with
        self._history, self._averages, self._snapshots, self._ledger = history, averages, snapshots, ledger
        self._probes = probes
        self._begin = self._saved = time.monotonic()
        self._busy_begin = time.process_time()
        self._earlier = {"core_seconds": 0.0, "cpu_seconds": 0.0}
        self._onset: np.ndarray | None = None

    def after_step(self, sim: Simulation) -> None:
        """With a row of the history: write if the last writing is too long ago (collective)."""
        if self._history.recorded_at != sim.clock.steps:
            return
        late = time.monotonic() - self._saved > sim.case.output.save_every
        if sim.comm.bcast(late):
            self._write(sim)

    def start(self, sim: Simulation) -> None:
        """The same of the row of the start (collective)."""
        self.after_step(sim)

    def finish(self, sim: Simulation) -> None:
        """Write, whatever the time (collective)."""
        self._write(sim)

    def save(self, sim: Simulation, folder: Path) -> Saved:
        """What the run has cost so far."""
        return Saved(self._count_costs(sim))

    def load(self, sim: Simulation, saved: Saved, folder: Path) -> None:
        """Go on from `saved`."""
        self._earlier = {name: saved.numbers[name] for name in self._earlier}

    def _write(self, sim: Simulation) -> None:
        means = self._averages.collect(sim) if self._averages else {}
        blocks = self._averages.collect_blocks(sim) if self._averages else {}
        about, bed = sim.cells.describe(sim.comm), _describe_bed(sim, self._run)
        if sim.comm.rank == 0:
            extras = Extras(
                self._snapshots.taken if self._snapshots else (),
                self._ledger.exits if self._ledger else {},
                self._probes.records if self._probes else (),
                self._find_onset(sim),
                blocks,
            )
            mesh, attributes = MeshTable(**about) if about else None, self._describe(sim) | bed
            with writing(self._run, _NAME):
                write_results(self._run / _NAME, sim.grid, means, self._history.rows, attributes, extras, mesh)
        self._saved = time.monotonic()

    def _find_onset(self, sim: Simulation) -> np.ndarray:
        """What a ramp of the gas is held against, found once."""
        if self._onset is None:
            self._onset = tabulate_onset(sim.case, sim.coupling.law) if sim.is_coupled else np.empty((0, 2))
        return self._onset

    def _count_costs(self, sim: Simulation) -> dict[str, float]:
        """Wall time times the ranks, and processor time of rank 0 times the ranks: what core-seconds are where the
        machine does nothing else."""
        spent = {
            "core_seconds": time.monotonic() - self._begin,
            "cpu_seconds": time.process_time() - self._busy_begin,
        }
        return {name: self._earlier[name] + seconds * sim.comm.size for name, seconds in spent.items()}

    def _describe(self, sim: Simulation) -> dict[str, Any]:
        means = self._averages
        sure, start_up = (means.until_sure, means.start_up) if means else (None, None)
        return {
            **self._made_with,
            "title": sim.case.title,
            "case": self._case_text,
            "averaging_start": means.begin if means else float("nan"),
            "averaging_end": sim.time,
            "averaging_samples": self._averages.samples if self._averages else 0,
            **self._count_costs(sim),
            "ranks": sim.comm.size,
            "complete": int(not sim.clock.running),
            **(start_up.describe() if start_up else {}),
            **(sure.describe(sim) if sure else {}),
        }


def _describe_bed(sim: Simulation, run: Path) -> dict[str, float]:
    """Mass [kg], volume [m3] and, at rest, mean horizontal cross-section [m2] of the bed, as it is now where particles
    come and go (collective)."""
    case = sim.case
    if case.particles is None:
        return {}
    solids, region = solids_volume(case.particles), find_region(case, run)
    mass = mean_density(case.particles) * solids
    if sim.traffic:
        own = sim.liggghts
        held = np.array([own.own_masses.sum(), (4.0 / 3.0 * np.pi * own.radii**3).sum()])
        mass, solids = (float(total) for total in sim.comm.allreduce(held))
    section = solids / SETTLED / region.find_level(solids / SETTLED) if solids else region.section
    return {"solids_mass": mass, "solids_volume": solids, "bed_section": section}

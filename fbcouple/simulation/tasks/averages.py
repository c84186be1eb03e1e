"""Time means over the averaging window: a sample of both phases in each cell, when one is due."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.case.schema.output import AUTO, find_first_sample
from fbcouple.case.schema.output import Averages as Options
from fbcouple.results.block_means import COLUMNS, lay_out_blocks
from fbcouple.simulation.clock import ALMOST, Cadence
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.growing_means import GrowingMeans
from fbcouple.simulation.tasks.means import Means
from fbcouple.simulation.tasks.mirror import MirrorImages
from fbcouple.simulation.tasks.samplers import (
    CellSampler,
    SolidsSampler,
    open_sampler,
    sample_gas,
    sample_heat,
    sample_solids,
)
from fbcouple.simulation.tasks.start_up import StartUp
from fbcouple.simulation.tasks.task import Saved, Task
from fbcouple.simulation.tasks.until_sure import UntilSure


class Averages(Task):
    """The means of each phase that the case has."""

    def __init__(self, sim: Simulation, options: Options) -> None:
        """(collective)"""
        self._given = find_first_sample(options)
        self._cadence = Cadence(options.every, self._given)
        self._phases: dict[str, Means | GrowingMeans] = {}
        self._sampler: SolidsSampler | CellSampler | None = None
        self._images = MirrorImages(sim.comm, sim.grid.cells, sim.owned, options.mirror) if options.mirror else None
        self._find_depth_mean: Callable[[np.ndarray], np.ndarray | None] | None = None
        self.until_sure: UntilSure | None = None
        """What ends the run when its means are sure enough; None where the case does not ask for it."""
        self.start_up: StartUp | None = None
        """What finds where the start-up ends; None where the case says when the averages start."""
        if sim.has_particles:
            self._sampler = open_sampler(sim)
            self._phases["solids"] = _open_means("solids", sim, options)
        if sim.has_gas:
            self._phases["gas"] = _open_means("gas", sim, options)
        if sim.heat:
            present = {"solids_heat": sim.has_particles, "gas_heat": sim.has_gas}
            self._phases |= {phase: _open_means(phase, sim, options) for phase, there in present.items() if there}
        if options.start == AUTO:
            self.start_up = StartUp(sim, self._phases)
        if options.until_error is not None:
            self.until_sure = UntilSure(sim, options, self._phases, self.start_up)

    @property
    def begin(self) -> float:
        """Where the window begins [s]; nan before the first sample of a run that finds its start-up itself."""
        return self.start_up.begin if self.start_up else self._given

    @property
    def samples(self) -> int:
        """Samples taken so far."""
        return max((means.samples for means in self._phases.values()), default=0)

    def after_step(self, sim: Simulation) -> None:
        """Take a sample if one is due; the run ends if its means are sure enough by it (collective)."""
        time = sim.clock.time
        if not self._cadence.due(time):
            return
        with sim.timers("average"):
            if self._sampler:
                self._add("solids", sample_solids(self._sampler, sim), time)
            if sim.has_gas:
                self._add("gas", sample_gas(sim.gas.voidage, sim.gas.velocity, sim.gas.pressure), time)
            if sim.heat:
                self._sample_heat(sim, time)
            if self.start_up:
                self.start_up.judge(sim)
            if self.until_sure:
                self.until_sure.judge(sim)

    def _sample_heat(self, sim: Simulation, time: float) -> None:
        if self._sampler:
            self._add("solids_heat", sample_heat(self._sampler, sim), time)
        if sim.heat and sim.heat.gas:
            voidage = sim.gas.voidage
            self._add("gas_heat", np.column_stack([voidage, voidage * sim.heat.gas.temperatures]), time)

    def _add(self, phase: str, rows: np.ndarray, time: float) -> None:
        self._phases[phase].add(self._images.average(phase, rows) if self._images else rows, time)

    def collect(self, sim: Simulation) -> dict[str, np.ndarray]:
        """Name -> mean and, with `_stderr` behind it, its standard error in the cells of all ranks, on rank 0
        (collective)."""
        found: dict[str, np.ndarray] = {}
        for means in self._phases.values():
            if means.samples:
                found |= _gather(sim, means)
        return found

    def collect_blocks(self, sim: Simulation) -> dict[str, Any]:
        """Variables of results.nc: the solids in each block of the window, depth means, on rank 0 (collective)."""
        solids = self._phases.get("solids")
        if solids is None or not solids.samples:
            return {}
        find = self._find_depth_mean = self._find_depth_mean or sim.cells.open_depth_mean(sim.comm).find
        blocks = list(solids.split_window())
        rows = [[find(column) for column in block.rows.T[:COLUMNS]] for block in blocks]
        if sim.comm.rank:
            return {}
        starts, samples = [block.start for block in blocks], [block.samples for block in blocks]
        return lay_out_blocks(starts, samples, map(np.array, rows))

    def save(self, sim: Simulation, folder: Path) -> Saved:
        """Counts, and sums of this rank's cells."""
        saved = Saved({"next": self._cadence.next})
        if self.start_up:
            saved.numbers["start_up"] = self.start_up.save()
        if self.until_sure:
            saved.numbers["until_sure"] = self.until_sure.save()
        for phase, means in self._phases.items():
            saved.numbers[phase], sums = means.save()
            saved.cells |= {f"{phase}.{name}": rows for name, rows in sums.items()}
        return saved

    def load(self, sim: Simulation, saved: Saved, folder: Path) -> None:
        """Go on from `saved`."""
        self._cadence.next = saved.numbers["next"]
        for phase, means in self._phases.items():
            own = {name.partition(".")[2]: rows for name, rows in saved.cells.items() if name.startswith(f"{phase}.")}
            means.load(saved.numbers[phase], own)
        if self.start_up:
            self.start_up.load(saved.numbers["start_up"])
        if self.until_sure:
            self.until_sure.load(sim, saved.numbers["until_sure"])


def _open_means(phase: str, sim: Simulation, options: Options) -> Means | GrowingMeans:
    """Blocks that grow where the window is open; twice as many where its begin is, for half of them may be left out."""
    cells = len(sim.owned)
    if options.start == AUTO:
        return GrowingMeans(phase, cells, 2 * options.blocks)
    if options.until_error is not None:
        return GrowingMeans(phase, cells, options.blocks)
    return Means(phase, cells, (find_first_sample(options), sim.case.end_time), options.blocks)


def _gather(sim: Simulation, means: Means | GrowingMeans) -> dict[str, np.ndarray]:
    collected = means.collect(sim.clock.time >= sim.case.end_time * ALMOST, sim.comm.allreduce)
    parts = sim.comm.gather((sim.owned, collected))
    if parts is None:
        return {}
    return {
        name + suffix: sim.cells.arrange([(owned, values[name][which]) for owned, values in parts])
        for name in collected
        for which, suffix in enumerate(("", "_stderr"))
    }

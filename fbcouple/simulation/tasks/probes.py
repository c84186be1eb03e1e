"""Probes: fields at points and on lines, sampled at their own cadence, a row a sample in RUN/probes."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.probes import list_points
from fbcouple.case.schema.probes import Probe
from fbcouple.errors import SolverError
from fbcouple.paths import PROBES
from fbcouple.results.probes import OF_HEAT, OF_SOLIDS, ProbeSet, Rows, count_columns, count_components
from fbcouple.simulation.clock import Cadence
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.means import QUANTITIES
from fbcouple.simulation.tasks.samplers import (
    CellSampler,
    SolidsSampler,
    open_sampler,
    sample_gas,
    sample_heat,
    sample_solids,
)
from fbcouple.simulation.tasks.task import Saved, Task
from fbcouple.simulation.tasks.writing import writing

Values = Callable[[str], np.ndarray]
"""Name of a quantity -> its values (n, components) in the cells of this rank's points."""


@dataclass
class _Set:
    """A set of probes: which of its points (k,) this rank has, the rows (k,) of their cells, and their offsets in these
    cells, (k, 3) [m] from the centre."""

    probe: Probe
    record: ProbeSet
    cadence: Cadence
    mine: np.ndarray
    cells: np.ndarray
    offsets: np.ndarray

    @property
    def needs_solids(self) -> bool:
        return any(quantity in OF_SOLIDS and quantity not in OF_HEAT for quantity in self.probe.quantities)

    @property
    def needs_solids_heat(self) -> bool:
        return "solids_temperature" in self.probe.quantities

    def collect(self, comm: MPI.Comm, find: Values) -> np.ndarray:
        """The row of a sample, on rank 0 whole (collective)."""
        count, parts = len(self.record.points), []
        for quantity in self.probe.quantities:
            part = np.zeros((count, count_components(quantity)))
            part[self.mine] = find(quantity)
            parts.append(part.ravel())
        row = np.concatenate(parts)
        total = np.empty_like(row)
        comm.Reduce(row, total)
        return total


class Probes(Task):
    """Takes the samples of all sets; rank 0 writes them."""

    def __init__(self, sim: Simulation, run: Path) -> None:
        """(collective)"""
        self._run = run
        self._sets = [_open_set(sim, probe, run / PROBES) for probe in sim.case.output.probes]
        self._sampler: SolidsSampler | CellSampler | None = None
        if any(probes.needs_solids or probes.needs_solids_heat for probes in self._sets):
            self._sampler = open_sampler(sim)

    @property
    def records(self) -> list[ProbeSet]:
        """What results.nc has of them."""
        return [probes.record for probes in self._sets]

    def after_step(self, sim: Simulation) -> None:
        """Take the samples that are due (collective)."""
        due = [probes for probes in self._sets if probes.cadence.due(sim.time)]
        if not due:
            return
        with sim.timers("record"):
            solids = heat = np.empty((0, 0))
            if self._sampler and any(probes.needs_solids for probes in due):
                solids = sample_solids(self._sampler, sim)
            if self._sampler and any(probes.needs_solids_heat for probes in due):
                heat = sample_heat(self._sampler, sim)
            for probes in due:
                row = probes.collect(sim.comm, _open_values(sim, probes, solids, heat))
                if sim.comm.rank == 0:
                    with writing(self._run, f"{PROBES}/{probes.record.rows.path.name}"):
                        probes.record.rows.append(sim.time, row)

    def save(self, sim: Simulation, folder: Path) -> Saved:
        """When the next samples are due, and what there is of rows, which stay where they are."""
        numbers = {}
        for probes in self._sets:
            rows = probes.record.rows
            if sim.comm.rank == 0 and rows.count:
                with rows.path.open("rb") as file:
                    os.fsync(file.fileno())
            numbers[probes.probe.name] = {
                "next": probes.cadence.next,
                "count": rows.count,
                "checksum": rows.checksum,
            }
        return Saved(numbers)

    def load(self, sim: Simulation, saved: Saved, folder: Path) -> None:
        """Go on from `saved`: rows that were written later are removed."""
        for probes in self._sets:
            numbers, rows = saved.numbers[probes.probe.name], probes.record.rows
            probes.cadence.next = numbers["next"]
            rows.count, rows.checksum = numbers["count"], numbers["checksum"]
            if not sim.comm.bcast(rows.is_whole() if sim.comm.rank == 0 else None):
                text = f"{PROBES}/{rows.path.name} has not the {rows.count} rows that the checkpoint goes on from"
                raise ValueError(f"{text}; put it back")


def _open_set(sim: Simulation, probe: Probe, folder: Path) -> _Set:
    """(collective)"""
    points = list_points(probe, sim.case.domain)
    cells = sim.cells.find_holders(sim.comm, points)
    mine = np.flatnonzero(cells >= 0)
    owners = sim.comm.allreduce((cells >= 0).astype(int))
    if (owners != 1).any():
        row = int(np.flatnonzero(owners != 1)[0])
        raise SolverError(f"output.probes: point {row + 1} of {probe.name} is in {owners[row]} cells of the ranks")
    centres = sim.gas.centres[cells[mine]] if sim.has_gas else points[mine]
    rows = Rows(folder / f"{probe.name}.rows", len(points) * count_columns(probe.quantities))
    record = ProbeSet(probe.name, points, probe.quantities, rows)
    return _Set(probe, record, Cadence(probe.every, probe.start), mine, cells[mine], points[mine] - centres)


def _open_values(sim: Simulation, probes: _Set, solids: np.ndarray, heat: np.ndarray) -> Values:
    """`solids`, `heat`: the samples of this rank's cells, where one of the quantities is of solids, or their
    temperature."""
    cells = probes.cells

    def find(quantity: str) -> np.ndarray:
        if quantity == "solids_temperature":
            return QUANTITIES[quantity].derive(heat[cells])
        if quantity == "gas_temperature":
            assert sim.heat is not None and sim.heat.gas is not None
            return sim.heat.gas.temperatures[cells, None]
        if quantity in OF_SOLIDS:
            return QUANTITIES[quantity].derive(solids[cells])
        gas = sim.gas
        rows = sample_gas(gas.voidage[cells], gas.velocity[cells], gas.pressure[cells])
        values = QUANTITIES[quantity].derive(rows)
        if quantity == "pressure":
            values = values + np.einsum("ij,ij->i", gas.pressure_gradient[cells], probes.offsets)[:, None]
        return values

    return find

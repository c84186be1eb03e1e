"""Snapshots of the voidage, averaged over the depth of the bed: what bubbles are found in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.coupling.discretisation import Cells
from fbcouple.simulation.clock import Cadence
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.task import Saved, Task

_FILE = "snapshots.npz"


class Snapshots(Task):
    """Takes the depth-mean voidage at regular times, from time 0 on; rank 0 keeps it in `taken`."""

    def __init__(self, comm: MPI.Comm, cells: Cells, every: float) -> None:
        """`every` [s] of simulated time (collective)."""
        self._cadence, self._mean = Cadence(every), cells.open_depth_mean(comm)
        self.taken: list[tuple[float, np.ndarray]] = []
        """Time [s] and depth-mean voidage, float32 (z, x), of each snapshot so far; empty but on rank 0."""

    def start(self, sim: Simulation) -> None:
        """The first is that of the start (collective)."""
        self.after_step(sim)

    def after_step(self, sim: Simulation) -> None:
        """Take a snapshot if one is due (collective)."""
        with sim.timers("record"):
            self.take(sim.coupling.voidage, sim.time)

    def take(self, voidage: np.ndarray, time: float) -> None:
        """Keep the depth mean of `voidage` (n,), this rank's cells, if a snapshot is due at `time` [s] (collective)."""
        if not self._cadence.due(time):
            return
        field = self._mean.find(voidage)
        if field is not None:
            self.taken.append((time, field.astype(np.float32)))

    def save(self, sim: Simulation, folder: Path) -> Saved:
        """When the next is due, and those taken so far in a file of their own."""
        if sim.comm.rank == 0:
            np.savez(folder / _FILE, times=[time for time, _ in self.taken], fields=[field for _, field in self.taken])
        return Saved({"next": self._cadence.next}, files=[_FILE])

    def load(self, sim: Simulation, saved: Saved, folder: Path) -> None:
        """Go on from `saved`."""
        self._cadence.next = saved.numbers["next"]
        if sim.comm.rank == 0:
            own = np.load(folder / _FILE)
            self.taken = list(zip(own["times"].tolist(), own["fields"], strict=True))

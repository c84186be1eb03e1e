"""Snapshots of the voidage, averaged over the depth of the bed: what bubbles are found in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.geometry.grid import Grid
from fbcouple.simulation.clock import Cadence


class Snapshots:
    """Takes the depth-mean voidage at regular times; rank 0 keeps it in `taken`."""

    def __init__(self, comm: MPI.Comm, grid: Grid, owned: np.ndarray, every: float) -> None:
        """`owned` (n, 3): index triples of this rank's cells; `every` [s] of simulated time, from time 0 on."""
        self._comm = comm
        self.cadence = Cadence(every)
        nx, self._depth, nz = grid.cells
        self._shape = nz, nx
        self._columns = owned[:, 2] * nx + owned[:, 0]
        self.taken: list[tuple[float, np.ndarray]] = []
        """Time [s] and depth-mean voidage, float32 (z, x), of each snapshot so far; empty but on rank 0."""

    def save(self, path: Path) -> None:
        """Write the snapshots taken so far to `path` (.npz)."""
        np.savez(path, times=[time for time, _ in self.taken], fields=[field for _, field in self.taken])

    def load(self, path: Path) -> None:
        """Go on with the snapshots in `path`."""
        if self._comm.rank == 0:
            saved = np.load(path)
            self.taken = list(zip(saved["times"].tolist(), saved["fields"], strict=True))

    def take(self, voidage: np.ndarray, time: float) -> None:
        """Keep the depth mean of `voidage` (n,), this rank's cells, if a snapshot is due at `time` [s] (collective)."""
        if not self.cadence.due(time):
            return
        nz, nx = self._shape
        sums = np.bincount(self._columns, voidage, minlength=nz * nx)
        total = np.empty_like(sums)
        self._comm.Reduce(sums, total)
        if self._comm.rank == 0:
            self.taken.append((time, (total / self._depth).reshape(nz, nx).astype(np.float32)))

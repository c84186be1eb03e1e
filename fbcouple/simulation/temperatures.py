"""Temperatures of the particles at the start of a run, and the heat that they hold."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.case.schema.sections import Case
from fbcouple.paths import TEMPERATURES
from fbcouple.solvers.liggghts import Liggghts


def set_start_temperatures(case: Case, run: Path, comm: MPI.Comm, liggghts: Liggghts) -> None:
    """Give each particle the temperature of its start, of which LIGGGHTS has some digits only (collective)."""
    assert case.heat is not None
    own = comm.bcast(_read(run / TEMPERATURES) if comm.rank == 0 else None)
    liggghts.temperatures[:] = case.heat.particle_temperature if own is None else own[liggghts.tags - 1]


def _read(path: Path) -> np.ndarray | None:
    """Temperature [K] of each particle in their order; None if all have that of the case."""
    return np.loadtxt(path, ndmin=1) if path.is_file() else None


def measure_heat(case: Case, liggghts: Liggghts) -> float:
    """Heat m c T [J] of this rank's particles, from 0 K on."""
    assert case.heat is not None and case.heat.particle_specific_heat is not None
    return float(liggghts.own_masses @ liggghts.temperatures) * case.heat.particle_specific_heat

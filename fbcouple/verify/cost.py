"""What a run has to do, as it is told before, against what it did."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mpi4py import MPI

from fbcouple.case.cost.work import count_work
from fbcouple.simulation import loop
from fbcouple.verify.harness import GAS, GLASS, open_bench
from fbcouple.verify.registry import Number, check

_END = 0.02
_BED: dict[str, Any] = {
    "end_time": _END,
    "domain": {"size": [0.012, 0.012, 0.024], "cells": [4, 4, 8]},
    "gas": GAS | {"inlet_velocity": 1.2, "max_courant": 1.0, "max_fourier": 1.0},
    "particles": GLASS | {"count": 600},
    "contact": {"restitution": 0.9, "wall_restitution": 0.9, "friction": 0.1, "wall_friction": 0.1, "stiffness": 400.0},
    "start": {},
    "exchange": {},
}


@check("predicted-steps")
def count_steps(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """DEM steps of a bed that gas lifts, to its end: those told before, to the last one."""
    sim = open_bench(folder, comm, _BED)
    told, taken, fluid = count_work(sim.case), 0, 0
    sim.initialise()
    while sim.proceed:
        loop.step(sim)
        taken, fluid = taken + sim.substeps, fluid + 1
    yield Number("DEM steps", float(taken), float(told.dem_steps), 0.0)
    yield Number("fluid steps over those told", fluid / told.fluid_steps, 1.0, 0.35)

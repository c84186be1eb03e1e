"""A closed vessel: what falls in it drives as much gas up past itself."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.simulation.loop import step
from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, open_bench
from fbcouple.verify.registry import Number, check

_VESSEL: dict[str, Any] = {
    "domain": {"size": [0.012, 0.006, 0.024], "cells": [6, 3, 12]},
    "gas": GAS | {"inlet_velocity": 0.0, "top": "closed", "pressure_tolerance": 1e-12, "max_step": 5e-4},
    "particles": GLASS | {"count": 400},
    "contact": FRICTIONLESS,
    "start": {"spacing": 1.2},
    "exchange": {"filter_passes": 1},
}
_STEPS = 120


@check("closed-vessel", ranks=(1, 2))
def closed_vessel(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Upward volume flow of the gas against the downward one of the solids, summed over all cells, in each of 120
    steps of a bed that falls: d(eps)/dt + div(eps u) = 0 between walls makes both the same. The solids' flow is that of
    the step in which they moved; where steps change, the volumes over all steps agree less well than the flows."""
    bench = open_bench(folder, comm, _VESSEL)
    bench.initialise()
    worst = fastest = leaving = driven = fallen = 0.0
    before = _lift(bench)
    for _ in range(_STEPS):
        step(bench)
        assert bench.gas_report is not None
        now = _lift(bench)
        solids, gas = (now - before) / bench.moved, _flow(bench)
        driven, fallen, before = driven + gas * bench.dt, fallen + now - before, now
        fastest = max(fastest, abs(gas))
        worst = max(worst, abs(gas - solids))
        leaving = max(leaving, bench.gas_report.lost)
    yield Number("gas up less solids down, of the largest flow", worst / fastest, 0.0, 1e-9)
    yield Number("volume of gas up over that of solids down", driven / fallen, 1.0, 0.01)
    yield Number("gas that is lost", leaving * bench.grid.size[2] / fastest, 0.0, 1e-9)


def _lift(bench: Simulation) -> float:
    """Sum of height times gas volume over all cells [m4]."""
    height = bench.grid.centres(2)[bench.owned[:, 2]]
    return bench.comm.allreduce(float(height @ bench.gas.voidage)) * bench.grid.cell_volume


def _flow(bench: Simulation) -> float:
    """Sum of eps u_z over the volume [m4 s-1]."""
    upward = np.ascontiguousarray(bench.gas.state[:, 2])
    return bench.comm.allreduce(float(upward @ bench.gas.voidage)) * bench.grid.cell_volume

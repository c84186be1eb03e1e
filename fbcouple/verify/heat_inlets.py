"""Inlets with temperatures of their own against what they bring: velocity, area, density and temperature of each."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.derived import inlet_rows
from fbcouple.verify.harness import GAS, open_bench
from fbcouple.verify.heat_gas import HEAT, hold
from fbcouple.verify.registry import Number, check, name_variants

_START, _STEP, _STEPS = HEAT["gas_temperature"], 2e-3, 120
_OPENS, _TURNS, _LEAVES = 0.02, 0.101, 0.161
_LAWS = {"constant density": "constant", "ideal density": "ideal"}
# The background has the gas's temperature; the jet cuts faces of it, and comes on; by the port gas leaves at last.
_INLETS: list[dict[str, Any]] = [
    {"rectangle": [[0.0, 0.0], [0.08, 0.02]], "velocity": 0.5},
    {"circle": [0.043, 0.011, 0.0093], "ramp": [[0.0, 0.0], [_OPENS, 4.0]], "temperature": 500.0},
    {
        "face": "left",
        "rectangle": [[0.003, 0.012], [0.017, 0.031]],
        "ramp": [[0.0, 0.6], [_TURNS, 0.6], [_TURNS, 0.2], [_LEAVES, 0.2], [_LEAVES, -0.3]],
        "temperature": 250.0,
    },
]


@check("heat-inlets", ranks=(1, 2), variants=tuple(_LAWS), judge=name_variants)
def heat_inlets(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """A cold background, a hot jet that comes on and cuts its faces, a colder port in the side, by which gas leaves at
    last: in every step the heat and the volume that come in are those of each inlet's velocity, area, density and
    temperature, together."""
    law = _LAWS[variant]
    sections: dict[str, Any] = {
        "domain": {"size": [0.08, 0.02, 0.1], "cells": [9, 3, 10]},
        "gas": GAS | {"inlet_velocity": None, "inlets": _INLETS, "walls": "slip", "pressure_tolerance": 1e-12},
        "heat": HEAT | {"gas_conductivity": 1e-12, "gas_density": law},
    }
    bench = open_bench(folder, comm, sections)
    heat, gas = bench.heat, bench.case.gas
    assert heat is not None and heat.gas is not None and gas is not None
    areas = np.array([inlet.area for inlet in gas.inlets])
    warm = np.array([inlet.temperature or _START for inlet in gas.inlets])
    ramps = [np.array(inlet_rows(inlet)).T for inlet in gas.inlets]
    capacity = GAS["density"] * HEAT["gas_specific_heat"]
    off = lost = ledger = 0.0
    for _ in range(_STEPS):
        hold(bench, _STEP)
        volumes = areas * [np.interp(bench.time, *ramp) for ramp in ramps]
        masses = volumes * _START / warm if law == "ideal" else volumes
        brought = capacity * _STEP * masses * (warm - _START)
        if bench.time < _LEAVES:
            off = max(off, abs(heat.flows["heat_by_inlets"] - brought.sum()) / np.abs(brought).sum())
        assert bench.gas_report is not None
        lost = max(lost, abs(bench.gas_report.inflow / volumes.sum() - 1.0))
        ledger = max(ledger, heat.error)
    hottest = comm.allreduce(float(heat.gas.temperatures.max()), MPI.MAX)
    coldest = comm.allreduce(float(heat.gas.temperatures.min()), MPI.MIN)
    yield Number("largest deviation of the heat that comes in, of all that inlets bring", off, 0.0, 1e-10)
    yield Number("largest deviation of the volume that comes in, and goes out", lost, 0.0, 1e-12)
    yield Number("largest error of a step's ledger", ledger, 0.0, 1e-12)
    yield Number(
        "hottest above the jet, or coldest below the port", max(hottest - 500.0, 250.0 - coldest, 0.0), 0.0, 1e-6, "K"
    )

"""A gas whose density follows its temperature against closed forms: a heated channel, a hot bed that is held."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.physics.drag.registry import DRAG_LAWS
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, open_bench
from fbcouple.verify.heat_gas import HEAT, hold
from fbcouple.verify.registry import Number, check

_COLD, _HOT, _GRAVITY = 300.0, 600.0, 9.81


@check("ideal-gas-channel")
def ideal_gas_channel(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Gas that two walls heat from 300 towards 600 K: T_w - (T_w - T_0) exp(-z/l), l = rho cp U w/(2 h); its mass flux
    is the same everywhere, so u = U T/T_0, and pressure, momentum and buoyancy balance."""
    cells, height, width, speed, length = 120, 0.3, 0.01, 2.0, 0.1
    density = GAS["density"]
    coefficient = density * HEAT["gas_specific_heat"] * speed * width / (2.0 * length)
    sections = {
        "domain": {"size": [width, width, height], "cells": [1, 1, cells]},
        "gas": GAS | {"viscosity": 1e-9, "inlet_velocity": speed, "walls": "slip", "pressure_tolerance": 1e-10},
        "heat": HEAT
        | {"gas_conductivity": 1e-9, "gas_density": "ideal"}
        | {"walls": [{"face": face, "temperature": _HOT, "coefficient": coefficient} for face in ("left", "right")]},
    }
    bench = open_bench(folder, comm, sections)
    for _ in range(800):
        hold(bench, 5e-4)
    heat = bench.heat
    assert heat is not None and heat.gas is not None and bench.gas_report is not None

    def temperature(z: np.ndarray) -> np.ndarray:
        return _HOT - (_HOT - _COLD) * np.exp(-z / length)

    z = bench.gas.centres[:, 2]
    off = np.abs(heat.gas.temperatures - temperature(z)).max()
    yield Number("largest deviation of the temperature, over what it rises by", off / (_HOT - _COLD), 0.0, 1e-2)
    fluxes = bench.gas.velocity[:, 2] * _COLD / heat.gas.temperatures
    yield Number(
        "largest deviation of the mass flux, over that of the inlet", np.abs(fluxes / speed - 1.0).max(), 0.0, 1e-6
    )
    fine = (np.arange(100_000) + 0.5) * height / 100_000
    buoyancy = density * _GRAVITY * height * float(np.mean(1.0 - _COLD / temperature(fine)))
    momentum = density * speed**2 * (float(temperature(np.array(height))) / _COLD - 1.0)
    yield Number("pressure at the inlet", bench.gas_report.inlet_pressure, momentum - buoyancy, 0.05, "Pa")
    yield Number("largest error of a step's ledger", heat.error, 0.0, 1e-12)


@check("ideal-gas-bed")
def ideal_gas_bed(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A bed of hot particles that is held: the gas has their temperature after the first layers, and half of its
    density; from there on it costs what the law says of that and of twice the velocity, less the buoyancy."""
    d, layers, speed, wide = GLASS["diameter"], 20, 0.5, 6
    across, up = (np.arange(wide) + 0.5) * d, (np.arange(layers) + 0.5) * d
    lattice = np.stack(np.meshgrid(across, across, up, indexing="ij"), axis=-1).reshape(-1, 3)
    sections = {
        "domain": {"size": [wide * d, wide * d, 1.5 * layers * d], "cells": [3, 3, 15]},
        "gas": GAS | {"inlet_velocity": speed, "walls": "slip", "pressure_tolerance": 1e-10},
        "particles": GLASS,
        "contact": FRICTIONLESS,
        "start": {},
        "exchange": {"voidage": "centre", "drag": "gidaspow"},
        "heat": HEAT | {"particle_temperature": _HOT, "particle_specific_heat": 1e7, "gas_density": "ideal"},
    }
    bench = open_bench(folder, comm, sections, lattice)
    bench.initialise()
    for _ in range(400):
        hold(bench, 1e-4)
        bench.coupling.read_gas(bench.gas.state)
    heat = bench.heat
    assert heat is not None and heat.gas is not None
    z, voidage = bench.gas.centres[:, 2], 1.0 - np.pi / 6.0
    rows = [np.abs(z - (2 * row + 1) * d) < 0.1 * d for row in (6, 8)]
    gradient = -np.diff([bench.gas.pressure[row].mean() for row in rows])[0] / (4.0 * d)
    fast = speed * _HOT / _COLD / voidage
    beta = float(DRAG_LAWS["gidaspow"](voidage, fast, d, 0.5 * GAS["density"], GAS["viscosity"]))
    cost = beta * fast / (np.pi / 6.0 * d**3) * (1.0 - voidage) / voidage - 0.5 * GAS["density"] * _GRAVITY
    yield Number("temperature of the gas amid the bed", heat.gas.temperatures[rows[0]].mean(), _HOT, 0.01, "K")
    yield Number("velocity there", bench.gas.velocity[rows[0], 2].mean(), fast, 1e-4 * fast, "m/s")
    yield Number("pressure gradient there, over what the law says", gradient / cost, 1.0, 1e-3)

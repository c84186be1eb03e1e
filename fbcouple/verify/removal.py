"""Particles that leave through openings in walls: who goes and who stays, and what gas takes their place."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.simulation import loop
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, open_bench
from fbcouple.verify.registry import Number, check

_SPEED, _THROW_STEPS = 1.0, 40
_THROW: dict[str, Any] = {
    "domain": {"size": [0.03, 0.02, 0.04], "cells": [3, 2, 4]},
    "gravity": 0.0,
    "particles": GLASS
    | {
        "outlets": [
            {"face": "right", "rectangle": [[0.0, 0.01], [0.02, 0.02]]},
            {"face": "right", "circle": [0.01, 0.03, 0.008]},
        ]
    },
    "contact": FRICTIONLESS,
    "output": {"record_every": 5e-4},
}
_DRAIN_STEPS, _LONGEST, _FALL = 60, 1e-4, -0.4
_DRAIN: dict[str, Any] = {
    "domain": {"size": [0.024, 0.01, 0.03], "cells": [12, 5, 15], "periodic": ["y"]},
    "gas": GAS
    | {
        "inlets": [{"face": "left", "rectangle": [[0.0, 0.002], [0.01, 0.008]], "velocity": 1.0}],
        "outlets": [{"face": "floor", "rectangle": [[0.012, 0.0], [0.02, 0.01]]}],
        "pressure_tolerance": 1e-12,
        "max_courant": 2.0,
        "max_step": _LONGEST,
    },
    "particles": GLASS | {"outlets": [{"face": "floor", "rectangle": [[0.012, 0.0], [0.02, 0.01]]}]},
    "contact": FRICTIONLESS | {"stiffness": 200.0},
    "exchange": {"drag": "gidaspow", "filter_passes": 1},
}


@check("throw")
def throw(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Particles thrown at a wall with two openings, without gas and gravity: those that meet an opening leave, with
    their momentum, once they have passed it, and the others come back."""
    heights, across = np.array([0.004, 0.012, 0.018, 0.024, 0.03, 0.036]), np.array([0.004, 0.01, 0.016])
    start = np.array([[0.02 + 0.5 * y, y, z] for z in heights for y in across])
    by_slot = (start[:, 2] > 0.01) & (start[:, 2] < 0.02)
    by_hole = np.hypot(start[:, 1] - 0.01, start[:, 2] - 0.03) < 0.003
    bench = open_bench(folder, comm, _THROW, start)
    assert bench.traffic is not None
    bench.liggghts.velocities[:, 0] = _SPEED
    bench.initialise()
    for _ in range(_THROW_STEPS):
        loop.step(bench)
    exits, ledger, radius = bench.traffic.exits, bench.traffic.ledger, 0.5 * GLASS["diameter"]
    numbers = exits[:, 0].astype(int) - 1
    for name, outlet, wanted in (("slot", 1, by_slot), ("round hole", 2, by_hole)):
        wrong = np.setxor1d(numbers[exits[:, 4] == outlet], np.flatnonzero(wanted))
        yield Number(f"particles that left by the {name} and should not, or the other way round", len(wrong), 0.0, 0.0)
    passed = (0.03 + radius - start[numbers, 0]) / _SPEED
    late = exits[:, 3] - passed
    yield Number("first seen out before it had passed", float((late < -1e-12).sum()), 0.0, 0.0)
    yield Number("seen out late, over a step", float(late.max() / bench.dt), 0.5, 0.5 + 1e-9)
    momentum = ledger.removed.count * np.pi / 6.0 * GLASS["diameter"] ** 3 * GLASS["density"] * _SPEED
    yield Number("momentum that left", ledger.removed.momentum[0], momentum, 1e-12, "kg m s-1", relative=True)
    back = comm.allreduce(int((bench.liggghts.velocities[:, 0] < 0.0).sum()))
    yield Number("particles that came back from the wall", back, len(start) - len(numbers), 0.0)
    yield Number("ledger", bench.traffic.hold(), 0.0, 1e-13)


@check("drain")
def drain(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A bed that gas aerates from its side falls out of an opening in the floor, by which all gas leaves, too: gas that
    came in less gas that went out is the volume of the particles that left."""
    x, y, z = ((np.arange(n) + 0.5) * 1e-3 for n in (24, 10, 6))
    start = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    bench = open_bench(folder, comm, _DRAIN, start)
    assert bench.traffic is not None
    bench.liggghts.velocities[:, 2] = _FALL
    bench.initialise()
    before, came = bench.cells.add_up(bench.coupling.voidage), 0.0
    momentum = error = solids = 0.0
    for _ in range(_DRAIN_STEPS):
        seen, left = bench.cells.add_up(bench.coupling.voidage), bench.traffic.ledger.removed.count
        loop.step(bench)
        report = bench.gas_report
        assert report is not None
        came += (report.inflow + report.backflow - report.outflow) * bench.dt
        momentum, error = max(momentum, bench.conservation.momentum_error), max(error, bench.traffic.hold())
        held = comm.allreduce(float((4.0 / 3.0 * np.pi * bench.liggghts.radii**3).sum()))
        solids = max(solids, abs(comm.allreduce(bench.cells.add_up(1.0 - bench.coupling.voidage)) / held - 1.0))
    ledger = bench.traffic.ledger
    filled = comm.allreduce(seen - before)
    particle = np.pi / 6.0 * GLASS["diameter"] ** 3
    yield Number("particles that left, over 20", float(ledger.removed.count > 20), 1.0, 0.0)
    yield Number("in = out + held", ledger.count - comm.allreduce(bench.liggghts.count), 0.0, 0.0)
    yield Number("gas that came to stay, of a particle", (came - filled) / particle, 0.0, 1e-9)
    yield Number("volume that particles left, of a particle", filled / particle, left, 1e-9)
    yield Number("ledger, worst", error, 0.0, 1e-13)
    yield Number("momentum, of the drag", momentum, 0.0, 1e-10)
    yield Number("solids volume", solids, 0.0, 1e-12)

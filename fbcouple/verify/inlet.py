"""An inlet whose velocity changes in time: started, stopped and reversed at once, below a bed that lies on it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.simulation.loop import step
from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, open_bench
from fbcouple.verify.published import PUBLISHED, Bed
from fbcouple.verify.registry import Number, check

_RAMP = [[0.0, 0.0], [0.05, 0.0], [0.07, 0.2], [0.08, 0.4], [0.08, 0.3], [0.13, 0.3], [0.13, 0.0], [0.15, 0.0]]
_RAMP += [[0.15, -0.3], [0.19, -0.3]]
"""Rows of time [s] and velocity [m/s]: rest while the bed settles, up, a jump down, a sudden stop, sudden reversal."""
_STEADY = {"upwards": (0.11, 0.3), "downwards": (0.17, -0.3)}
"""From when [s] on the pressure is averaged, until the ramp's next change, and at which velocity [m/s]."""
_CELLS, _SIDE = (2, 2, 12), 0.008
_BED: dict[str, Any] = {
    "domain": {"size": [_SIDE, _SIDE, 0.024], "cells": list(_CELLS)},
    "gas": GAS | {"inlet_velocity": None, "inlet_ramp": _RAMP, "walls": "slip", "pressure_tolerance": 1e-12},
    "particles": GLASS | {"count": 640},
    "contact": FRICTIONLESS | {"restitution": 0.5, "wall_restitution": 0.5, "friction": 0.3},
    "start": {"spacing": 1.01},
    "exchange": {"drag": "ergun"},
}


def _find_velocity(time: float) -> float:
    """Velocity of the ramp, of two rows at one time the later's."""
    times, velocities = np.array(_RAMP).T
    after = int(np.searchsorted(times, time, side="right"))
    if after == len(times):
        return float(velocities[-1])
    part = (time - times[after - 1]) / (times[after] - times[after - 1])
    return float(velocities[after - 1] + part * (velocities[after] - velocities[after - 1]))


def _average_layers(bench: Simulation, values: np.ndarray) -> np.ndarray:
    """Mean of cell values over each layer, from the floor up (collective)."""
    sums = np.bincount(bench.owned[:, 2], values, minlength=_CELLS[2])
    return bench.comm.allreduce(sums) / (_CELLS[0] * _CELLS[1])


@check("inlet-ramp", ranks=(2,))
def inlet_ramp(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """The gas above the bed follows the ramp in every step, and the bed at rest costs Ergun's pressure either way."""
    bench = open_bench(folder, comm, _BED)
    bench.initialise()
    off = 0.0
    losses: dict[str, list[float]] = {name: [] for name in _STEADY}
    expected: dict[str, list[float]] = {name: [] for name in _STEADY}
    while bench.clock.time < _RAMP[-1][0]:
        step(bench)
        velocity = _find_velocity(bench.clock.time)
        layers = _average_layers(bench, bench.gas.velocity[:, 2])
        off = max(off, abs(float(layers[-2]) - velocity))
        pressures = _average_layers(bench, bench.gas.pressure)
        voidages = _average_layers(bench, bench.coupling.voidage)
        for name, (begin, wanted) in _STEADY.items():
            if bench.clock.time > begin and velocity == wanted:
                losses[name].append(float(pressures[1] - pressures[3]))
                expected[name].append(_expect_loss(voidages[1:4], wanted))
    yield Number("largest deviation of the gas above the bed from the ramp", off, 0.0, 1e-7, "m s-1")
    for name in _STEADY:
        value, wanted = float(np.mean(losses[name])), float(np.mean(expected[name]))
        yield Number(f"pressure loss within the bed, {name}", value, wanted, 0.01, "Pa", relative=True)


def _expect_loss(voidages: np.ndarray, velocity: float) -> float:
    """Ergun's loss [Pa] from the middle of the first layer of `voidages` to that of the last."""
    gas = GLASS["diameter"], GAS["density"], GAS["viscosity"]
    losses = np.array([PUBLISHED["ergun"](Bed(eps, abs(velocity), *gas)) for eps in voidages.tolist()])
    cell = _BED["domain"]["size"][2] / _CELLS[2]
    return float(np.sign(velocity) * cell * (losses[1:-1].sum() + (losses[0] + losses[-1]) / 2))

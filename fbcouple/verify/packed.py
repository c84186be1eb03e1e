"""A packed bed under more and more gas: pressure against velocity, with both friction laws."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.simulation.loop import step
from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.harness import GAS, GLASS, open_bench
from fbcouple.verify.published import PUBLISHED, Bed
from fbcouple.verify.registry import Number, check
from fbcouple.verify.rest import lay_column

_WIDTH, _LAYERS, _PITCH = 6, 14, 1.04
_CELL, _CELLS_UP = 1.5e-3, 12
_SETTLE, _RAMP, _FAST = 0.25, 0.25, 0.4
"""The bed falls and settles in still gas for `_SETTLE` [s]; then the gas grows to `_FAST` [m/s], three quarters of what
fluidizes it, over `_RAMP` [s]."""
_SPEEDS = (0.2, 0.3, 0.39)
_LAWS = ("history", "no-history")
_EXCESS = 0.25
"""Pressure drop of the bed that was left to flow over that of the one that stood, less 1."""


def _open(folder: Path, comm: MPI.Comm, law: str) -> Simulation:
    edge = _WIDTH * _PITCH * GLASS["diameter"]
    ramp = [[0.0, 0.0], [_SETTLE, 0.0], [_SETTLE + _RAMP, _FAST]]
    contact = {"restitution": 0.9, "wall_restitution": 0.9, "friction": 0.5, "wall_friction": 0.5, "stiffness": 200.0}
    sections: dict[str, Any] = {
        "domain": {"size": [edge, edge, _CELL * _CELLS_UP], "cells": [1, 1, _CELLS_UP], "periodic": ("x", "y")},
        "gas": GAS
        | {"inlet_velocity": None, "inlet_ramp": ramp, "max_step": 5e-4, "max_courant": 10.0, "max_fourier": 10.0},
        "particles": GLASS | {"rotation": True},
        "contact": contact | {"tangential": law},
        "exchange": {"drag": "ergun"},
    }
    return open_bench(folder, comm, sections, lay_column(_LAYERS, _WIDTH, _PITCH))


def _measure(bench: Simulation) -> Iterator[tuple[float, float, np.ndarray]]:
    """Superficial velocity [m/s], pressure drop [Pa] and voidage of each cell in each step of the ramp."""
    order = np.argsort(bench.gas.centres[:, 2])
    while bench.clock.time < _SETTLE + _RAMP:
        step(bench)
        if bench.clock.time > _SETTLE:
            voidage = bench.coupling.voidage[order]
            velocity = (voidage * bench.gas.velocity[order, 2])[-1]
            pressure = bench.gas.pressure[order]
            yield velocity, pressure[0] - pressure[-1], voidage


def packed_branch(folder: Path, comm: MPI.Comm, law: str) -> Iterator[Number]:
    """Pressure drop at some velocities, and what Ergun loses in the cells as they then are."""
    bench = _open(folder, comm, law)
    bench.initialise()
    rows = list(_measure(bench))
    found = np.array([velocity for velocity, *_ in rows])
    for speed in _SPEEDS:
        velocity, pressure, voidages = rows[int(np.abs(found - speed).argmin())]
        beds = [Bed(eps, velocity, GLASS["diameter"], GAS["density"], GAS["viscosity"]) for eps in voidages.tolist()]
        lost = [PUBLISHED["ergun"](bed) * _CELL for bed in beds]
        # From centre to centre: the lowest cell counts for half, the highest holds no particles.
        yield Number(f"{speed}", pressure, sum(lost) - lost[0] / 2, 0.0, "Pa")


def compare(measured: dict[str, list[Number]]) -> Iterator[Number]:
    """Ergun holds for either bed as it is; without history the bed has packed meanwhile and costs more."""
    for law in _LAWS:
        for number in measured[law]:
            ratio = number.value / number.expected
            yield Number(f"{law}, dp over Ergun at its own voidage, {number.name} m/s", ratio, 1.0, 0.03)
    for stood, flowed in zip(*(measured[law] for law in _LAWS), strict=True):
        name = f"dp without history over dp with it, {stood.name} m/s"
        yield Number(name, flowed.value / stood.value, 1.0 + _EXCESS, 0.15)


check("packed-branch", fast=False, variants=_LAWS, judge=compare)(packed_branch)

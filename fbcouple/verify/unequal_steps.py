"""Clouds that settle in a liquid, in steps of 6, 2, 1 and 9 DEM steps and in equal ones.

What was measured over one step and is used in another has to be scaled by their ratio: the change of the voidage, by
which falling solids push the liquid up, what other forces than drag did to a particle, and its acceleration. In a
liquid the last step's weight is most of what the drag answers to, so that a wrong ratio shows at once.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.harness import FRICTIONLESS, open_bench, take_steps
from fbcouple.verify.registry import Number, check

_UNEQUAL = (6, 2, 1, 9)
_ROUNDS = 15
"""Times that the unequal steps are taken: 270 DEM steps, 54 steps of five."""
_STEPS = {"equal": (5,), "unequal": _UNEQUAL}
_ACROSS, _LAYERS = 2, 24
"""Cells across the cloud, two particles along each edge of one, and layers of particles in the cloud."""


@dataclass(frozen=True)
class Cloud:
    """Particles on a lattice of half a cell, which gives every cell inside the cloud one voidage wherever it falls."""

    cell: float
    """Edge of a cell [m]."""
    density: float
    """Of the liquid [kg m-3]."""
    viscosity: float
    """Of the liquid [Pa s]."""
    diameter: float
    """Of the particles [m]."""
    solid: float
    """Density of the particles [kg m-3]."""
    dem_step: float
    """Steps per contact make this of the stiffness, roughly [s]."""
    forces: tuple[str, ...] = ()
    """Forces of [exchange] that are switched on."""

    def describe(self) -> dict[str, Any]:
        """The sections of the case."""
        cells = [_ACROSS, _ACROSS, _LAYERS + 6]
        stiffness = math.pi / 12 * self.diameter**3 * self.solid * (math.pi / (6 * self.dem_step)) ** 2
        return {
            "domain": {"size": [self.cell * n for n in cells], "cells": cells, "periodic": ["x", "y"]},
            "gas": {
                "density": self.density,
                "viscosity": self.viscosity,
                "inlet_velocity": 0.0,
                "top": "closed",
                "walls": "slip",
                "pressure_tolerance": 1e-12,
            },
            "particles": {"diameter": self.diameter, "density": self.solid},
            "contact": FRICTIONLESS | {"stiffness": stiffness, "steps_per_contact": 6},
            "exchange": {"drag": "gidaspow"} | dict.fromkeys(self.forces, True),
        }

    def place(self) -> np.ndarray:
        """Start positions [m], shape (particles, 3), under the top."""
        spacing = self.cell / 2
        across, up = (np.arange(n) + 0.5 for n in (2 * _ACROSS, _LAYERS))
        x, y, z = np.meshgrid(across, across, up + _LAYERS + 6, indexing="ij")
        return spacing * np.column_stack([x.ravel(), y.ravel(), z.ravel()])


_OIL = Cloud(3e-3, 900.0, 0.1, 1e-3, 2500.0, 2e-3)
_WATER = Cloud(8e-3, 996.8, 8.352e-4, 2.66e-3, 1029.7, 6e-3, ("virtual_mass",))


def settle(folder: Path, comm: MPI.Comm, steps: str, cloud: Cloud) -> Iterator[Number]:
    """Let the cloud settle; the means over the last round, and the largest errors of conservation."""
    bench = open_bench(folder, comm, cloud.describe(), cloud.place())
    bench.initialise()
    kept, momentum, solids, displaced = [], 0.0, 0.0, 0.0
    volume, voidage = None, _keep_voidage(bench)
    for _ in take_steps(bench, _take_rounds(_STEPS[steps])):
        momentum = max(momentum, bench.conservation.momentum_error)
        volume = volume or _find_solids(bench)
        solids = max(solids, abs(_find_solids(bench) / volume - 1.0))
        displaced = max(displaced, _check_displaced(bench, voidage) / volume)
        voidage = _keep_voidage(bench)
        kept.append((bench.dt, *_look_inside(bench, cloud)))
    rows = np.array(kept)
    last = rows[rows[:, 0].cumsum() > rows[:, 0].sum() * (1.0 - 1.0 / _ROUNDS) * (1.0 + 1e-9)]
    speed, slope = (last[:, :1] * last[:, 1:]).sum(axis=0) / last[:, 0].sum()
    yield Number("fall speed", float(speed), 0.0, 0.0, "m s-1")
    yield Number("pressure gradient", float(slope), 0.0, 0.0, "Pa m-1")
    yield Number("momentum, of the drag", momentum, 0.0, 1e-10)
    yield Number("solids volume", solids, 0.0, 1e-12)
    yield Number("displaced_gas_error of a step, against a sum of its own", displaced, 0.0, 1e-12)


def _take_rounds(steps: Sequence[int]) -> Iterator[int]:
    left = _ROUNDS * sum(_UNEQUAL)
    for step in itertools.cycle(steps):
        if left <= 0:
            return
        yield step
        left -= step


def _find_solids(bench: Simulation) -> float:
    return bench.comm.allreduce(bench.cells.add_up(1.0 - bench.coupling.voidage))


def _keep_voidage(bench: Simulation) -> np.ndarray:
    return bench.gas.voidage.copy()


def _check_displaced(bench: Simulation, before: np.ndarray) -> float:
    """How far off [m3] is what the adapter says that the step displaced too much or too little?"""
    assert bench.gas is not None and bench.gas_report is not None
    change = float(np.abs((bench.gas.voidage - before) * bench.gas.volumes).sum())
    wrong = abs(bench.dt / bench.moved - 1.0) * bench.comm.allreduce(change)
    return abs(bench.gas_report.displaced_wrongly - wrong)


def _look_inside(bench: Simulation, cloud: Cloud) -> tuple[float, float]:
    """Mean downward velocity [m/s] and pressure gradient [Pa/m] in the middle third of the cloud."""
    z, speed = bench.liggghts.positions[:, 2], -bench.liggghts.velocities[:, 2]
    heights, reach = bench.gas.centres[:, 2], _LAYERS * cloud.cell / 12
    near, cells = np.abs(z - z.mean()) < reach, np.abs(heights - z.mean()) < reach
    return float(speed[near].mean()), -float(np.polyfit(heights[cells], bench.gas.pressure[cells], 1)[0])


def _compare(measured: dict[str, list[Number]], near: float, slope: float) -> Iterator[Number]:
    equal, unequal = ({n.name: n.value for n in measured[name]} for name in _STEPS)
    for name, tolerance in (("fall speed", near), ("pressure gradient", slope)):
        yield Number(f"{name}, of that in equal steps", unequal[name] / equal[name], 1.0, tolerance)
    yield from measured["unequal"][2:]


@check("unequal-steps", variants=tuple(_STEPS), judge=partial(_compare, near=1e-4, slope=1e-4))
def unequal_steps(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """A cloud in oil, steps of a dozen response times of a particle: as fast and as much pressure as in equal ones."""
    yield from settle(folder, comm, variant, _OIL)


@check("unequal-steps-water", fast=False, variants=tuple(_STEPS), judge=partial(_compare, near=1e-3, slope=1e-2))
def unequal_steps_water(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """The same in water with virtual mass; pressure goes up and down by a hundredth as layers pass the cells' faces."""
    yield from settle(folder, comm, variant, _WATER)

"""A bed of 1 mm glass under less and less gas: the velocity at which it comes to rest."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.simulation.loop import step
from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, Edit, open_bench
from fbcouple.verify.published import PUBLISHED, Bed
from fbcouple.verify.registry import Number, check

_GRAVITY = 9.81
_SIDE, _CELL, _CELLS_UP = 0.008, 0.002, 34
_PLENUM = 2
"""Cells of clear gas below the floor of the bed, so that the inlet's velocity is the superficial one."""
_SITES, _LAYERS = 7, 40
_FAST, _SLOW = 0.9, 0.3
_SETTLE, _RAMP = 0.15, 0.8
"""The gas holds `_FAST` [m/s] for `_SETTLE` [s], then falls to `_SLOW` over `_RAMP`."""
_AT_REST, _CERTAIN = 0.85, 0.5
"""Part of the weight, and velocity [m/s], below which the gas certainly leaves the bed at rest: there the pressure law
is fitted."""


@dataclass(frozen=True)
class _Spheres:
    """What the spheres of 1 mm are: themselves, or parcels, `ratio` times as large as their grains, which take off at a
    velocity that is `slower` by about so much."""

    ratio: float = 1.0
    slower: float = 1.0

    @property
    def particles(self) -> dict[str, Any]:
        """[particles] beside their number."""
        parcels = {"coarse_graining": self.ratio} if self.ratio > 1.0 else {}
        return {"diameter": self.grain_diameter} | parcels

    @property
    def grain_diameter(self) -> float:
        """[m]."""
        return float(GLASS["diameter"]) / self.ratio


def _open(folder: Path, comm: MPI.Comm, spheres: _Spheres) -> Simulation:
    floor = _PLENUM * _CELL
    pitch = (_SIDE - 2e-5) / _SITES
    row = 1e-5 + pitch * (np.arange(_SITES) + 0.5)
    x, y, z = np.meshgrid(row, row, floor + pitch * (np.arange(_LAYERS) + 0.5), indexing="ij")
    shift = np.random.default_rng(1).uniform(-0.03, 0.03, (x.size, 3)) * GLASS["diameter"]
    fast, slow = _FAST / spheres.slower, _SLOW / spheres.slower
    ramp = [[0.0, fast], [_SETTLE, fast], [_SETTLE + _RAMP, slow]]
    sections: dict[str, Any] = {
        "domain": {"size": [_SIDE, _SIDE, _CELL * _CELLS_UP], "cells": [1, 1, _CELLS_UP]},
        "gas": GAS | {"inlet_velocity": None, "inlet_ramp": ramp, "walls": "slip", "pressure_tolerance": 1e-10},
        "particles": spheres.particles,
        "contact": FRICTIONLESS | {"friction": 0.1},
        "exchange": {},
    }
    edits: dict[str, Edit] = {
        "DEM/in.liggghts": lambda deck: re.sub(r"zplane 0\.0$", f"zplane {floor}", deck, flags=re.MULTILINE)
    }
    return open_bench(folder, comm, sections, np.column_stack([x.ravel(), y.ravel(), z.ravel()]) + shift, edits)


def _run_ramp(bench: Simulation) -> np.ndarray:
    """Rows of superficial velocity [m/s], pressure drop [Pa] and the voidage of each cell, one a coupled step."""
    order = np.argsort(bench.gas.centres[:, 2])
    rows = []
    while bench.clock.time < _SETTLE + _RAMP:
        step(bench)
        voidage = bench.coupling.voidage[order]
        velocity = (voidage * bench.gas.velocity[order, 2])[0]
        pressure = bench.gas.pressure[order]
        rows.append((velocity, pressure[0] - pressure[-1], *voidage))
    return np.array(rows)


@check("minimum-fluidization", fast=False)
def minimum_fluidization(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Where the pressure of the bed at rest meets its weight, against Ergun at its own voidage in each cell, 5 %."""
    yield from _find_onset(folder, comm, _Spheres())


@check("minimum-fluidization-parcels", fast=False)
def minimum_fluidization_of_parcels(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """The same of parcels of 1 mm of 8 grains of 0.5 mm each: Ergun goes by the grains, within 5 %."""
    yield from _find_onset(folder, comm, _Spheres(ratio=2.0, slower=2.9))


def _find_onset(folder: Path, comm: MPI.Comm, spheres: _Spheres) -> Iterator[Number]:
    bench = _open(folder, comm, spheres)
    bench.initialise()
    rows = _run_ramp(bench)
    velocity, pressure = rows[:, 0], rows[:, 1]
    mass = np.pi / 6 * GLASS["diameter"] ** 3 * (GLASS["density"] - GAS["density"])
    weight = float(_SITES**2 * _LAYERS * mass * _GRAVITY / _SIDE**2)
    rest = (pressure < _AT_REST * weight) & (velocity < _CERTAIN / spheres.slower)
    laminar, inertial = np.linalg.lstsq(np.stack([velocity, velocity**2], axis=1)[rest], pressure[rest])[0]
    found = 2 * weight / (laminar + np.sqrt(laminar**2 + 4 * inertial * weight))
    expected = _ergun_onset(rows[rest, 2:].mean(axis=0), weight, spheres.grain_diameter)
    yield Number("minimum fluidization", float(found), expected, 0.05, "m s-1", relative=True)


def _ergun_onset(voidages: np.ndarray, weight: float, diameter: float) -> float:
    """Superficial velocity [m/s] at which Ergun's pressure loss over the cells, of grains of that diameter [m], is the
    weight [Pa], by bisection."""
    low, high = 0.01, 10.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        beds = [Bed(eps, middle, diameter, GAS["density"], GAS["viscosity"]) for eps in voidages.tolist()]
        lost = sum(PUBLISHED["ergun"](bed) for bed in beds) * _CELL
        low, high = (middle, high) if lost < weight else (low, middle)
    return high

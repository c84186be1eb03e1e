"""Lone particles that fall from rest through gas at rest: their terminal velocity."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.coupling.box.mapping import VOIDAGE_METHODS
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, Edit, open_bench, take_same_step
from fbcouple.verify.registry import Number, check

# Fall speed [m/s] of glass spheres by diameter [m]: drag of a lone sphere (Schiller and Naumann 1933) balanced with
# the weight less that of the gas.
SCHILLER_NAUMANN = {
    5e-6: 1.701e-3,
    20e-6: 0.02686,
    50e-6: 0.1565,
    100e-6: 0.5161,
    200e-6: 1.3609,
    500e-6: 3.6312,
    1e-3: 6.749,
}
_WIND = 0.2
# Speed [m/s] of such spheres without weight after 0.02 s in that wind [m/s], integrated from rest.
_CARRIED = {50e-6: 0.141665, 100e-6: 0.0563435, 200e-6: 0.0173453, 500e-6: 3.42710e-3, 1e-3: 1.03920e-3}
# The terminal speed for 1 mm and the paper's law, whose switch leaves a rest of Ergun at voidage 1.
_PAPER = {1e-3: 6.680}

_CELL = 0.1
"""Edge [m] of the cells, a column for each particle: a particle drags its cell's gas along and so loses the part
(pi/8) C_D (d/cell)^2 of its slip, 1e-4 at most."""
_CELLS_UP = 240
"""Height of the box: 1 mm falls 21 m in `_TIME`."""
_TIME, _STEP = 3.5, 2e-3
"""Seven response times of 1 mm; DEM and coupling step, 11.5 response times of 5 um."""


def fall(folder: Path, comm: MPI.Comm, exchange: dict[str, Any], expected: dict[float, float]) -> Iterator[Number]:
    """Let spheres of the expected diameters fall from rest side by side, and compare their last speed within 1 %."""
    velocities = _release(folder, comm, np.array(list(expected)), {"exchange": exchange}, round(_TIME / _STEP))
    for (diameter, speed), found in zip(expected.items(), (-velocities).tolist(), strict=True):
        yield Number(f"fall speed of {diameter * 1e6:g} um", found, speed, 0.01, "m s-1", relative=True)


def _release(
    folder: Path, comm: MPI.Comm, diameters: np.ndarray, more: dict[str, Any], steps: int, wind: float = 0.0
) -> np.ndarray:
    """Let spheres go from rest near the top, in gas that rises with `wind` [m/s]; their upward velocity [m/s] after
    so many steps."""
    cells = [len(diameters), 1, _CELLS_UP]
    pair_mass = math.pi / 12 * diameters.min() ** 3 * GLASS["density"]
    soft = {"stiffness": pair_mass * (math.pi / (6 * _STEP)) ** 2, "restitution": 1.0, "wall_restitution": 1.0}
    sections = {
        "domain": {"size": [_CELL * n for n in cells], "cells": cells},
        "gas": GAS | {"walls": "slip", "pressure_tolerance": 1e-10, "inlet_velocity": wind},
        "particles": name_sizes(diameters),
        "contact": FRICTIONLESS | soft,
    }
    top = (_CELLS_UP - 0.5) * _CELL
    positions = np.array([[(n + 0.5) * _CELL, 0.5 * _CELL, top] for n in range(cells[0])])
    edits: dict[str, Edit] = {"DEM/in.liggghts": coarsen_bins}
    bench = open_bench(folder, comm, sections | more, positions, edits, np.arange(len(diameters)))
    liggghts = bench.liggghts
    assert liggghts is not None
    bench.initialise()
    for _ in range(steps):
        take_same_step(bench)
    return liggghts.velocities[np.argsort(liggghts.positions[:, 0]), 2]


def name_sizes(diameters: np.ndarray) -> dict[str, Any]:
    """[particles] of glass, as many of each of these diameters [m]: the first, and a row for each other one."""
    share = 1.0 / len(diameters)
    mixture = [[float(diameter), GLASS["density"], share] for diameter in diameters[1:]]
    return {"diameter": float(diameters[0]), "fractions": "number", "mixture": mixture}


def coarsen_bins(deck: str, cell: float = _CELL) -> str:
    """LIGGGHTS bins the box by skin and bin size: 24 000 diameters up, bins as small as a particle are too many."""
    deck = re.sub(r"neighbor( +)\S+ bin", f"neighbor {cell / 4} bin", deck)
    deck = re.sub(r"sort (\d+) \S+", rf"sort \1 {cell / 2}", deck)
    return re.sub(r"binsize \S+", f"binsize {cell / 2}", deck)


@check("terminal-velocity")
def terminal_velocity(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """5 um to 1 mm with the drag of lone spheres; of 0.7 and 11.5 response times is the step of the two smallest."""
    yield from fall(folder, comm, {"drag": "schiller-naumann"}, SCHILLER_NAUMANN)


_WIDE = _CELL / GLASS["diameter"]
"""A cell in diameters, the width of kernels here."""
_SHARED: dict[str, dict[str, Any]] = {name: {"voidage": name} for name in VOIDAGE_METHODS if name != "trilinear"}
_SHARED["gaussian"]["kernel_width"] = _WIDE
_SHARED["diffusion"] = {"diffusion_width": _WIDE}


def _put_together(measured: dict[str, list[Number]]) -> Iterator[Number]:
    for method, numbers in measured.items():
        yield from (replace(number, name=f"{method}: {number.name}") for number in numbers)


@check("terminal-velocity-voidage", fast=False, variants=tuple(_SHARED), judge=_put_together)
def terminal_velocity_voidage(folder: Path, comm: MPI.Comm, method: str) -> Iterator[Number]:
    """1 mm with each way to share a particle among cells and to read them: the fall of a lone one does not change."""
    exchange = {"drag": "schiller-naumann", "scheme": "explicit"} | _SHARED[method]
    yield from fall(folder, comm, exchange, {1e-3: SCHILLER_NAUMANN[1e-3]})


@check("carried")
def carried(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Ten steps from rest in a wind, a step a ninth of the smallest's response time: the drag of a step is felt in that
    step, or a tenth of the speed is missing."""
    still = {"gravity": 0.0, "exchange": {"drag": "schiller-naumann"}}
    velocities = _release(folder, comm, np.array(list(_CARRIED)), still, 10, _WIND)
    for (diameter, speed), found in zip(_CARRIED.items(), velocities.tolist(), strict=True):
        yield Number(f"speed of {diameter * 1e6:g} um in a wind", found, speed, 0.01, "m s-1", relative=True)


@check("terminal-velocity-paper")
def terminal_velocity_paper(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """1 mm with the paper's law and the default scheme."""
    yield from fall(folder, comm, {}, _PAPER)

"""Gas through an inlet that is no level floor, against the case's velocity times its area; and a ramp of many rows."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.geometry.block import make_block
from fbcouple.geometry.cylinder import make_cylinder
from fbcouple.geometry.foam_files import write_polymesh
from fbcouple.geometry.polymesh import PolyMesh
from fbcouple.simulation.loop import step
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, open_bench
from fbcouple.verify.registry import Number, check

_SPEED, _STEPS = 0.8, 12
_SIDE, _LENGTH, _TILT = 0.012, 0.024, math.radians(30.0)
_DIAMETER = 0.016
_MESH = "mesh"


def _tilt(points: np.ndarray) -> np.ndarray:
    """Points (n, 3) turned by 30 degrees about the y axis, up towards x."""
    x, y, z = points.T
    return np.column_stack([x * math.cos(_TILT) + z * math.sin(_TILT), y, z * math.cos(_TILT) - x * math.sin(_TILT)])


def _make_tilted() -> tuple[PolyMesh, np.ndarray, float]:
    """A leaning column, beads that lie over its inlet, and the inlet's area."""
    mesh = make_block((_SIDE, _SIDE, _LENGTH), (4, 4, 8), "prisms")
    row = 1e-3 * (np.arange(10) + 1.5)
    x, y, z = np.meshgrid(row, row, row[:3] - 0.8e-3, indexing="ij")
    beads = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    return replace(mesh, points=_tilt(mesh.points)), _tilt(beads), _SIDE**2


def _make_ring() -> tuple[PolyMesh, np.ndarray, float]:
    """An upright cylinder whose gas comes in by the lower half of its wall, all around; beads inside; the wall's area,
    of a polygon."""
    across = 6
    mesh = make_cylinder(_DIAMETER, _LENGTH, across, 8, "prisms")
    (first, count), floor, top = mesh.patches["walls"], mesh.patches["inlet"], mesh.patches["outlet"]
    rows = mesh.faces.take(mesh.list_patch("walls"))
    heights = np.add.reduceat(mesh.points[rows.values, 2], rows.starts[:-1]) / rows.lengths
    low = heights < _LENGTH / 2
    order = np.arange(len(mesh.owner))
    order[first : first + count] = first + np.argsort(~low, kind="stable")
    ring = int(low.sum())
    patches = {"floor": floor, "outlet": top, "inlet": (first, ring), "walls": (first + ring, count - ring)}
    row = _DIAMETER / 2 + 1.1e-3 * np.arange(-3, 4)
    x, y, z = np.meshgrid(row, row, 1e-3 * (np.arange(6) + 0.7), indexing="ij")
    beads = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    sides = 3 * across
    area = sides * _DIAMETER * math.sin(math.pi / sides) * _LENGTH / 2
    return replace(mesh, faces=mesh.faces.take(order), owner=mesh.owner[order], patches=patches), beads, area


_INLETS = {"tilted": _make_tilted, "ring": _make_ring}


@check("inlet-faces", ranks=(2,), variants=tuple(_INLETS), judge=lambda found: (n for v in found.values() for n in v))
def inlet_faces(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """Through a plane inlet that leans by 30 degrees, and one that is a ring of the side wall, with beads before it:
    the gas that comes in, in each step, is the velocity times the area."""
    mesh, beads, area = _INLETS[variant]()
    size = (mesh.high - mesh.low).tolist()
    sections: dict[str, Any] = {
        "domain": {"shape": "file", "mesh": _MESH, "size": size, "cells": [4, 4, 8]},
        "gas": GAS | {"inlet_velocity": _SPEED, "pressure_tolerance": 1e-12, "correctors": 3, "max_step": 5e-4},
        "particles": GLASS,
        "contact": FRICTIONLESS,
        "exchange": {"filter_passes": 1},
    }
    if comm.rank == 0:
        write_polymesh(mesh, folder / _MESH)
    bench = open_bench(folder, comm, sections, beads, case_folder=folder)
    bench.initialise()
    off = lost = 0.0
    for _ in range(_STEPS):
        step(bench)
        assert bench.gas_report is not None
        off = max(off, abs(bench.gas_report.inflow / (_SPEED * area) - 1.0))
        lost = max(lost, bench.gas_report.lost / (_SPEED * area))
    least = comm.allreduce(float(bench.coupling.voidage.min()), MPI.MIN)
    yield Number(f"inflow over velocity times area, {variant}", off, 0.0, 1e-12)
    yield Number(f"gas that is lost, of the inflow, {variant}", lost, 0.0, 1e-6)
    yield Number(f"beads lie before the inlet, {variant}", float(least < 0.8), 1.0, 0.0)


_ROWS, _PERIOD, _PER_ROW = 1000, 0.5, 2


@check("inlet-table")
def inlet_table(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A sine of 1000 rows about a mean, and a jump after it: the gas of a whole period is the table's integral, for
    steps that divide its rows; each step has the table's value at its end."""
    times = np.linspace(0.0, _PERIOD, _ROWS)
    velocities = 0.3 + 0.2 * np.sin(2.0 * math.pi * times / _PERIOD)
    dt, area = _PERIOD / (_ROWS - 1) / _PER_ROW, 0.01**2
    jump = _PERIOD + dt / 2
    rows = [*zip(times.tolist(), velocities.tolist(), strict=True), (jump, float(velocities[-1])), (jump, -0.1)]
    domain = {"size": [0.01, 0.01, 0.02], "cells": [2, 2, 4]}
    gas = GAS | {"inlet_velocity": None, "inlet_ramp": [list(row) for row in rows], "walls": "slip"}
    bench = open_bench(folder, comm, {"domain": domain, "gas": gas})
    found = []
    for _ in range(_PER_ROW * (_ROWS - 1) + 1):
        bench.gas.step(dt, *bench.gas.clean_input)
        found.append(bench.gas.measure().inflow / area)
    ends = dt * np.arange(1, len(found))
    off = np.abs(np.array(found[:-1]) - np.interp(ends, times, velocities)).max()
    yield Number("largest deviation from the table", float(off), 0.0, 1e-9, "m s-1")
    integral = float(((velocities[1:] + velocities[:-1]) / 2 * np.diff(times)).sum())
    yield Number("gas of a period", float(sum(found[:-1])) * dt, integral, 1e-9, "m", relative=True)
    yield Number("after the jump", found[-1], -0.1, 1e-12, "m s-1")

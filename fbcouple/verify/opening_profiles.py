"""Inlets whose velocity a file says, against integrals by hand; and gas that comes back in by the outlet."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.harness import GAS, open_bench
from fbcouple.verify.registry import Number, check

_SIZE, _CELLS = (0.021, 0.021, 0.04), (6, 6, 8)
_STEP, _PER_INLET = 2e-3, 2
_SLOT = ((0.0023, 0.0031), (0.0101, 0.0187))
_PORT = ((0.0029, 0.0062), (0.0151, 0.0244))
_RADIUS = 0.0038
_ROWS = 41


def _write_files(folder: Path) -> tuple[list[dict[str, Any]], list[tuple[float, float]]]:
    """The inlets, and of each the mean and the largest velocity of its file.

    A slot with 1 + 2 s, s from 0 to 1 across it: mean 2. A port with a + b y + c z at scattered points, which triangles
    give exactly: mean in its middle. A pipe with 2 (1 - r/R): mean 2/3.
    """
    (x0, _), (x1, _) = _SLOT
    across = np.linspace(0.0, 1.0, _ROWS)
    _write(folder / "slot.csv", "x [mm],velocity", 1e3 * (x0 + across * (x1 - x0)), 1.0 + 2.0 * across)
    (a0, b0), (a1, b1) = _PORT
    corners = np.array([[a0, b0], [a1, b0], [a1, b1], [a0, b1]])
    inner = np.random.default_rng(3).uniform(corners.min(axis=0), corners.max(axis=0), (60, 2))
    y, z = np.concatenate([corners, inner]).T
    _write(folder / "port.csv", "y,z,velocity", y, z, 1.0 + 50.0 * y + 100.0 * z)
    radius = np.linspace(0.0, _RADIUS, _ROWS)
    _write(folder / "pipe.csv", "radius,velocity", radius, 2.0 * (1.0 - radius / _RADIUS))
    tables: list[dict[str, Any]] = [
        {"rectangle": [list(corner) for corner in _SLOT], "profile_file": "slot.csv"},
        {"rectangle": [list(corner) for corner in _PORT], "profile_file": "port.csv", "face": "right"},
        {"circle": [0.0158, 0.0106, 2.0 * _RADIUS], "profile_file": "pipe.csv"},
    ]
    middle = 1.0 + 25.0 * (a0 + a1) + 50.0 * (b0 + b1)
    return tables, [(2.0, 3.0), (middle, 1.0 + 50.0 * a1 + 100.0 * b1), (2.0 / 3.0, 2.0)]


def _write(path: Path, head: str, *columns: np.ndarray) -> None:
    np.savetxt(path, np.column_stack(columns), fmt="%.17g", delimiter=",", header=head, comments="")


def _pulse(number: int, velocity: float) -> list[list[float]]:
    """Inlet `number` alone lets gas in, for `_PER_INLET` steps."""
    start = (number * _PER_INLET + 0.5) * _STEP
    end = start + _PER_INLET * _STEP
    return [[start, 0.0], [start, velocity], [end, velocity], [end, 0.0]]


@check(
    "openings-profile",
    ranks=(2,),
    variants=("box", "tetrahedra"),
    judge=lambda found: (n for v in found.values() for n in v),
)
def openings_profile(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """A slot, a port and a pipe, whose velocities files say, along no edge of cells, each open in its turn: the flow is
    the given mean times the area; as the files have it, mean and largest are the integrals by hand."""
    tables, wanted = comm.bcast(_write_files(folder) if comm.rank == 0 else None)
    inlets = [table | {"ramp": _pulse(number, 1.0 + number)} for number, table in enumerate(tables)]
    gas = GAS | {"inlet_velocity": None, "inlets": inlets, "walls": "slip", "pressure_tolerance": 1e-10}
    domain = {"size": list(_SIZE), "cells": list(_CELLS)} | ({} if variant == "box" else {"elements": variant})
    bench = open_bench(folder, comm, {"domain": domain, "gas": gas}, case_folder=folder)
    assert bench.case.gas is not None
    areas = [math.prod(np.subtract(high, low).tolist()) for low, high in (_SLOT, _PORT)] + [math.pi * _RADIUS**2]
    for number, (inlet, area, (mean, most)) in enumerate(
        zip(bench.case.gas.inlets, areas, wanted, strict=True), start=1
    ):
        flows = [_step(bench) for _ in range(_PER_INLET)]
        off = max(abs(flow / (number * area) - 1.0) for flow in flows)
        yield Number(f"flow of inlet {number} over mean times area, {variant}", off, 0.0, 1e-12)
        yield Number(f"largest over mean of inlet {number}, {variant}", inlet.peak or 0.0, most / mean, 1e-9)


def _step(bench: Simulation) -> float:
    bench.gas.step(_STEP, *bench.gas.clean_input)
    return bench.gas.measure().inflow


_JET, _SIDE = 8.0, 0.003


@check("openings-backflow", ranks=(2,))
def openings_backflow(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A jet below a top of two outlets drags gas in by them: what goes out there less what comes in is what the jet
    brings. Then the jet sucks: all of its gas, and more, comes in by the top."""
    middle = 0.0105
    rectangle = [[middle - _SIDE / 2, middle - _SIDE / 2], [middle + _SIDE / 2, middle + _SIDE / 2]]
    turn = 40.5 * 2e-4
    ramp = [[0.0, _JET], [turn, _JET], [turn, -0.1]]
    gas = GAS | {
        "inlet_velocity": None,
        "inlets": [{"rectangle": rectangle, "ramp": ramp}],
        "outlets": [{"rectangle": [[0.0, 0.0], [0.009, 0.021]]}, {"rectangle": [[0.009, 0.0], [0.021, 0.021]]}],
        "pressure_tolerance": 1e-12,
    }
    domain = {"size": [0.021, 0.021, 0.02], "cells": [7, 7, 6]}
    bench = open_bench(folder, comm, {"domain": domain, "gas": gas | {"walls": "slip"}})
    flow = _JET * _SIDE**2
    for _ in range(40):
        bench.gas.step(2e-4, *bench.gas.clean_input)
    state = bench.gas.measure()
    yield Number("gas out less gas in by the top, of the jet", (state.outflow - state.backflow) / flow, 1.0, 1e-9)
    (out, back), (other_out, other_back) = bench.gas.measure_outlets(2).tolist()
    yield Number("gas out by both outlets, of that by the top", (out + other_out) / state.outflow, 1.0, 1e-12)
    yield Number("gas in by both outlets, of that by the top", (back + other_back) / state.backflow, 1.0, 1e-12)
    yield Number("the outlet above the jet has more of what goes out", float(other_out > 2.0 * out), 1.0, 0.0)
    yield Number("gas comes back in by the top", float(state.backflow > 0.05 * flow), 1.0, 0.0)
    for _ in range(2):
        bench.gas.step(2e-4, *bench.gas.clean_input)
    state = bench.gas.measure()
    yield Number(
        "gas in less gas out by the top, of what the inlet sucks",
        (state.backflow - state.outflow) / (0.1 * _SIDE**2),
        1.0,
        1e-9,
    )

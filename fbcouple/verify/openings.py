"""Gas through inlets that are given in metres and cut the cells, against velocity times area, on boxes of hexahedra and
tetrahedra, on a cylinder, and by patches of a mesh from a file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.geometry.block import make_block
from fbcouple.geometry.foam_files import write_polymesh
from fbcouple.geometry.sides import list_polygons
from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.harness import GAS, open_bench
from fbcouple.verify.registry import Number, check

_SIZE, _CELLS = (0.021, 0.021, 0.04), (6, 6, 8)
_STEP, _PER_INLET = 2e-3, 2
_JET: dict[str, Any] = {"circle": [0.0098, 0.0113, 0.0067]}
_BACKGROUND: dict[str, Any] = {"rectangle": [[0.0041, 0.0052], [0.0171, 0.0163]]}
_PORT: dict[str, Any] = {"circle": [0.0109, 0.0131, 0.0081], "face": "right", "profile": "parabolic"}
_INLETS = {"box": [_BACKGROUND, _JET, _PORT], "tetrahedra": [_BACKGROUND, _JET, _PORT], "cylinder": [_BACKGROUND, _JET]}
_SHAPES: dict[str, dict[str, Any]] = {
    "box": {"periodic": ["y"]},
    "tetrahedra": {"elements": "tetrahedra"},
    "cylinder": {"shape": "cylinder"},
}


def _find_expected() -> list[float]:
    """Areas [m2] that the inlets have, the circle being wholly within the rectangle."""
    jet = math.pi * 0.0067**2 / 4.0
    return [0.013 * 0.0111 - jet, jet, math.pi * 0.0081**2 / 4.0]


def _pulse(number: int) -> list[list[float]]:
    """Inlet `number` alone lets gas in, for `_PER_INLET` steps."""
    start = number * _PER_INLET * _STEP + 0.5 * _STEP
    end = start + _PER_INLET * _STEP
    return [[start, 0.0], [start, 1.0], [end, 1.0], [end, 0.0]]


def _step(bench: Simulation) -> float:
    bench.gas.step(_STEP, *bench.gas.clean_input)
    return bench.gas.measure().inflow


@check("openings", ranks=(2,), variants=tuple(_INLETS), judge=lambda found: (n for v in found.values() for n in v))
def openings(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """A rectangle with a circle on it, and a circle in the side with a parabolic profile, none along the edges of
    cells, each open in its turn: what comes in is the velocity times the area, and what the case says."""
    inlets = [table | {"ramp": _pulse(number)} for number, table in enumerate(_INLETS[variant])]
    gas = GAS | {"inlet_velocity": None, "inlets": inlets, "walls": "slip", "pressure_tolerance": 1e-10}
    domain = {"size": list(_SIZE), "cells": list(_CELLS)} | _SHAPES[variant]
    bench = open_bench(folder, comm, {"domain": domain, "gas": gas})
    assert bench.case.gas is not None
    for number, (table, area) in enumerate(zip(bench.case.gas.inlets, _find_expected(), strict=False), start=1):
        flows = [_step(bench) for _ in range(_PER_INLET)]
        off = max(abs(flow / area - 1.0) for flow in flows)
        yield Number(f"flow of inlet {number} over velocity times area, {variant}", off, 0.0, 1e-12)
        yield Number(f"area of inlet {number} in the case, {variant}", table.area or 0.0, area, 1e-12, relative=True)


_JET_CELLS = ((2, 4), (2, 4))
"""Cells of the floor, along x and y, that the jet has: in metres the same."""
_SPEEDS = 0.4, 3.0


def _compare(found: dict[str, list[Number]]) -> Iterator[Number]:
    background, jet = _SPEEDS
    area, small = 0.021**2, (2 * 0.0035) ** 2
    wanted = background * (area - small) + jet * small
    for name, numbers in found.items():
        yield Number(f"inflow, {name}", numbers[0].value, wanted, 1e-12, "m3 s-1", relative=True)
    value, expected = found["patches"][1].value, found["tables"][1].value
    yield Number("velocity over the jet, patches against tables", value, expected, 1e-9, "m s-1", relative=True)


@check("openings-of-mesh", variants=("tables", "patches"), judge=_compare)
def openings_of_mesh(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """A jet in a background of gas, in metres in a box of prisms, and by patches of the same prisms as a mesh from a
    file: the same flow."""
    background, jet = _SPEEDS
    (x0, x1), (y0, y1) = (np.array(cells) * 0.0035 for cells in _JET_CELLS)
    domain: dict[str, Any] = {"size": list(_SIZE), "cells": list(_CELLS)}
    inlets: list[dict[str, Any]] = [
        {"rectangle": [[0.0, 0.0], [0.021, 0.021]], "velocity": background},
        {"rectangle": [[float(x0), float(y0)], [float(x1), float(y1)]], "velocity": jet},
    ]
    if variant == "tables":
        domain |= {"elements": "prisms"}
    else:
        domain |= {"shape": "file", "mesh": "mesh"}
        inlets = [{"patches": ["floor"], "velocity": background}, {"patches": ["jet*"], "velocity": jet}]
        _write_mesh(folder, comm)
    gas = GAS | {"inlet_velocity": None, "inlets": inlets, "pressure_tolerance": 1e-12}
    bench = open_bench(folder, comm, {"domain": domain, "gas": gas}, case_folder=folder)
    inflow = 0.0
    for _ in range(20):
        inflow = _step_short(bench)
    across = np.abs(bench.gas.centres[:, :2] - 0.0105).max(axis=1)
    yield Number("inflow", inflow, 0.0, 1.0)
    yield Number("velocity over the jet", float(bench.gas.velocity[across < 0.0035, 2].mean()), 0.0, 100.0)


def _step_short(bench: Simulation) -> float:
    bench.gas.step(2e-4, *bench.gas.clean_input)
    return bench.gas.measure().inflow


def _write_mesh(folder: Path, comm: MPI.Comm) -> None:
    """The box as a polyMesh folder whose floor has the patches floor and jet-1."""
    if comm.rank:
        return
    mesh = make_block(_SIZE, _CELLS, "prisms")
    floor = mesh.list_patch("inlet")
    (x0, x1), (y0, y1) = (np.array(cells) * 0.0035 for cells in _JET_CELLS)
    centres = np.array([polygon.mean(axis=0) for polygon in list_polygons(mesh, floor, "floor")])
    inside = np.all((centres > [x0, y0]) & (centres < [x1, y1]), axis=1)
    order = np.arange(len(mesh.owner))
    order[floor] = np.concatenate([floor[~inside], floor[inside]])
    first, rest = int(floor[0]), int((~inside).sum())
    patches = {"floor": (first, rest), "jet-1": (first + rest, int(inside.sum()))}
    patches |= {"outlet": mesh.patches["outlet"], "walls": mesh.patches["walls"]}
    faces, owner = mesh.faces.take(order), mesh.owner[order]
    write_polymesh(type(mesh)(mesh.points, faces, owner, mesh.neighbour, patches), folder / "mesh")

"""Gas alone, voidage 1, against closed forms and published numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.harness import open_bench
from fbcouple.verify.registry import Number, check

Edits = dict[str, Callable[[str], str]]
_PATCHES = ("inlet", "outlet", "walls")


def set_patches(entries: dict[str, str]) -> Callable[[str], str]:
    """Give a field file these boundary entries, patch by patch."""

    def change(text: str) -> str:
        body = "".join(f"    {patch}\n    {{\n        {entry}\n    }}\n" for patch, entry in entries.items())
        return text[: text.index("boundaryField")] + "boundaryField\n{\n" + body + "}\n"

    return change


def close_box(velocity: str, lid: str | None = None) -> Edits:
    """Deck edits that close the box: walls all around, `velocity` at each, `lid` in its place at the top."""
    top = lid or velocity
    return {
        "CFD/system/blockMeshDict": lambda text: text.replace("type    patch;", "type    wall;"),
        "CFD/0/U": set_patches({"inlet": velocity, "outlet": top, "walls": velocity}),
        "CFD/0/p": set_patches(dict.fromkeys(_PATCHES, "type zeroGradient;")),
    }


def split_sides(edits: Edits) -> Edits:
    """The walls across y become a slip patch of their own: a flow in the plane x-z."""

    def split(text: str) -> str:
        across = "(0 1 5 4) (3 7 6 2)"
        sides = f"    sides\n    {{\n        type    wall;\n        faces   ({across});\n    }}\n);\n"
        head, tail = text.replace(f" {across}", "").rsplit(");\n", 1)
        return head + sides + tail

    def with_sides(name: str, entry: str) -> Callable[[str], str]:
        edit = edits.get(name, lambda text: text)

        def change(text: str) -> str:
            head, tail = edit(text).rsplit("}", 1)
            return head + f"    sides\n    {{\n        {entry}\n    }}\n}}" + tail

        return change

    fields = {"CFD/0/U": "type slip;", "CFD/0/p": "type zeroGradient;", "CFD/0/voidage": "type zeroGradient;"}
    mesh = edits.get("CFD/system/blockMeshDict", lambda text: text)
    split_mesh: Edits = {"CFD/system/blockMeshDict": lambda text: split(mesh(text))}
    return split_mesh | {name: with_sides(name, entry) for name, entry in fields.items()}


def run_until_steady(bench: Simulation, dt: float, most: int, change: float) -> None:
    gas = bench.gas
    assert gas is not None
    before = np.array(gas.velocity)
    for step in range(1, most + 1):
        gas.step(dt, *gas.clean_input)
        if step % 50 == 0:
            if np.abs(gas.velocity - before).max() < change * 50 * dt * np.abs(before).max():
                return
            before = np.array(gas.velocity)


def _as_plane(bench: Simulation, values: np.ndarray) -> np.ndarray:
    """Cell values of a 2-D check as (z, x)."""
    nx, _, nz = bench.grid.cells
    plane = np.empty((nz, nx))
    plane[bench.owned[:, 2], bench.owned[:, 0]] = values
    return plane


@check("poiseuille")
def poiseuille(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Plane channel at Re 10: far from the inlet the middle has 1.5 x the mean velocity, dp/dz = -12 mu U/h^2."""
    width, length, cells, speed, viscosity = 0.01, 0.03, (32, 1, 48), 0.02, 2e-5
    domain = {"size": [width, width / 32, length], "cells": list(cells)}
    gas = {"density": 1.0, "viscosity": viscosity, "inlet_velocity": speed}
    bench = open_bench(folder, comm, {"domain": domain, "gas": gas}, edits=split_sides({}))
    run_until_steady(bench, dt=5e-3, most=2000, change=1e-4)
    profile = _as_plane(bench, bench.gas.velocity[:, 2])[-8]
    x = (np.arange(cells[0]) + 0.5) / cells[0]
    exact = 6.0 * speed * x * (1.0 - x)
    yield Number(
        "largest deviation of the profile over its peak", np.abs(profile - exact).max() / exact.max(), 0.0, 0.01
    )
    gradient = _as_plane(bench, bench.gas.pressure_gradient[:, 2])[-8].mean()
    yield Number(
        "pressure gradient", float(gradient), -12.0 * viscosity * speed / width**2, 0.01, "Pa m-1", relative=True
    )


@check("slip-walls")
def slip_walls(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Walls that let the gas slip leave plug flow as it is, at no pressure (walls that hold it: poiseuille)."""
    speed = 0.05
    depth, viscosity = 0.001, 1e-4
    domain = {"size": [0.01, depth, 0.02], "cells": [16, 1, 16]}
    gas = {"density": 1.0, "viscosity": viscosity, "inlet_velocity": speed, "walls": "slip"}
    gas |= {"pressure_tolerance": 1e-11}
    bench = open_bench(folder, comm, {"domain": domain, "gas": gas})
    for _ in range(300):
        bench.gas.step(2e-3, *bench.gas.clean_input)
    # What is left of the first step, when nothing flows through the outlet yet, still dies out.
    deviation = float(np.abs(bench.gas.velocity - [0.0, 0.0, speed]).max())
    yield Number("largest deviation from plug flow over its velocity", deviation / speed, 0.0, 1e-6)
    gradient = float(np.abs(bench.gas.pressure_gradient).max())
    scale = 12.0 * viscosity * speed / depth**2
    yield Number("largest pressure gradient over that between walls that hold the gas", gradient / scale, 0.0, 1e-6)


# Ghia, Ghia and Shin 1982, J. Comput. Phys. 48:387, tables I and II at Re 100: (place, velocity over the lid's).
_GHIA_U = (
    (0.0547, -0.03717), (0.0625, -0.04192), (0.0703, -0.04775), (0.1016, -0.06434), (0.1719, -0.10150),
    (0.2813, -0.15662), (0.4531, -0.21090), (0.5000, -0.20581), (0.6172, -0.13641), (0.7344, 0.00332),
    (0.8516, 0.23151), (0.9531, 0.68717), (0.9609, 0.73722), (0.9688, 0.78871), (0.9766, 0.84123),
)  # fmt: skip
_GHIA_V = (
    (0.0625, 0.09233), (0.0703, 0.10091), (0.0781, 0.10890), (0.0938, 0.12317), (0.1563, 0.16077),
    (0.2266, 0.17507), (0.2344, 0.17527), (0.5000, 0.05454), (0.8047, -0.24533), (0.8594, -0.22445),
    (0.9063, -0.16914), (0.9453, -0.10313), (0.9531, -0.08864), (0.9609, -0.07391), (0.9688, -0.05906),
)  # fmt: skip


@check("cavity", fast=False)
def cavity(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Lid-driven cavity at Re 100, 64 x 64 cells: both centrelines against Ghia 1982, within 1 % of the lid's speed."""
    cells = 64
    domain = {"size": [1.0, 1.0 / cells, 1.0], "cells": [cells, 1, cells]}
    gas = {"density": 1.0, "viscosity": 0.01, "inlet_velocity": 0.0}
    lid = "type fixedValue; value uniform (1 0 0);"
    bench = open_bench(folder, comm, {"domain": domain, "gas": gas}, edits=split_sides(close_box("type noSlip;", lid)))
    run_until_steady(bench, dt=0.01, most=3000, change=1e-4)
    u, v = (_as_plane(bench, bench.gas.velocity[:, axis]) for axis in (0, 2))
    middle = cells // 2
    centres = (np.arange(cells) + 0.5) / cells
    along_z, along_x = u[:, middle - 1 : middle + 1].mean(axis=1), v[middle - 1 : middle + 1].mean(axis=0)
    for name, line, table in (("u on the vertical", along_z, _GHIA_U), ("v on the horizontal", along_x, _GHIA_V)):
        place_, published = np.array(table).T
        deviation = np.abs(np.interp(place_, centres, line) - published).max()
        yield Number(f"largest deviation of {name} centreline", float(deviation), 0.0, 0.01)

"""Heat of gas and particles against closed forms: spheres in a stream, fronts, walls, stiff exchange, the ledger."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.harness import GAS, GLASS, open_bench, take_same_step
from fbcouple.verify.registry import Number, check, name_variants

HEAT: dict[str, Any] = {"gas_temperature": 300.0, "gas_specific_heat": 1000.0, "gas_conductivity": 0.026}
WARM: dict[str, Any] = {"particle_temperature": 350.0, "particle_specific_heat": 800.0}

_QUICK = {0.5: 346.486, 1.0: 329.301, 2.0: 311.089}
# Conductivity and specific heat of the gas that a sphere is in, its temperatures [K] at times [s], coarse graining.
_STREAMS: dict[str, tuple[float, float, dict[float, float], float | None]] = {
    "0.052 W/(m K)": (0.051865, 999.06, _QUICK, None),
    "0.026 W/(m K)": (0.026, 1007.0, {1.0: 341.727, 2.0: 323.470, 5.0: 303.117}, None),
    "a parcel of 8": (0.051865, 999.06, _QUICK, 2.0),
}


def hold(bench: Simulation, dt: float) -> None:
    """One coupling step of `dt` [s] in which no particle moves, and none is pushed (collective)."""
    bench.clock.substeps, bench.clock.dt = 1, dt
    bench.deposit_drag()
    bench.deposit_heat()
    bench.step_gas()
    bench.apply_gas_heat()
    if bench.heat and bench.has_particles:
        bench.heat.close_ledger()
    bench.clock.tick()


def _judge_streams(measured: dict[str, list[Number]]) -> Iterator[Number]:
    for numbers in measured.values():
        yield from numbers


@check("heat-sphere", variants=tuple(_STREAMS), judge=_judge_streams)
def heat_sphere(folder: Path, comm: MPI.Comm, gas: str) -> Iterator[Number]:
    """A sphere held in a stream cools as exp(-h A t/(m cp)), by Ranz and Marshall, within 1e-4 of the difference at the
    start; of two gases, and as a parcel. Its cells are wide, so that the gas that it heats is 1e-5 of what passes."""
    conductivity, specific_heat, expected, ratio = _STREAMS[gas]
    cells, edge, start, stream = [3, 3, 6], 0.5, 373.15, 298.15
    sections = {
        "gravity": 0.0,
        "domain": {"size": [edge * n for n in cells], "cells": cells},
        "gas": {"density": 1.1854, "viscosity": 1.8603e-5, "inlet_velocity": 6.0, "walls": "slip"},
        "particles": {"diameter": 3.6e-3, "density": 8850.0} | ({"coarse_graining": ratio} if ratio else {}),
        "exchange": {"drag": "schiller-naumann"},
        "heat": {
            "gas_temperature": stream,
            "particle_temperature": start,
            "gas_specific_heat": specific_heat,
            "gas_conductivity": conductivity,
            "particle_specific_heat": 55.0,
            "nusselt": "ranz-marshall",
        },
    }
    bench = open_bench(folder, comm, sections, np.array([[0.75, 0.75, 1.75]]))
    bench.initialise()
    taken, dt = 0, 0.05
    for time, temperature in expected.items():
        while taken < round(time / dt):
            hold(bench, dt)
            taken += 1
        found = float(bench.liggghts.temperatures[0])
        yield Number(f"{gas}: temperature at {time:g} s", found, temperature, 1e-4 * (start - stream), "K")


_FRONT_CELLS = (32, 64, 128)


def _judge_front(measured: dict[str, list[Number]]) -> Iterator[Number]:
    errors = [numbers[0].value for numbers in measured.values()]
    for (coarse, fine), cells in zip(itertools.pairwise(errors), _FRONT_CELLS[1:], strict=True):
        order = math.log2(coarse / fine)
        yield Number(f"order of the front from {cells // 2} to {cells} cells", order, 2.0, 0.35)
    yield Number("error of the front on the finest mesh, over its jump", errors[-1], 0.0, 2e-3)


@check("heat-front", variants=tuple(map(str, _FRONT_CELLS)), judge=_judge_front)
def heat_front(folder: Path, comm: MPI.Comm, cells: str) -> Iterator[Number]:
    """A smooth front goes with the gas: second order in the cell, the step as its square."""
    count, height, speed, jump, width = int(cells), 1.0, 1.0, 20.0, 0.1
    start, time = 0.35, 0.3

    def front(z: np.ndarray) -> np.ndarray:
        return 300.0 + 0.5 * jump * (1.0 + np.tanh((z - start) / width))

    centres = (np.arange(count) + 0.5) * height / count
    inside = "\n".join(repr(value) for value in front(centres).tolist())
    sections = {
        "domain": {"size": [height / count, height / count, height], "cells": [1, 1, count]},
        "gas": GAS | {"inlet_velocity": speed, "walls": "slip", "pressure_tolerance": 1e-12},
        "heat": HEAT | {"gas_conductivity": 1e-9},
    }
    uniform = "internalField   uniform 300.0;"
    edits = {"CFD/0/T": lambda text: text.replace(uniform, f"internalField nonuniform List<scalar> {count}({inside});")}
    bench = open_bench(folder, comm, sections, edits=edits)
    steps = 10 * (count // 16) ** 2
    for _ in range(steps):
        hold(bench, time / steps)
    assert bench.heat is not None and bench.heat.gas is not None
    z = bench.gas.centres[:, 2]
    error = np.abs(bench.heat.gas.temperatures - front(z - speed * time)).mean() / jump
    yield Number("mean error", float(error), 0.0, 1.0)


@check("heat-walls")
def heat_walls(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Gas at rest between a wall at a temperature and one with a coefficient, adiabatic elsewhere: at last a straight
    line in the gas, and the flux of half a cell, the gas, and the coefficient one after the other."""
    cells, width, conductivity, hot, cold, coefficient = 8, 0.02, 0.026, 360.0, 300.0, 5.0
    area = 0.01 * 0.01
    sections = {
        "domain": {"size": [width, 0.01, 0.01], "cells": [cells, 1, 1]},
        "gas": GAS | {"top": "closed"},
        "heat": HEAT
        | {
            "walls": [
                {"face": "left", "temperature": hot},
                {"face": "right", "temperature": cold, "coefficient": coefficient},
            ]
        },
    }
    bench = open_bench(folder, comm, sections)
    for _ in range(12):
        hold(bench, 1e4)
    heat = bench.heat
    assert heat is not None and heat.gas is not None
    x, dx = bench.gas.centres[:, 0], width / cells
    flux = (hot - cold) / ((width - 0.5 * dx) / conductivity + 1.0 / coefficient)
    line = hot - flux / conductivity * x
    yield Number("largest deviation from the line", float(np.abs(heat.gas.temperatures - line).max()), 0.0, 1e-8, "K")
    left = abs(heat.flows["heat_by_walls"]) / (flux * area * 1e4)
    yield Number("heat that the walls leave in the gas, over what goes through", left, 0.0, 1e-10)


@check("heat-wall-coefficient")
def heat_wall_coefficient(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Gas at rest in one cell between two walls with a coefficient: T_w + (T_0 - T_w)/(1 + dt h A/(rho cp V))^n."""
    width, coefficient, wall, dt, steps = 0.01, 20.0, 340.0, 0.05, 40
    sections = {
        "domain": {"size": [width, 0.01, 0.01], "cells": [1, 1, 1]},
        "gas": GAS | {"top": "closed"},
        "heat": HEAT
        | {"walls": [{"face": face, "temperature": wall, "coefficient": coefficient} for face in ("left", "right")]},
    }
    bench = open_bench(folder, comm, sections)
    for _ in range(steps):
        hold(bench, dt)
    assert bench.heat is not None and bench.heat.gas is not None
    rate = 2.0 * coefficient / (GAS["density"] * HEAT["gas_specific_heat"] * width)
    expected = wall - (wall - 300.0) / (1.0 + rate * dt) ** steps
    yield Number("temperature", float(bench.heat.gas.temperatures[0]), expected, 1e-9, "K")


_BED = {
    "domain": {"size": [0.02, 0.01, 0.03], "cells": [5, 3, 8]},
    "particles": GLASS | {"count": 900},
    "contact": {"restitution": 0.9, "wall_restitution": 0.9, "friction": 0.0, "wall_friction": 0.0},
    "start": {},
    "exchange": {"filter_passes": 1},
}


@check("heat-stiff")
def heat_stiff(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Steps of 2500 times the time in which particles take the gas's temperature, in a closed box: at once all are at
    the mean temperature, between the two that they had, and no heat is lost."""
    sections = _BED | {"gravity": 0.0, "gas": GAS | {"top": "closed"}, "heat": HEAT | WARM}
    bench = open_bench(folder, comm, sections)
    bench.initialise()
    heat = bench.heat
    assert heat is not None and heat.gas is not None
    own = bench.liggghts
    d, cp = GLASS["diameter"], WARM["particle_specific_heat"]
    tau = GLASS["density"] * cp * d**2 / (6.0 * 2.0 * HEAT["gas_conductivity"])
    lowest, highest, errors = [], [], []
    for _ in range(20):
        hold(bench, 2500.0 * tau)
        both = np.concatenate([own.temperatures, heat.gas.temperatures])
        lowest.append(comm.allreduce(float(both.min()), min))
        highest.append(comm.allreduce(float(both.max()), max))
        errors.append(heat.error)
    solids = comm.allreduce(float(own.masses.sum())) * cp
    gas = comm.allreduce(float((bench.coupling.voidage * bench.gas.volumes).sum()))
    gas *= GAS["density"] * HEAT["gas_specific_heat"]
    mean = (solids * 350.0 + gas * 300.0) / (solids + gas)
    yield Number("lowest temperature below that of the gas at the start", max(0.0, 300.0 - min(lowest)), 0.0, 1e-9, "K")
    yield Number("highest above that of the particles", max(0.0, max(highest) - 350.0), 0.0, 1e-9, "K")
    yield Number("hottest at the end", highest[-1], mean, 1e-6, "K")
    yield Number("coldest at the end", lowest[-1], mean, 1e-6, "K")
    yield Number("largest error of a step's ledger", max(errors), 0.0, 1e-12)


# Zehner and Schlunder's bed of 0.026 and 1.4 W/(m K) at voidage 1 - pi/6, by hand [W/(m K)].
_CUBIC_BED = 0.14849992


def _name_areas(measured: dict[str, list[Number]]) -> Iterator[Number]:
    for area, numbers in measured.items():
        yield from (replace(number, name=f"coefficient on the {area}: {number.name}") for number in numbers)


@check("heat-bed-conductivity", variants=("whole", "gas"), judge=_name_areas)
def heat_bed_conductivity(folder: Path, comm: MPI.Comm, area: str) -> Iterator[Number]:
    """A cubic bed at rest between a hot side and one with a coefficient, on all of it or the share of the gas, has the
    line of Zehner and Schlunder's bed.

    Particles are seen in the cell of their centre: where they are shared among cells they carry heat from one to the
    next (docs/theory/heat.md).
    """
    n, d, hot, cold, coefficient = 10, GLASS["diameter"], 360.0, 300.0, 20.0
    axis = (np.arange(n) + 0.5) * d
    lattice = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    walls = [
        {"face": "left", "temperature": hot},
        {"face": "right", "temperature": cold, "coefficient": coefficient},
    ]
    sections = _BED | {
        "domain": {"size": [n * d] * 3, "cells": [5, 5, 5]},
        "particles": GLASS,
        "gravity": 0.0,
        "gas": GAS | {"top": "closed"},
        "heat": HEAT
        | WARM
        | {"particle_conductivity": 1.4, "bed_conduction": "zehner-schlunder", "walls": walls, "wall_area": area},
        "exchange": {"voidage": "centre"},
    }
    bench = open_bench(folder, comm, sections, lattice)
    bench.initialise()
    for _ in range(30):
        hold(bench, 1e4)
    assert bench.heat is not None and bench.heat.gas is not None
    x, length, share = bench.gas.centres[:, 0], n * d, 1.0 if area == "whole" else 1.0 - math.pi / 6.0
    flux = (hot - cold) / ((length - length / 10) / _CUBIC_BED + 1.0 / (share * coefficient))
    line = hot - flux / _CUBIC_BED * x
    found = comm.allreduce(float(np.abs(bench.heat.gas.temperatures - line).max()), max)
    yield Number("largest deviation from the line", found, 0.0, 1e-5, "K")


_MESHES: dict[str, dict[str, Any]] = {
    "hexahedra": {},
    "ideal gas": {},
    "tetrahedra": {"elements": "tetrahedra"},
    "cylinder": {"shape": "cylinder", "size": [0.02, 0.02, 0.03], "cells": [5, 5, 8]},
}


@check("heat-ledger", ranks=(1, 2), fast=False, variants=tuple(_MESHES), judge=name_variants)
def heat_ledger(folder: Path, comm: MPI.Comm, mesh: str) -> Iterator[Number]:
    """A fluidized bed that cools by gas, hot walls and a coefficient: in every step gas, particles, walls and openings
    add up."""
    walls: dict[str, Any] = {"wall_temperature": 320.0, "wall_coefficient": 50.0}
    if mesh == "ideal gas":
        walls["gas_density"] = "ideal"
    if mesh == "hexahedra":
        walls["walls"] = [{"face": "left", "temperature": 280.0}]
    sections = (
        _BED
        | {"domain": _BED["domain"] | _MESHES[mesh]}
        | {"gas": GAS | {"inlet_velocity": 1.0}, "heat": HEAT | WARM | walls}
    )
    bench = open_bench(folder, comm, sections)
    bench.initialise()
    heat = bench.heat
    assert heat is not None
    errors, given, warm = [], 0.0, comm.allreduce(heat.masses @ bench.liggghts.temperatures)
    for _ in range(60):
        take_same_step(bench)
        errors.append(heat.error)
        given += heat.flows["heat_given"]
    yield Number("largest error of a step's ledger", max(errors), 0.0, 1e-12)
    lost = comm.allreduce(heat.masses @ bench.liggghts.temperatures) - warm
    lost *= WARM["particle_specific_heat"]
    yield Number("heat that particles lost over what the gas took of them", lost / given, 1.0, 1e-7)

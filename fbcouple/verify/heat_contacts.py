"""Heat through contacts in LIGGGHTS, of spheres that are held in place, against closed forms."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.region import find_region
from fbcouple.case.bed.rest_overlap import find_rest_force
from fbcouple.case.schema.sections import Case
from fbcouple.decks.conduction import POISSON_RATIO
from fbcouple.physics.heat.contact_conduction import find_conductance, find_hertz_radius
from fbcouple.simulation import loop
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.temperatures import measure_heat
from fbcouple.verify.harness import FRICTIONLESS, open_bench
from fbcouple.verify.registry import Number, check

_DECK = "DEM/in.liggghts"
_EDGE = 0.02
# Two spheres of 3.0 mm, 420 kg/m3, 800 J/(kg K) and 3.6 mm, 8850 kg/m3, 55 J/(kg K), in contact by k a = 2.4415e-5 W/K:
# 0.08 and 0.4/3 W/(m K), whose harmonic mean is k = 0.1, and a circle of a = 0.24415 mm.
_DIAMETERS, _DENSITIES, _HEATS = (3.0e-3, 3.6e-3), (420.0, 8850.0), (800.0, 55.0)
_CONDUCTIVITIES, _RADIUS = (0.08, 0.4 / 3.0), 0.24415e-3
_STARTS = 298.15, 453.15
_TIMES = {10.0: (312.991, 447.221), 50.0: (354.959, 430.456)}
_STEP = 1e-3
_CHAIN, _COLD, _HOT = 10, 273.15, 323.15
_MODULUS, _PRESSED = 2e11, 0.05


def _hold(**numbers: str) -> dict[str, Callable[[str], str]]:
    """A deck whose particles do not move, with the rest of the lines of some fixes, by name, in place of its own."""

    def edit(deck: str) -> str:
        lines, found = [], {"motion"}
        for line in deck.splitlines():
            words = line.split()
            name = words[1] if words[:1] == ["fix"] else words[0] if words else ""
            if name == "motion":
                continue
            if name in numbers:
                found.add(name)
                line = " ".join([*words[: -len(numbers[name].split())], numbers[name]])  # noqa: PLW2901
            lines.append(line)
        assert found == {"motion", *numbers}, "the deck has none of these lines"
        return "\n".join(lines) + "\n"

    return {_DECK: edit}


def _place_pair(radii: tuple[float, float], gap: float) -> np.ndarray:
    """Centres [m] of two spheres whose distance is `gap`, in the middle of the box."""
    middle = np.full((2, 3), _EDGE / 2)
    middle[:, 0] += np.array([-0.5, 0.5]) * gap
    return middle


def _open_pair(folder: Path, comm: MPI.Comm, heat: dict[str, Any]) -> Simulation:
    radii = _DIAMETERS[0] / 2, _DIAMETERS[1] / 2
    gap = sum(math.sqrt(radius**2 - _RADIUS**2) for radius in radii)
    heat = {"particle_conductivity": _CONDUCTIVITIES[0], "particle_specific_heat": _HEATS[0]} | heat
    sections = {
        "gravity": 0.0,
        "domain": {"size": [_EDGE] * 3, "cells": [4, 4, 4]},
        "particles": {"diameter": _DIAMETERS[0], "density": _DENSITIES[0], "fractions": "number"}
        | {"mixture": [[_DIAMETERS[1], _DENSITIES[1], 0.5]]},
        "heat": {"particle_temperature": _STARTS[0]} | heat,
    }
    factor = 1.0 if heat["contact_conduction"] == "liggghts" else 1.0 / math.sqrt(math.pi)
    values = [factor * value for value in _CONDUCTIVITIES]
    edits = _hold(
        conductivity=" ".join(map(repr, [*values, values[0]])),
        capacity=" ".join(map(repr, [*_HEATS, _HEATS[0]])),
        timestep=repr(_STEP),
    )
    return open_bench(folder, comm, sections, _place_pair(radii, gap), edits, kinds=np.array([0, 1]))


def _warm_pair(folder: Path, comm: MPI.Comm, law: str) -> Iterator[Number]:
    liggghts = _open_pair(folder, comm, {"contact_conduction": law}).liggghts
    liggghts.advance(0, first=True)
    liggghts.temperatures[:] = np.array(_STARTS)[liggghts.tags - 1]
    factor = 1.0 if law == "batchelor-obrien" else math.sqrt(math.pi)
    capacities = [
        math.pi / 6.0 * d**3 * density * heat for d, density, heat in zip(_DIAMETERS, _DENSITIES, _HEATS, strict=True)
    ]
    rates = [factor * 2.0 * 2.4415e-5 / capacity for capacity in capacities]
    total, time, (one, other) = sum(rates), 0.0, _STARTS
    for until, printed in _TIMES.items():
        liggghts.advance(round((until - time) / _STEP))
        time, decay = until, math.exp(-total * until)
        mean, apart = (rates[1] * one + rates[0] * other) / total, one - other
        expected = mean + rates[0] / total * apart * decay, mean - rates[1] / total * apart * decay
        found = liggghts.temperatures[np.argsort(liggghts.tags)]
        for name, value, wanted, print_ in zip(("light", "heavy"), found, expected, printed, strict=True):
            where = f"{name} sphere at {until:g} s"
            yield Number(f"temperature of the {where}", value, wanted, 1e-4 * abs(apart), "K")
            if law == "batchelor-obrien":
                yield Number(f"{where}, as printed", value, print_, 2e-2, "K")
    heat = float(np.array(capacities) @ found)
    yield Number("heat of both", heat, float(np.array(capacities) @ np.array(_STARTS)), 1e-12, "J", relative=True)


@check("heat-contact")
def heat_contact(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Two spheres of unlike size, density, heat and conductivity in contact, by 2 k a of Batchelor and O'Brien 1977:
    temperatures at 10 and 50 s within 1e-4 of their first difference; none of the heat is lost."""
    return _warm_pair(folder, comm, "batchelor-obrien")


@check("heat-contact-liggghts")
def heat_contact_liggghts(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """The same by LIGGGHTS' law, whose rates are the square root of pi as high."""
    return _warm_pair(folder, comm, "liggghts")


@check("heat-chain", ranks=(1, 2, 4))
def heat_chain(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Ten spheres in a row between walls of 0 and 50 C, on any number of ranks: a straight line, and at the walls
    the conductance of a sphere on a plane, 2^(1/2) of that between spheres."""
    diameter, overlap = 1e-3, 1e-5
    pitch = diameter - overlap
    x = diameter / 2 - overlap + pitch * np.arange(_CHAIN)
    sites = np.column_stack([x, np.full((_CHAIN, 2), _EDGE / 2)])
    walls = ({"face": "left", "temperature": _COLD}, {"face": "right", "temperature": _HOT})
    sections = {
        "gravity": 0.0,
        "domain": {"size": [float(x[-1] + diameter / 2 - overlap), _EDGE, _EDGE], "cells": [4, 4, 4]},
        "particles": {"diameter": diameter, "density": 1000.0},
        "heat": {"particle_temperature": 290.0, "particle_specific_heat": 10.0, "particle_conductivity": 1.0}
        | {"contact_conduction": "batchelor-obrien", "walls": walls},
    }
    liggghts = open_bench(folder, comm, sections, sites, _hold(timestep="2e-3")).liggghts
    liggghts.advance(0, first=True)
    liggghts.advance(20000)
    found = np.zeros(_CHAIN)
    found[liggghts.tags - 1] = liggghts.temperatures
    found = comm.allreduce(found)
    # Of circles in which the spheres overlap, and a sphere and a plane, not of their limit at no overlap.
    between = math.sqrt(0.25 * diameter**2 - 0.25 * pitch**2)
    beside = math.sqrt(0.25 * diameter**2 - (0.5 * diameter - overlap) ** 2)
    places = between / beside + np.arange(_CHAIN)
    line = _COLD + (_HOT - _COLD) * places / (places[-1] + places[0])
    yield Number("largest distance from the line", float(np.abs(found - line).max()), 0.0, 1e-8, "K")
    yield Number("conductance at a wall over that between spheres", beside / between, math.sqrt(2.0), 0.01)


@check("heat-modulus-hertz")
def heat_modulus_hertz(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Two spheres pressed together by 0.05 N, with springs of 1e8 Pa: they conduct by the Hertz radius of steel."""
    return _press(folder, comm, 1e8)


@check("heat-modulus-hertz-stiff")
def heat_modulus_hertz_stiff(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """The same with springs a hundred times as stiff, by which the overlap is 21 times smaller."""
    return _press(folder, comm, 1e10)


@check("heat-modulus-hooke")
def heat_modulus_hooke(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Two spheres pressed together by linear springs of 100 N/m with the force amid their bed at rest: they conduct by
    the Hertz radius of steel."""
    return _press(folder, comm, 100.0)


@check("heat-modulus-hooke-stiff")
def heat_modulus_hooke_stiff(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """The same with springs a hundred times as stiff."""
    return _press(folder, comm, 1e4)


def _press(folder: Path, comm: MPI.Comm, stiffness: float) -> Iterator[Number]:
    """`stiffness`: a Young's modulus [Pa] from 1e6 on, a linear spring [N/m] below."""
    diameter, capacity, hertz = 2e-3, 10.0, stiffness > 1e6
    contact: dict[str, Any] = FRICTIONLESS | {"stiffness": stiffness}
    nu = POISSON_RATIO
    if hertz:
        contact = FRICTIONLESS | {"model": "hertz", "youngs_modulus": stiffness, "poisson_ratio": nu}
        contact["impact_speed"] = 1.0
    sections = {
        "gravity": 1e4,
        "domain": {"size": [_EDGE] * 3, "cells": [4, 4, 4]},
        "particles": {"diameter": diameter, "density": 8000.0},
        "contact": contact,
        "heat": {"particle_temperature": 300.0, "particle_specific_heat": capacity, "particle_conductivity": 42.0}
        | {"contact_conduction": "batchelor-obrien", "conduction_modulus": _MODULUS},
    }
    radius, modulus = diameter / 4.0, _MODULUS / (2.0 * (1.0 - nu**2))
    force = _PRESSED if hertz else _find_force(sections)
    own = stiffness / (2.0 * (1.0 - nu**2))
    overlap = (0.75 * force / (own * math.sqrt(radius))) ** (2.0 / 3.0) if hertz else force / stiffness
    bench = open_bench(folder, comm, sections, _place_pair((diameter / 2,) * 2, diameter - overlap), _hold())
    liggghts = bench.liggghts
    liggghts.advance(0, first=True)
    liggghts.temperatures[:] = np.array([300.0, 400.0])[liggghts.tags - 1]
    before = liggghts.temperatures.copy()
    liggghts.advance(1)
    assert bench.case.contact is not None and bench.case.particles is not None
    gained = float(np.abs(liggghts.temperatures - before).max()) * capacity * float(liggghts.masses[0])
    found = gained / (100.0 * bench.clock.dt / bench.clock.substeps)
    expected = find_conductance("batchelor-obrien", 42.0, 42.0, find_hertz_radius(force, radius, modulus))
    deep = (0.75 * force / (modulus * math.sqrt(radius))) ** (2.0 / 3.0) if hertz else overlap
    expected *= math.sqrt(1.0 - deep / (2.0 * diameter))  # the circle of two spheres over that of a small overlap
    yield Number("conductance", found, expected, 1e-6, "W K-1", relative=True)


def _find_force(sections: dict[str, Any]) -> float:
    """Force [N] in the middle of the bed at rest that the two spheres of `sections` would be."""
    data = {"title": "verify", "end_time": 1.0, "start": {}} | sections
    case = Case.model_validate(data | {"particles": sections["particles"] | {"count": 2}})
    return 0.5 * find_rest_force(case, find_region(case, Path()))


@check("heat-traffic")
def heat_traffic(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Warm particles rain on cold ones, conduct and leave below: what is held is what there was, came in and went."""
    heats = {"start": 300.0, "fed": 400.0}
    sections: dict[str, Any] = {
        "domain": {"size": [0.006, 0.006, 0.02], "cells": [2, 2, 4]},
        "particles": {"diameter": 1e-3, "density": 2500.0, "count": 50}
        | {"feeds": [{"low": [0, 0, 0.014], "high": [0.006, 0.006, 0.018], "rate": 1e4, "velocity": [0, 0, -1.0]}]}
        | {"outlets": [{"low": [0, 0, 0], "high": [0.002, 0.006, 0.001]}]},
        "contact": FRICTIONLESS | {"stiffness": 500.0},
        "start": {},
        "output": {"record_every": 1e-4},
        "heat": {"particle_temperature": heats["start"], "particle_specific_heat": 840.0}
        | {"particle_conductivity": 50.0, "contact_conduction": "liggghts"},
    }
    sections["particles"]["feeds"][0]["temperature"] = heats["fed"]
    bench = open_bench(folder, comm, sections)
    bench.initialise()
    assert bench.traffic is not None
    for _ in range(150):
        loop.step(bench)
    ledger, each = bench.traffic.ledger, 840.0 * float(bench.liggghts.masses[0])
    start = 50 * each * heats["start"]
    total = start + ledger.fed.heat
    held = comm.allreduce(measure_heat(bench.case, bench.liggghts))
    yield Number(
        "heat that came in", ledger.fed.heat, ledger.fed.count * each * heats["fed"], 1e-13, "J", relative=True
    )
    yield Number("held + gone - start - come, over all", (held + ledger.removed.heat - total) / total, 0.0, 1e-13)
    gone = ledger.removed.heat / (ledger.removed.count * each)
    yield Number("mean temperature of what left, between both", float(300.01 < gone < 400.0), 1.0, 0.0)
    yield Number("particles that left, at least 10", float(ledger.removed.count > 10), 1.0, 0.0)

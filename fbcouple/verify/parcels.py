"""Coarse-grained beds: parcels fall, collide, fill cells and cost pressure as the grains that they stand for."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.simulation import loop
from fbcouple.verify.fall import coarsen_bins
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, Edit, open_bench, take_same_step
from fbcouple.verify.impact import look, throw
from fbcouple.verify.lattice import VOIDAGES, HeldBed
from fbcouple.verify.published import PUBLISHED, Bed
from fbcouple.verify.registry import Number, check

_RISE, _TERMINAL = 0.4, 0.4575
"""Velocity of the air [m/s], and that of a sphere of 100 um and 2000 kg/m3 in it, by Schiller and Naumann 1933."""
_AIR = {"density": 1.2, "viscosity": 1.8e-5, "inlet_velocity": _RISE, "walls": "slip", "pressure_tolerance": 1e-10}
_WEIGHTS = ("1", "100")
_CELL, _CELLS_UP, _STEP, _TIME = 0.1, 6, 2e-3, 0.8


def _fall(folder: Path, comm: MPI.Comm, weight: str) -> Iterator[Number]:
    """Speed against the air after fifteen response times, from rest."""
    particles: dict[str, Any] = {"diameter": 1e-4, "density": 2000.0}
    if weight != "1":
        particles["coarse_graining"] = float(weight) ** (1.0 / 3.0)
    mass = math.pi / 12 * particles["diameter"] ** 3 * particles["density"] * float(weight)
    stiffness = mass * (math.pi / (6 * _STEP)) ** 2 / particles.get("coarse_graining", 1.0)
    sections = {
        "domain": {"size": [_CELL, _CELL, _CELL * _CELLS_UP], "cells": [1, 1, _CELLS_UP]},
        "gas": _AIR,
        "particles": particles,
        "contact": FRICTIONLESS | {"stiffness": stiffness, "restitution": 1.0, "wall_restitution": 1.0},
        "exchange": {"drag": "schiller-naumann"},
    }
    edits: dict[str, Edit] = {"DEM/in.liggghts": coarsen_bins}
    bench = open_bench(folder, comm, sections, np.array([[0.05, 0.05, 0.35]]), edits)
    bench.initialise()
    for _ in range(round(_TIME / _STEP)):
        take_same_step(bench)
    yield Number("fall", _RISE - float(bench.liggghts.velocities[0, 2]), _TERMINAL, 0.001, "m s-1", relative=True)


def _compare(measured: dict[str, list[Number]]) -> Iterator[Number]:
    for weight, (number,) in measured.items():
        name = f"fall speed of a parcel of {weight}"
        yield Number(name, number.value, number.expected, number.tolerance, number.unit, relative=True)


check("parcel-fall", variants=_WEIGHTS, judge=_compare)(_fall)


@check("parcel-impact")
def parcel_impact(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Two parcels head on, and one against the floor, l = 2, T_C/200: e_l^2 = 1 - 2 (1 - e^2) of e = 0.9 and 0.8."""
    diameter, speed, edge = GLASS["diameter"], 1.0, 0.02
    contact = FRICTIONLESS | {"restitution": 0.9, "wall_restitution": 0.8, "steps_per_contact": 200}
    gap = 0.5 * diameter + 1e-6
    positions = edge / 2 + np.array([[0.0, 0.0, -gap], [0.0, 0.0, gap], [0.005, 0.0, gap - edge / 2]])
    velocities = np.zeros((3, 3))
    velocities[:, 2] = speed / 2, -speed / 2, -speed
    sections: dict[str, Any] = {
        "gravity": 0.0,
        "domain": {"size": [edge] * 3, "cells": [4, 4, 4]},
        "particles": {"diameter": diameter / 2.0, "coarse_graining": 2.0},
        "contact": contact,
    }
    liggghts = open_bench(folder, comm, sections, positions).liggghts
    throw(liggghts, velocities)
    liggghts.advance(400)
    low, high, floor = look(liggghts).velocities[:, 2]
    yield Number("diameter of a parcel", 2.0 * float(liggghts.radii[0]), diameter, 1e-15, "m")
    yield Number("restitution of two parcels of grains of 0.9", float(high - low) / speed, 0.787401, 0.002)
    yield Number("restitution of a parcel and a wall of 0.8", float(floor) / speed, 0.529150, 0.002)


@check("fixed-bed-parcels")
def fixed_bed_of_parcels(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A held lattice of parcels of 1 mm of 8 grains of 0.5 mm each: pressure per length as of the grains at the same
    voidage, within 2 %."""
    law, diameter = "huilin-gidaspow", GLASS["diameter"] / 2.0
    # Their velocities are set, and no force that the drag of a step could know has made them.
    bed = HeldBed(folder, comm, law, 0.5, ratio=2.0, accelerated=False)
    off = np.abs(bed.found_voidages - np.array(VOIDAGES)[:, None]).max()
    yield Number("voidage, cell farthest off", float(off), 0.0, 1e-12)
    for speed in (0.1, 0.5, 2.0):
        bed.flow(np.full(len(VOIDAGES), speed))
        for eps, loss in zip(VOIDAGES, bed.pressure_losses, strict=True):
            expected = PUBLISHED[law](Bed(eps, speed, diameter, GAS["density"], GAS["viscosity"]))
            yield Number(f"dP/L at voidage {eps}, {speed} m/s", float(loss), expected, 0.02, "Pa m-1", relative=True)


_TRAFFIC: dict[str, Any] = {
    "domain": {"size": [0.02, 0.02, 0.06], "cells": [5, 5, 15], "periodic": ["x", "y"]},
    "gas": GAS | {"inlet_velocity": 8.0},
    "particles": GLASS
    | {
        "diameter": 0.5e-3,
        "coarse_graining": 1.5,
        "feeds": [{"low": [0.0, 0.0, 0.0], "high": [0.02, 0.02, 0.01], "rate": 6e4, "velocity": [0.0, 0.0, 1.0]}],
        "outlets": [{"face": "top"}],
    },
    "contact": FRICTIONLESS | {"stiffness": 200.0},
    "exchange": {"drag": "gidaspow"},
}
_STEPS, _GRAINS = 60, 3.375


@check("parcel-traffic")
def parcel_traffic(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Parcels of l = 1.5 fed at a rate of grains, and an open top: volume, ledger and momentum of what the gas sees."""
    across = np.arange(8) * 2.5e-3 + 1.25e-3
    start = np.stack(np.meshgrid(across, across, [0.0585, 0.0596], indexing="ij"), axis=-1).reshape(-1, 3)
    bench = open_bench(folder, comm, _TRAFFIC, start)
    assert bench.traffic is not None
    bench.initialise()
    grain = math.pi / 6.0 * 0.5e-3**3
    solids = bench.cells.add_up(1.0 - bench.coupling.voidage)
    yield Number("solids volume over that of the grains", solids / (len(start) * _GRAINS * grain), 1.0, 1e-15)
    momentum = error = 0.0
    for _ in range(_STEPS):
        loop.step(bench)
        momentum, error = max(momentum, bench.conservation.momentum_error), max(error, bench.traffic.hold())
    ledger, held = bench.traffic.ledger, bench.liggghts.count
    due = int(6e4 * bench.time / _GRAINS)
    yield Number("parcels that came in", ledger.fed.count, due, 0.0)
    mass = grain * GLASS["density"] * _GRAINS * due
    yield Number("mass that came in", ledger.fed.mass, mass, 1e-14, "kg", relative=True)
    grains = _GRAINS * np.array([len(start), ledger.fed.count, ledger.removed.count, held])
    yield Number("grains: start + in - out - held", float(grains[0] + grains[1] - grains[2] - grains[3]), 0.0, 0.0)
    yield Number("some have left", float(ledger.removed.count > 0), 1.0, 0.0)
    yield Number("ledger, worst", error, 0.0, 1e-13)
    yield Number("momentum, of the drag", momentum, 0.0, 1e-10)

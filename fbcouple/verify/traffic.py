"""Particles that come and go: numbers, mass, momentum and places that are known, and the discharge of a hopper."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from mpi4py import MPI

from fbcouple.case.bed.region import read_mesh
from fbcouple.case.bed.region_lattice import Inside
from fbcouple.case.load import load_case
from fbcouple.simulation import loop
from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, open_bench, open_case
from fbcouple.verify.registry import Number, check

_GRAVITY = 9.81
_RATE, _SPEED, _FALL_STEPS = 500.0, 0.4, 180
_RAIN: dict[str, Any] = {
    "domain": {"size": [0.02, 0.02, 0.12], "cells": [2, 2, 12]},
    "particles": GLASS
    | {
        "count": 0,
        "feeds": [{"low": [0.0, 0.0, 0.1], "high": [0.02, 0.02, 0.101], "rate": _RATE, "velocity": [0, 0, -_SPEED]}],
        "outlets": [{"low": [0.0, 0.0, 0.0], "high": [0.02, 0.02, 0.02]}],
    },
    "contact": FRICTIONLESS,
    "start": {},
    "output": {"record_every": 1e-3},
}
_RISER: dict[str, Any] = {
    "domain": {"size": [0.02, 0.02, 0.06], "cells": [5, 5, 15], "periodic": ["x", "y"]},
    "gas": GAS | {"inlet_velocity": 8.0},
    "particles": GLASS
    | {
        "diameter": 0.5e-3,
        "mixture": [[0.4e-3, 2500.0, 0.3]],
        "feeds": [
            {"low": [0.0, 0.0, 0.0], "high": [0.02, 0.02, 0.01], "rate": 2e4, "velocity": [0.0, 0.0, 1.0]},
            {"low": [0.0, 0.0, 0.0], "high": [0.02, 0.02, 0.01], "mass_flow": 1e-3, "species": 2},
        ],
        "outlets": [{"face": "top"}],
    },
    "contact": FRICTIONLESS | {"stiffness": 200.0},
    "exchange": {"drag": "gidaspow"},
}
_RISER_STEPS = 60
_CROWD, _CROWD_STEPS = 2e5, 30
_DISCHARGE = 82.2
"""Mass flow [g/s] of the hopper between _FROM and _UNTIL [s] after it was opened (Anand et al. 2008, as digitised and
set up for Lethe): 57.81 g less 5.25 g over the time between."""
_FROM, _UNTIL = 0.078, 0.717


@check("rain")
def rain(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A feed into an empty box, an outlet above its floor, gravity alone: number, mass and momentum as counted by hand,
    and every particle where a free fall from its place of entry brings it."""
    bench = open_bench(folder, comm, _RAIN, np.empty((0, 3)))
    assert bench.traffic is not None
    bench.initialise()
    first: dict[int, tuple[np.ndarray, float]] = {}
    for _ in range(_FALL_STEPS):
        loop.step(bench)
        own = bench.liggghts
        for number, entry, position in zip(own.numbers.tolist(), own.identity[:, 1], own.positions, strict=True):
            first.setdefault(number, (position.copy(), float(entry)))
    ledger, time = bench.traffic.ledger, bench.time
    expected = int(_RATE * time)
    yield Number("particles that came in", ledger.fed.count, expected, 0.0)
    yield Number("in = out + held", ledger.fed.count - ledger.removed.count - own.count, 0.0, 0.0)
    yield Number("particles that left", float(ledger.removed.count > 0), 1.0, 0.0)
    mass = np.pi / 6.0 * GLASS["diameter"] ** 3 * GLASS["density"]
    yield Number("mass that came in", ledger.fed.mass, expected * mass, 1e-14, "kg", relative=True)
    momentum = ledger.fed.momentum[2]
    yield Number("momentum that came in", momentum, -expected * mass * _SPEED, 1e-14, "kg m s-1", relative=True)
    exits = bench.traffic.exits
    fallen = -mass * (_SPEED * len(exits) + _GRAVITY * float((exits[:, 3] - exits[:, 1]).sum()))
    yield Number("momentum that left", ledger.removed.momentum[2], fallen, 1e-12, "kg m s-1", relative=True)
    yield from _compare_fall(bench, first)
    yield Number("ledger", bench.traffic.hold(), 0.0, 1e-13)


def _compare_fall(bench: Simulation, first: dict[int, tuple[np.ndarray, float]]) -> Iterator[Number]:
    own, off_place, off_speed = bench.liggghts, 0.0, 0.0
    for number, position, velocity in zip(own.numbers.tolist(), own.positions, own.velocities, strict=True):
        start, entry = first[number]
        age = bench.time - entry
        fall = np.array([0.0, 0.0, -_SPEED * age - 0.5 * _GRAVITY * age**2])
        off_place = max(off_place, float(np.abs(position - start - fall).max()))
        off_speed = max(off_speed, float(abs(velocity[2] + _SPEED + _GRAVITY * age)))
    yield Number("place against a free fall, farthest off", off_place, 0.0, 1e-12, "m")
    yield Number("velocity against a free fall, farthest off", off_speed, 0.0, 1e-11, "m s-1")


@check("riser")
def riser(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Gas at 8 m/s, two species fed, the top open: in = out + held, and conservation between gas and particles."""
    across = np.arange(8) * 2.5e-3 + 1.25e-3
    start = np.stack(np.meshgrid(across, across, [0.0585, 0.0598], indexing="ij"), axis=-1).reshape(-1, 3)
    bench = open_bench(folder, comm, _RISER, start)
    assert bench.traffic is not None
    bench.initialise()
    momentum = error = solids = 0.0
    for _ in range(_RISER_STEPS):
        loop.step(bench)
        momentum, error = max(momentum, bench.conservation.momentum_error), max(error, bench.traffic.hold())
        own, seen = (
            comm.allreduce(_find_volume(bench)),
            comm.allreduce(bench.cells.add_up(1.0 - bench.coupling.voidage)),
        )
        solids = max(solids, abs(seen / own - 1.0))
    ledger, held = bench.traffic.ledger, comm.allreduce(bench.liggghts.count)
    yield Number("in = out + held", ledger.count - held, 0.0, 0.0)
    yield Number("particles of one feed that came in", _count_fed(bench, 1), int(2e4 * bench.time), 0.0)
    yield Number("those of the start next to the top have left", ledger.removed.count, len(start) // 2, 0.0)
    yield Number("ledger, worst", error, 0.0, 1e-13)
    yield Number("momentum, of the drag", momentum, 0.0, 1e-10)
    yield Number("solids volume", solids, 0.0, 1e-12)


def _find_volume(bench: Simulation) -> float:
    return float((4.0 / 3.0 * np.pi * bench.liggghts.radii**3).sum())


def _count_fed(bench: Simulation, feed: int) -> int:
    """Particles that a feed has brought, here or gone."""
    assert bench.traffic is not None
    here = bench.comm.allreduce(int((bench.liggghts.identity[:, 2] == feed).sum()))
    return here + int((bench.traffic.exits[:, 2] == feed).sum())


@check("crowded-feed", fast=False)
def crowded_feed(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A feed wider than the cylinder that it is in, asked for more than finds room: nobody comes in into a wall or into
    another, and who does not come in is owed."""
    low, high = [0.0, 1.6e-4, 0.02], [0.02, 0.0198, 0.03]
    feed = {"low": low, "high": high, "rate": _CROWD}
    particles = GLASS | {"count": 0, "feeds": [feed]}
    domain = {"size": [0.02, 0.02, 0.04], "cells": [6, 6, 12], "shape": "cylinder"}
    gas = GAS | {"inlet_velocity": 0.5}
    more = {"exchange": {"virtual_mass": True}, "contact": FRICTIONLESS, "start": {}}
    bench = open_bench(folder, comm, {"domain": domain, "gas": gas, "particles": particles} | more, np.empty((0, 3)))
    assert bench.traffic is not None
    bench.initialise()
    inside, radius = Inside(read_mesh(bench.case)), 0.5 * GLASS["diameter"]
    pressed, overlap, own = 0, 0.0, bench.liggghts
    for _ in range(_CROWD_STEPS):
        loop.step(bench)
        new = own.identity[:, 1] == bench.time
        pressed += int((~inside.is_clear(own.positions[new], radius * (1.0 - 1e-9))).sum())
        if new.any() and own.count > 1:
            distances = scipy.spatial.cKDTree(own.positions).query(own.positions[new], k=2)[0][:, 1]
            overlap = max(overlap, 1.0 - float(distances.min()) / (2.0 * radius))
    fed, owed = bench.traffic.ledger.fed.count, bench.traffic.count_owed(bench.time)
    yield Number("particles that came in into a wall", pressed, 0.0, 0.0)
    yield Number("overlap of one just come in, over its diameter", overlap, 0.0, 1e-12)
    yield Number("come in + owed", fed + owed, int(_CROWD * bench.time), 0.0)
    yield Number("some are owed", float(owed > 50), 1.0, 0.0)
    inertia = float((own.masses / own.own_masses).max())
    yield Number("inertia over mass, with virtual mass", inertia, 1.0 + 0.5 * GAS["density"] / GLASS["density"], 1e-12)


@check("hopper", fast=False)
def hopper(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """The case `anand/hopper`: mass flow through the slot of a flat hopper, within 5 % of the published one."""
    case = load_case("anand/hopper")
    assert case.particles is not None
    opened = case.particles.outlets[0].start
    bench = open_case(folder, comm, case)
    assert bench.traffic is not None
    bench.initialise()
    while bench.time < opened + _UNTIL:
        loop.step(bench)
    exits = bench.traffic.exits
    time, grams = exits[:, 3] - opened, 1e3 * np.cumsum(exits[:, 5])
    first, last = (float(grams[time <= moment][-1]) for moment in (_FROM, _UNTIL))
    flow = (last - first) / (_UNTIL - _FROM)
    yield Number("mass flow", flow, _DISCHARGE, 0.05, "g s-1", relative=True)
    yield Number("ledger", bench.traffic.hold(), 0.0, 1e-12)

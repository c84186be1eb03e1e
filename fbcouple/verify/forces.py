"""Forces beside drag and pressure gradient, each against its formula, and the momentum that it carries."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.coupling.particles import Particles
from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.fall import coarsen_bins
from fbcouple.verify.gas import run_until_steady, set_patches, split_sides
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, Edit, open_bench, take_same_step
from fbcouple.verify.registry import Number, check
from fbcouple.verify.turbulence import name_sides, start_from

_MOMENTUM = 1e-10


def hold(bench: Simulation, dt: float, steps: int = 1, inertia: float = 1.0) -> Iterator[np.ndarray]:
    """Let the gas take steps of `dt` [s] past particles that stay where they are; forces of the gas (n, 3) [N] in the
    order of the start positions, and its own loss (3,) [N].

    The drag takes the masses times `inertia`: a sphere without inertia has the velocity of the gas at once, no drag.
    """
    gas, liggghts, coupling = bench.gas, bench.liggghts, bench.coupling
    assert gas is not None and liggghts is not None and coupling is not None
    particles = Particles(liggghts.positions, liggghts.velocities, liggghts.radii, liggghts.masses * inertia)
    for _ in range(steps):
        coupling.map(particles)
        coupling.deposit_drag(particles, dt)
        gas.step(dt, *coupling.gas_input)
        held, current = np.zeros_like(particles.positions), np.zeros_like(particles.positions)
        coupling.apply_gas_force(particles, gas.state, held, current)
        if coupling.forces:
            coupling.forces.read(gas.derive(coupling.forces.fields))
    yield held[np.argsort(liggghts.numbers)]
    yield coupling.find_gas_loss(gas.momentum_loss)


def _judge_momentum(forces: np.ndarray, loss: np.ndarray, scale: float) -> Number:
    error = float(np.abs(forces.sum(axis=0) - loss).max()) / scale
    return Number("momentum, of the force", error, 0.0, _MOMENTUM)


_SHEAR_CELLS, _SHEAR_CELL, _SHEAR = (4, 4, 10), 0.01, 40.0
_HEIGHTS = np.array([-0.04, -0.015, -0.005, 0.005, 0.015, 0.04])
"""Distance [m] of the spheres from the plane where the gas rests: Reynolds numbers 12, 35 and 93, up and down."""


@check("lift-force")
def lift(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Spheres held in linear shear u = (g z, 0, 0) between moving plates: Saffman's lift with Mei's factor, 1 %."""
    size = [_SHEAR_CELL * n for n in _SHEAR_CELLS]
    z = (np.arange(_SHEAR_CELLS[2]) + 0.5 - _SHEAR_CELLS[2] / 2) * _SHEAR_CELL
    flow = np.zeros((math.prod(_SHEAR_CELLS), 3))
    flow[:, 0] = np.repeat(_SHEAR * z, _SHEAR_CELLS[0] * _SHEAR_CELLS[1])
    edge = _SHEAR * size[2] / 2
    cyclic = dict.fromkeys(("left", "right"), "type cyclic;")
    sides = {"front": "type slip;", "back": "type slip;"} | cyclic
    plates = {"inlet": f"type fixedValue; value uniform ({-edge} 0 0);"}
    plates |= {"outlet": f"type fixedValue; value uniform ({edge} 0 0);"}
    scalars = dict.fromkeys(("inlet", "outlet", "front", "back"), "type zeroGradient;") | cyclic
    edits: dict[str, Edit] = {
        "CFD/system/blockMeshDict": partial(name_sides, "cyclic"),
        "CFD/0/U": partial(start_from, flow, plates | sides),
        "CFD/0/p": set_patches(scalars),
        "CFD/0/voidage": set_patches(scalars),
    }
    sections: dict[str, Any] = {
        "gravity": 0.0,
        "domain": {"size": size, "cells": list(_SHEAR_CELLS)},
        "gas": GAS | {"pressure_tolerance": 1e-10},
        "exchange": {"lift_force": True, "pressure_gradient": False},
    }
    positions = np.column_stack([np.full((len(_HEIGHTS), 2), size[0] / 2), _HEIGHTS + size[2] / 2])
    positions[:, 0] += np.linspace(-0.012, 0.012, len(_HEIGHTS))
    bench = open_bench(folder, comm, sections, positions, edits)
    bench.initialise()
    forces, loss = hold(bench, 1e-6)
    for height, found in zip(_HEIGHTS.tolist(), forces[:, 2].tolist(), strict=True):
        expected = _saffman_mei(_SHEAR * height)
        yield Number(f"lift at slip {_SHEAR * height:g} m/s", found, expected, 0.01, "N", relative=True)
    yield _judge_momentum(forces, loss, float(np.abs(forces).sum()))


def _saffman_mei(slip: float) -> float:
    """Lift [N] up of a sphere of glass at rest in gas of velocity `slip` [m/s] along x, du/dz = `_SHEAR`."""
    a, nu = GLASS["diameter"] / 2, GAS["viscosity"] / GAS["density"]
    reynolds, beta = abs(slip) * 2 * a / nu, _SHEAR * a / abs(slip)
    low = (1 - 0.3314 * math.sqrt(beta)) * math.exp(-reynolds / 10) + 0.3314 * math.sqrt(beta)
    factor = low if reynolds <= 40 else 0.0524 * math.sqrt(beta * reynolds)
    return 6.46 * GAS["viscosity"] * a**2 * math.sqrt(_SHEAR / nu) * slip * factor


_SMALL = 1e-5
"""Diameter [m] of the spheres in the channel: they change the voidage of their cell by 2e-5."""


def _collect(measured: dict[str, list[Number]]) -> Iterator[Number]:
    for numbers in measured.values():
        yield from numbers


@check("viscous-force", variants=("alone", "with pressure gradient"), judge=_collect)
def viscous(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """Spheres without drag in plane Poiseuille flow: V div(tau) = V dP/dz, and no force with the pressure gradient."""
    width, length, cells, speed, viscosity = 0.01, 0.03, (32, 1, 48), 0.02, 2e-5
    sections: dict[str, Any] = {
        "gravity": 0.0,
        "domain": {"size": [width, width / 32, length], "cells": list(cells)},
        "gas": {"density": 1.0, "viscosity": viscosity, "inlet_velocity": speed, "pressure_tolerance": 1e-9},
        "particles": {"diameter": _SMALL},
        "exchange": {"drag": "stokes", "viscous_force": True, "pressure_gradient": variant != "alone"},
    }
    sites = np.array([0.22, 0.5, 0.78]) * width
    positions = np.column_stack([sites, np.full(3, width / 64), np.full(3, 0.8 * length)])
    edits = split_sides({}) | {"DEM/in.liggghts": partial(coarsen_bins, cell=width / 32)}
    bench = open_bench(folder, comm, sections, positions, edits)
    run_until_steady(bench, dt=5e-3, most=2000, change=1e-4)
    bench.initialise()
    forces, loss = hold(bench, 5e-3, steps=3, inertia=1e-20)
    volume = math.pi / 6 * _SMALL**3
    gradient = -12 * viscosity * speed / width**2
    for x, force in zip((sites / width).tolist(), (forces[:, 2] / volume).tolist(), strict=True):
        expected = gradient if variant == "alone" else 0.0
        name = f"force over volume at x = {x:g} h, {variant}"
        yield Number(name, force, expected, 0.01 * abs(gradient), "N m-3")
    yield _judge_momentum(forces, loss, abs(gradient) * volume)


_WATER: dict[str, Any] = {"density": 1000.0, "viscosity": 1e-3, "walls": "slip", "pressure_tolerance": 1e-10}
_TANK: dict[str, Any] = {"size": [0.05, 0.05, 0.1], "cells": [5, 5, 10]}
_LIQUID_RATIOS = (1.1, 1.5, 2.5)
_ACCELERATION = 20.0


@check("virtual-mass", variants=(*map(str, _LIQUID_RATIOS), "carried"), judge=_collect)
def virtual_mass(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """A sphere released in water starts with (r - 1) g/(r + 1/2), r its density over the water's; water that
    accelerates with A takes a sphere of r = 2.5 along with 3 A/(2 r + 1)."""
    carried = variant == "carried"
    ratio = 2.5 if carried else float(variant)
    expected = 3 * _ACCELERATION / (2 * ratio + 1) if carried else -9.81 * (ratio - 1) / (ratio + 0.5)
    ramp = {"inlet_ramp": [[0.0, 0.0], [1.0, _ACCELERATION]]} if carried else {"inlet_velocity": 0.0}
    sections: dict[str, Any] = {
        "gravity": 0.0 if carried else 9.81,
        "domain": _TANK,
        "gas": _WATER | ramp,
        "particles": {"density": ratio * 1000.0},
        "contact": FRICTIONLESS,
        "exchange": {"drag": "schiller-naumann", "virtual_mass": True},
    }
    bench = open_bench(folder, comm, sections, np.array([[0.025, 0.025, 0.051]]))
    bench.initialise()
    moments, speeds, momentum = [], [], 0.0
    # The gas knows of a move one step later.
    for _ in range(12):
        take_same_step(bench)
        moments.append(bench.clock.time)
        speeds.append(float(bench.liggghts.velocities[0, 2]))
        momentum = max(momentum, bench.conservation.momentum_error)
    found = (speeds[-1] - speeds[3]) / (moments[-1] - moments[3])
    name = f"acceleration in water that accelerates with {_ACCELERATION:g} m/s2" if carried else "start of the fall"
    yield Number(f"{name}, density ratio {ratio:g}", found, expected, 0.01, "m s-2", relative=True)
    yield Number(f"momentum, of the force, {variant}", momentum, 0.0, _MOMENTUM)

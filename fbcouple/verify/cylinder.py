"""A cylinder of tetrahedra passes the checks of the box: a held bed, lone particles that fall, walls, nothing is lost;
of prisms that of gas in a pipe."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.geometry.cylinder import find_section, make_cylinder
from fbcouple.physics.contact import normal_damping
from fbcouple.verify.conservation import conserve
from fbcouple.verify.fall import SCHILLER_NAUMANN, coarsen_bins, name_sizes
from fbcouple.verify.gas import run_until_steady
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, Edit, open_bench, take_same_step
from fbcouple.verify.held_mesh import HeldMesh, compare_losses
from fbcouple.verify.lattice import VOIDAGES
from fbcouple.verify.registry import Number, check

_ACROSS, _LAYERS = 8, 8
"""Cells across the held bed, and up in each of its slabs: in the middle of a slab nothing is known of the others."""
_EDGE = 2.5e-3
_SPEEDS = (0.1, 0.5, 2.0)


def held_cylinder(folder: Path, comm: MPI.Comm, law: str) -> Iterator[Number]:
    """Pressure per length of a held bed in a cylinder of tetrahedra at voidage 0.4-0.9 and superficial slip 0.1-2 m/s
    against what the paper of the drag law prints, within 1 %."""
    layers = _LAYERS * len(VOIDAGES)
    size = (_ACROSS * _EDGE, _ACROSS * _EDGE, layers * _EDGE)
    domain = {"shape": "cylinder", "size": list(size), "cells": [_ACROSS, _ACROSS, layers]}
    mesh = make_cylinder(size[0], size[2], _ACROSS, layers, "tetrahedra")
    bed = HeldMesh(folder, comm, law, domain, mesh, VOIDAGES, 1.5 * _EDGE)
    yield from compare_losses(bed, _SPEEDS, 0.01)


for _law in ("huilin-gidaspow", "ergun"):
    check(f"cylinder-fixed-bed-{_law}", fast=False)(partial(held_cylinder, law=_law))


_CELL, _DEM_STEP = 0.1, 2e-3
_FALLS = {50e-6: (0.5, 1.0), 100e-6: (0.5, 1.0), 200e-6: (1.0, 2.0), 500e-6: (2.6, 12.0), 1e-3: (3.5, 25.0)}
"""By diameter [m]: seven response times [s], and a height [m] that it does not fall through in them."""


def fall_in_cylinder(folder: Path, comm: MPI.Comm, diameters: tuple[float, ...]) -> Iterator[Number]:
    """Lone spheres fall from rest in gas at rest between tetrahedra: the drag of Schiller and Naumann, within 1 %."""
    sizes = np.array(diameters)
    time, height = (max(_FALLS[diameter][k] for diameter in diameters) for k in (0, 1))
    layers = round(height / _CELL)
    pair_mass = math.pi / 12 * sizes.min() ** 3 * GLASS["density"]
    soft = {"stiffness": pair_mass * (math.pi / (6 * _DEM_STEP)) ** 2, "restitution": 1.0, "wall_restitution": 1.0}
    sections = {
        "domain": {"shape": "cylinder", "size": [4 * _CELL, 4 * _CELL, height], "cells": [4, 4, layers]},
        "gas": GAS | {"walls": "slip", "pressure_tolerance": 1e-10},
        "particles": name_sizes(sizes),
        "contact": FRICTIONLESS | soft,
        "exchange": {"drag": "schiller-naumann", "scheme": "explicit"},
    }
    turns = 2.0 * np.pi * np.arange(len(sizes)) / len(sizes)
    top = np.full(len(sizes), height - 0.5 * _CELL)
    positions = np.column_stack([(2.0 + np.cos(turns)) * _CELL, (2.0 + np.sin(turns)) * _CELL, top])
    edits: dict[str, Edit] = {"DEM/in.liggghts": coarsen_bins}
    bench = open_bench(folder, comm, sections, positions, edits, np.arange(len(sizes)))
    bench.initialise()
    for _ in range(round(time / _DEM_STEP)):
        take_same_step(bench)
    speeds = -bench.liggghts.velocities[np.argsort(bench.liggghts.numbers), 2]
    for diameter, found in zip(diameters, speeds.tolist(), strict=True):
        name, expected = f"fall speed of {diameter * 1e6:g} um", SCHILLER_NAUMANN[diameter]
        yield Number(name, found, expected, 0.01, "m s-1", relative=True)


check("cylinder-terminal-velocity")(partial(fall_in_cylinder, diameters=(50e-6, 100e-6, 200e-6)))
check("cylinder-terminal-velocity-large", fast=False)(partial(fall_in_cylinder, diameters=(500e-6, 1e-3)))


_BED: dict[str, Any] = {
    "domain": {"shape": "cylinder", "size": [0.016, 0.016, 0.048], "cells": [6, 6, 18]},
    "gas": GAS | {"inlet_velocity": 1.5, "pressure_tolerance": 1e-12},
    "particles": GLASS | {"count": 1200},
    "contact": FRICTIONLESS | {"friction": 0.1, "wall_friction": 0.1},
    "start": {},
    "exchange": {"filter_passes": 1},
}


@check("cylinder-conservation", ranks=(1, 2, 4), fast=False)
def cylinder_conservation(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Largest errors over 1000 coupled steps in a cylinder of tetrahedra: momentum 1e-10 of the drag, solids volume
    1e-12, gas mass 1e-8."""
    yield from conserve(folder, comm, _BED)


@check("cylinder-conservation-short")
def cylinder_conservation_short(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """The same over 60 steps, with every force that there is."""
    forces = {"filter_passes": 1, "viscous_force": True, "lift_force": True, "virtual_mass": True}
    yield from conserve(folder, comm, _BED | {"exchange": forces}, steps=60, lively=1e-4)


_RESTITUTION = 0.8
_AXIS, _HEIGHT = 0.01, 0.02


@check("cylinder-walls")
def bounce_in_cylinder(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Beads at 1 m/s without the gas against floor, top and two facets of the side, along their normals: restitution
    and overlap (eqs 43-45), and back the way they came.

    They are LIGGGHTS' walls from the surface of the mesh.
    """
    facet = np.pi / 12  # between a corner of the 12 sides and the middle of the next side
    sides = [[np.cos(n * facet), np.sin(n * facet), 0.0] for n in (1, 5)]
    ways = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], *sides])
    middle = np.array([_AXIS, _AXIS, 0.5 * _HEIGHT])
    contact = {"wall_restitution": _RESTITUTION, "wall_friction": 0.0, "steps_per_contact": 100}
    sections = {
        "domain": {"shape": "cylinder", "size": [2 * _AXIS, 2 * _AXIS, _HEIGHT], "cells": [4, 4, 4]},
        "gravity": 0.0,
        "gas": GAS,
        "contact": FRICTIONLESS | contact,
        "exchange": {},
    }
    bench = open_bench(folder, comm, sections, middle + 5e-3 * ways)
    bench.initialise()
    liggghts = bench.liggghts
    assert liggghts is not None and bench.case.contact is not None
    liggghts.velocities[:] = ways[liggghts.numbers - 1]
    farthest = np.zeros(len(ways))
    for _ in range(round(6e-3 / bench.clock.dt)):
        liggghts.advance(1)
        went = (liggghts.positions - middle)[np.argsort(liggghts.numbers)]
        farthest = np.maximum(farthest, np.einsum("pd,pd->p", went, ways))
    velocities = liggghts.velocities[np.argsort(liggghts.numbers)]
    walls = np.array([0.5 * _HEIGHT] * 2 + [_AXIS * np.cos(facet)] * 2) - 0.5 * GLASS["diameter"]
    overlap = _find_overlap(bench.case.contact.stiffness)
    for n, name in enumerate(("floor", "top", "side", "another side")):
        back = -velocities[n] / _RESTITUTION
        yield Number(f"{name}: speed after over before", float(np.linalg.norm(velocities[n])), _RESTITUTION, 0.004)
        turned = float(np.linalg.norm(np.cross(velocities[n], ways[n])))
        yield Number(f"{name}: part of it across the normal", turned, 0.0, 1e-6)
        yield Number(f"{name}: it comes back", float(back @ ways[n] > 0.0), 1.0, 0.0)
        deep = (farthest[n] - walls[n]) / GLASS["diameter"]
        yield Number(f"{name}: overlap, diameters", float(deep), overlap, 0.02, relative=True)


def _find_overlap(stiffness: float) -> float:
    """Largest overlap [diameters] with a wall at 1 m/s (eqs 43-45)."""
    mass = math.pi / 6 * GLASS["diameter"] ** 3 * GLASS["density"]
    natural, damping = math.sqrt(stiffness / mass), normal_damping(stiffness, mass, _RESTITUTION)
    swing = math.sqrt(natural**2 - damping**2)
    return math.exp(-damping / swing * math.atan2(swing, damping)) / natural / GLASS["diameter"]


def flow_through_pipe(folder: Path, comm: MPI.Comm, elements: str, within: float) -> Iterator[Number]:
    """Pipe, 12 cells across, at Re 5: far from the inlet the parabola, dp/dz = -8 mu U/R^2, within 1 % if it is of
    prisms and 5 % if of tetrahedra.

    R is that of a circle as large as the floor, a polygon of 36 sides.
    """
    diameter, length, across, speed, viscosity = 0.01, 0.03, 12, 0.05, 1e-4
    domain = {"shape": "cylinder", "size": [diameter, diameter, length], "cells": [across, across, 18]}
    gas = {
        "density": 1.0,
        "viscosity": viscosity,
        "inlet_velocity": speed,
        "pressure_tolerance": 1e-10,
        "correctors": 3,
    }
    bench = open_bench(folder, comm, {"domain": domain | {"elements": elements}, "gas": gas})
    run_until_steady(bench, dt=1.8e-3, most=600, change=1e-5)
    centres, velocity = bench.gas.centres, bench.gas.velocity[:, 2]
    far = np.flatnonzero(np.abs(centres[:, 2] / length - 0.75) < 0.15)
    square = find_section(diameter, across) / np.pi
    exact = 2.0 * speed * (1.0 - np.sum((centres[far, :2] - diameter / 2) ** 2, axis=1) / square)
    deviation = float(np.abs(velocity[far] - exact).max()) / (2.0 * speed)
    yield Number("largest deviation of the profile over its peak", deviation, 0.0, within)
    slope = float(np.polyfit(centres[far, 2], bench.gas.pressure[far], 1)[0])
    yield Number("pressure gradient", slope, -8.0 * viscosity * speed / square, within, "Pa m-1", relative=True)


for _elements, _within in {"prisms": 0.01, "tetrahedra": 0.05}.items():
    check(f"cylinder-poiseuille-{_elements}", fast=False)(
        partial(flow_through_pipe, elements=_elements, within=_within)
    )

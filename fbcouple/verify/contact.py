"""Contacts of single particles in LIGGGHTS against closed forms (paper, eqs 8-19 and 43-45)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed import derived
from fbcouple.physics.contact import contact_time, normal_damping
from fbcouple.verify.harness import FRICTIONLESS, GLASS, open_bench
from fbcouple.verify.impact import find_step, look, spread_out, throw
from fbcouple.verify.registry import Number, check

_SPEED = 1.0
_PHASES = 40
_RESTITUTION = 0.97
# Steps in a contact -> how far from 0.970 the restitution of an entry phase may be.
_BANDS = {6: 0.02, 10: 0.005, 20: 0.004, 50: 0.001}


@check("normal-impact")
def normal_impact(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Two spheres head on, T_C/20: overlap and velocity at quarters of T_C against eqs 43-44, within 1 %."""
    diameter = GLASS["diameter"]
    middle = np.array([0.01, 0.01, 0.02])
    offset = np.array([0.0, 0.0, diameter / 2])
    steps = 20
    sections = {"gravity": 0.0, "contact": FRICTIONLESS | {"steps_per_contact": steps}}
    bench = open_bench(folder, comm, sections, np.array([middle - offset, middle + offset]))
    liggghts, case = bench.liggghts, bench.case
    assert liggghts is not None and case.contact is not None and case.particles is not None
    liggghts.advance(0, first=True)
    liggghts.velocities[:, 2] = [_SPEED / 2, -_SPEED / 2]
    mass = derived.particle_mass(case.particles) / 2
    gamma = normal_damping(case.contact.stiffness, mass, case.contact.restitution)
    natural = math.sqrt(case.contact.stiffness / mass)
    damped = math.sqrt(natural**2 - gamma**2)
    peak = _SPEED / natural * math.exp(-gamma / damped * math.asin(damped / natural))
    for quarter in (1, 2, 3, 4):
        liggghts.advance(steps // 4)
        z, v = np.sort(liggghts.positions[:, 2]), liggghts.velocities[np.argsort(liggghts.positions[:, 2]), 2]
        overlap, speed = diameter - (z[1] - z[0]), v[0] - v[1]
        t = quarter / 4 * derived.pair_contact_time(case.contact, case.particles)
        scale = _SPEED / damped * math.exp(-gamma * t)
        exact = scale * math.sin(damped * t)
        closing = scale * (damped * math.cos(damped * t) - gamma * math.sin(damped * t))
        yield Number(f"overlap/peak at {quarter / 4} T_C", overlap / peak, exact / peak, 0.01)
        yield Number(f"closing speed at {quarter / 4} T_C", speed / _SPEED, closing / _SPEED, 0.01)


@check("impact-periodic")
def impact_periodic(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Two spheres head on across a periodic side, T_C/200: both leave with e_n of their speed, and no wall is there."""
    diameter, edge = GLASS["diameter"], 0.01
    sites = np.array([[0.6 * diameter, 0.003, 0.005], [edge - 0.6 * diameter, 0.003, 0.005]])
    contact = FRICTIONLESS | {"steps_per_contact": 200}
    domain = {"size": [edge] * 3, "cells": [4, 4, 4], "periodic": ["x", "y"]}
    liggghts = open_bench(folder, comm, {"gravity": 0.0, "contact": contact, "domain": domain}, sites).liggghts
    assert liggghts is not None
    throw(liggghts, np.array([[-_SPEED / 2, 0.0, 0.0], [_SPEED / 2, 0.0, 0.0]]))
    liggghts.advance(200 + round(0.3 * diameter / _SPEED / find_step(contact)))
    left, right = look(liggghts).velocities[:, 0]
    yield Number("speed away from the side over that towards it, first", left / _SPEED * 2, _RESTITUTION, 0.001)
    yield Number("speed away from the side over that towards it, second", -right / _SPEED * 2, _RESTITUTION, 0.001)


def _meet(folder: Path, comm: MPI.Comm, steps: int) -> Iterator[Number]:
    """Pairs that touch at 40 phases of a DEM step: effective restitution of velocity Verlet, in mean and each.

    Verlet's contact is shorter than T_C by pi^2/(24 N) steps, so that as many of the phases, those that touch right
    after a step, have one force fewer; the recursion says how much higher theirs is, and the bands hold for the others.
    """
    contact = FRICTIONLESS | {"restitution": _RESTITUTION, "wall_restitution": 0.8, "steps_per_contact": steps}
    diameter, step = GLASS["diameter"], find_step(contact)
    phases = (np.arange(_PHASES) + 0.5) / _PHASES
    sites = np.column_stack([spread_out(8, 5, 3e-3), np.full(_PHASES, 5e-3)])
    offset = np.zeros((_PHASES, 3))
    offset[:, 2] = (diameter + phases * _SPEED * step) / 2
    sections: dict[str, Any] = {"gravity": 0.0, "contact": contact}
    sections["domain"] = {"size": [0.027, 0.018, 0.01], "cells": [9, 6, 4]}
    bench = open_bench(folder, comm, sections, np.concatenate([sites - offset, sites + offset]))
    velocities = np.zeros((2 * _PHASES, 3))
    velocities[:, 2] = np.repeat([_SPEED / 2, -_SPEED / 2], _PHASES)
    throw(bench.liggghts, velocities)
    bench.liggghts.advance(2 * steps)
    lower, upper = look(bench.liggghts).velocities[:, 2].reshape(2, _PHASES)
    found = (upper - lower) / _SPEED
    exact, forces = _recur(phases, steps)
    full = found[forces == forces.max()]
    late = found[forces < forces.max()]
    band = _BANDS[steps]
    yield Number(f"mean of {_PHASES} phases", found.mean(), _RESTITUTION, 0.001)
    yield Number(f"lowest of the {full.size} phases met for {steps} steps", full.min(), _RESTITUTION, band)
    yield Number(f"highest of the {full.size} phases met for {steps} steps", full.max(), _RESTITUTION, band)
    if late.size:
        expected = exact[forces < forces.max()].max()
        yield Number(f"highest of the {late.size} phases met for {steps - 1} steps", late.max(), expected, 1e-6)
    yield Number("largest difference of a phase from Verlet's recursion", np.abs(found - exact).max(), 0.0, 1e-6)


def _recur(phases: np.ndarray, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Restitution of each phase, and its number of forces, by LIGGGHTS' recursion of the linear spring-dashpot.

    Unit spring and mass: v += f dt/2, x += v dt, f = -(x + 2 gamma v) while x > 0, v += f dt/2.
    """
    gamma = normal_damping(1.0, 1.0, _RESTITUTION)
    dt = contact_time(1.0, 1.0, _RESTITUTION) / steps
    x, v = -phases * dt, np.ones_like(phases)
    force, forces = np.zeros_like(phases), np.zeros(phases.shape, dtype=int)
    for _ in range(2 * steps):
        v = v + force * dt / 2
        x = x + v * dt
        force = np.where(x > 0, -(x + 2 * gamma * v), 0.0)
        forces += x > 0
        v = v + force * dt / 2
    return -v, forces


def _register_meetings(steps: int) -> None:
    def restitution(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
        return _meet(folder, comm, steps)

    restitution.__doc__ = f"Restitution of pairs that touch at 40 phases of a DEM step, {steps} steps a contact."
    check(f"restitution-{steps}")(restitution)


for _steps in _BANDS:
    _register_meetings(_steps)


def _bounce(folder: Path, comm: MPI.Comm, restitution: float, wall_restitution: float, steps: int) -> Iterator[Number]:
    """Spheres against all six walls, six entry phases at each: the wall's own restitution, not that of pairs."""
    contact = FRICTIONLESS | {"restitution": restitution, "wall_restitution": wall_restitution}
    contact["steps_per_contact"] = steps
    radius, step, edge = GLASS["diameter"] / 2, find_step(contact), 0.02
    positions, velocities = np.full((36, 3), edge / 2), np.zeros((36, 3))
    for i in range(36):
        wall, number = divmod(i, 6)
        axis, far = divmod(wall, 2)
        off = radius + (number + 0.5) / 6 * _SPEED * step
        positions[i, axis] = edge - off if far else off
        positions[i, (axis + 1) % 3] = 0.004 + 0.0024 * number
        velocities[i, axis] = _SPEED if far else -_SPEED
    sections = {"gravity": 0.0, "contact": contact, "domain": {"size": [edge] * 3, "cells": [4, 4, 4]}}
    bench = open_bench(folder, comm, sections, positions)
    throw(bench.liggghts, velocities)
    bench.liggghts.advance(3 * steps)
    found = -(look(bench.liggghts).velocities * velocities).sum(axis=1) / _SPEED**2
    for name, value in (("mean", found.mean()), ("lowest", found.min()), ("highest", found.max())):
        yield Number(f"{name} of 36 impacts", value, wall_restitution, 0.002)


@check("wall-restitution")
def wall_restitution(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """e_w = 0.970 where e_n is 0.8, T_C/50, within 0.002."""
    return _bounce(folder, comm, 0.8, _RESTITUTION, 50)


@check("wall-restitution-low")
def wall_restitution_low(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """e_w = 0.8 where e_n is 0.97, T_C/200, within 0.002."""
    return _bounce(folder, comm, _RESTITUTION, 0.8, 200)

"""Contacts of single particles in LIGGGHTS against closed forms (paper, eqs 8-19 and 43-45)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.case import derived
from fbcouple.verify.bench import FRICTIONLESS, GLASS, open_bench
from fbcouple.verify.registry import Number, scene

_SPEED = 1.0


@scene("normal-impact")
def normal_impact(place: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Two spheres head on, T_C/20: overlap and velocity at quarters of T_C against eqs 43-44, within 1 %."""
    diameter = GLASS["diameter"]
    middle = np.array([0.01, 0.01, 0.02])
    offset = np.array([0.0, 0.0, diameter / 2])
    steps = 20
    sections = {"gravity": 0.0, "contact": FRICTIONLESS | {"steps_per_contact": steps}}
    bench = open_bench(place, comm, sections, np.array([middle - offset, middle + offset]))
    grains, case = bench.grains, bench.case
    assert grains is not None and case.contact is not None and case.particles is not None
    grains.advance(0, first=True)
    grains.velocities[:, 2] = [_SPEED / 2, -_SPEED / 2]
    mass = derived.particle_mass(case.particles) / 2
    gamma = derived.normal_damping(case.contact.stiffness, mass, case.contact.restitution)
    natural = math.sqrt(case.contact.stiffness / mass)
    damped = math.sqrt(natural**2 - gamma**2)
    peak = _SPEED / natural * math.exp(-gamma / damped * math.asin(damped / natural))
    for quarter in (1, 2, 3, 4):
        grains.advance(steps // 4)
        z, v = np.sort(grains.positions[:, 2]), grains.velocities[np.argsort(grains.positions[:, 2]), 2]
        overlap, speed = diameter - (z[1] - z[0]), v[0] - v[1]
        t = quarter / 4 * derived.pair_contact_time(case.contact, case.particles)
        scale = _SPEED / damped * math.exp(-gamma * t)
        exact = scale * math.sin(damped * t)
        closing = scale * (damped * math.cos(damped * t) - gamma * math.sin(damped * t))
        yield Number(f"overlap/peak at {quarter / 4} T_C", overlap / peak, exact / peak, 0.01)
        yield Number(f"closing speed at {quarter / 4} T_C", speed / _SPEED, closing / _SPEED, 0.01)

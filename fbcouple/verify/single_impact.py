"""Figures 3 and 4 of the paper: a sphere against a wall, by LIGGGHTS and by the schemes of the paper in plain NumPy.

`docs/results/single-impact/draw.py` draws the curves.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case import derived
from fbcouple.verify.bench import FRICTIONLESS, GLASS, open_bench
from fbcouple.verify.impact import look, parts, throw
from fbcouple.verify.registry import Number, scene

_RESTITUTION, _SPEED, _PHASES = 0.97, 1.0, 40
_DAMPING = derived.normal_damping(1.0, 1.0, _RESTITUTION)
"""gamma_n over omega_0."""
_DURATION = derived.contact_time(1.0, 1.0, _RESTITUTION)
"""T_C omega_0."""
_RK2_RESTITUTION = 1.015
"""Of the paper's scheme and step, the mean over entry phases, worked out apart from this code: 1.013 to 1.017."""
_SIXTHS = np.arange(1, 7) / 6
Step = Callable[[np.ndarray, np.ndarray, float], tuple[np.ndarray, np.ndarray]]


def find_exact(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Overlap over its largest and velocity over that of the impact at `times` over T_C (eqs 43-44)."""
    damped = math.sqrt(1.0 - _DAMPING**2)
    t = times * _DURATION
    peak = math.exp(-_DAMPING / damped * math.asin(damped))
    fall = np.exp(-_DAMPING * t)
    overlap = fall * np.sin(damped * t) / damped
    return overlap / peak, fall * (np.cos(damped * t) - _DAMPING / damped * np.sin(damped * t))


def _accelerate(x: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Unit mass and spring, with force only while they touch (eq. 16)."""
    return np.where(x > 0.0, -(x + 2.0 * _DAMPING * v), 0.0)


def euler(x: np.ndarray, v: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Explicit Euler."""
    return x + dt * v, v + dt * _accelerate(x, v)


def rk2(x: np.ndarray, v: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Midpoint rule of the paper (eqs 40-41)."""
    middle = x + dt / 2 * v, v + dt / 2 * _accelerate(x, v)
    return x + dt * middle[1], v + dt * _accelerate(*middle)


def integrate(step: Step, per_contact: int, count: int, phases: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Overlap and velocity, (count + 1, phases) each in units of the figure, from `phases` of a step before contact."""
    dt = _DURATION / per_contact
    x, v = [-phases * dt], [np.ones_like(phases)]
    for _ in range(count):
        following = step(x[-1], v[-1], dt)
        x.append(following[0])
        v.append(following[1])
    peak = math.exp(-_DAMPING / math.sqrt(1.0 - _DAMPING**2) * math.acos(_DAMPING))
    return np.array(x) / peak, np.array(v)


def collide(place: Path, comm: MPI.Comm, per_contact: int) -> tuple[np.ndarray, np.ndarray]:
    """The same of one sphere and LIGGGHTS' floor, (per_contact + 1,) each: it touches at the first step."""
    contact = FRICTIONLESS | {"restitution": 0.5, "wall_restitution": _RESTITUTION, "steps_per_contact": per_contact}
    section, particles = parts(contact)
    # The step of the case is of a contact of pairs with its own restitution; the wall's contact is longer.
    duration = derived.contact_time(section.stiffness, derived.particle_mass(particles), _RESTITUTION)
    radius = GLASS["diameter"] / 2
    sections: dict[str, Any] = {"gravity": 0.0, "contact": contact}
    grains = open_bench(place, comm, sections, np.array([[0.01, 0.01, radius]])).grains
    assert grains is not None
    grains.command(f"timestep {duration / per_contact!r}")
    throw(grains, np.array([[0.0, 0.0, -_SPEED]]))
    overlaps, velocities = [0.0], [1.0]
    for _ in range(per_contact):
        grains.advance(1)
        motion = look(grains)
        overlaps.append(radius - float(motion.positions[0, 2]))
        velocities.append(-float(motion.velocities[0, 2]) / _SPEED)
    natural = math.sqrt(section.stiffness / derived.particle_mass(particles))
    peak = _SPEED / natural * math.exp(-_DAMPING / math.sqrt(1.0 - _DAMPING**2) * math.acos(_DAMPING))
    return np.array(overlaps) / peak, np.array(velocities)


@scene("figure-4")
def figure_4(place: Path, comm: MPI.Comm) -> Iterator[Number]:
    """LIGGGHTS at T_C/60 on eqs 43-44 within 1 %; what the paper's schemes make of e = 0.97, by their entry phases."""
    steps = 60
    overlaps, velocities = collide(place, comm, steps)
    for sixth, overlap, velocity in zip(_SIXTHS, *find_exact(_SIXTHS), strict=True):
        n = round(sixth * steps)
        yield Number(f"LIGGGHTS, overlap at {sixth:.3f} T_C", float(overlaps[n]), float(overlap), 0.01)
        yield Number(f"LIGGGHTS, velocity at {sixth:.3f} T_C", float(velocities[n]), float(velocity), 0.01)
    phases = (np.arange(_PHASES) + 0.5) / _PHASES
    for name, step, per_contact, expected, band in (
        ("Euler", euler, 80, amplify_euler(80), 0.001),
        ("RK2", rk2, 6, _RK2_RESTITUTION, 0.002),
    ):
        found = -integrate(step, per_contact, 2 * per_contact, phases)[1][-1]
        yield Number(f"restitution of {name} at T_C/{per_contact}", float(found.mean()), expected, band)


def amplify_euler(per_contact: int) -> float:
    """What Euler's steps make of e: |g|^n, g = 1 + lambda dt and n the steps in which its argument goes half round."""
    growth = 1.0 + complex(-_DAMPING, math.sqrt(1.0 - _DAMPING**2)) * _DURATION / per_contact
    return abs(growth) ** (math.pi / cmath.phase(growth))

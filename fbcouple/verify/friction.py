"""Spheres that slide, roll and strike at an angle, against closed forms of Coulomb friction (paper, eqs 6-9)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed import derived
from fbcouple.solvers.liggghts import Liggghts
from fbcouple.verify.harness import FRICTIONLESS, GLASS
from fbcouple.verify.impact import (
    GRAVITY,
    find_step,
    lay_sphere,
    look,
    parts,
    rest_on_floor,
    throw,
    tilt_gravity,
)
from fbcouple.verify.registry import Number, check

_RADIUS = GLASS["diameter"] / 2
_SPEED = 0.2
_FRICTION = 0.1
_SPIN = {"rotation": True}
# A thousandth of the time looked at, and of the speed at which a motion counts as ended.
_FINE = 1e-3


def _lay(folder: Path, comm: MPI.Comm, contact: dict[str, Any], particles: dict[str, Any]) -> Liggghts:
    """One sphere at rest on the floor, with the gravity of a case; the mu of pairs differs from the wall's."""
    return lay_sphere(folder, comm, {"friction": 0.7} | contact, particles, _sink(contact))


def _sink(contact: dict[str, Any], tilt: float = 0.0) -> float:
    """Overlap [m] with the floor at which its spring carries a sphere, gravity `tilt` [rad] off the vertical."""
    section, particles = parts(contact)
    return derived.particle_mass(particles) * GRAVITY * math.cos(tilt) / section.stiffness


def _wait(liggghts: Liggghts, step: float, expected: float, ended: Callable[[], bool]) -> float:
    """Time [s] at which `ended` is true, looked for in thousandths of `expected` [s]; nan after twice that."""
    chunk = max(1, round(_FINE * expected / step))
    for count in range(1, round(2 * expected / step / chunk)):
        liggghts.advance(chunk)
        if ended():
            return count * chunk * step
    return math.nan


@check("sliding-stop")
def sliding_stop(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A sphere that may not rotate slides to rest: after u0/(mu g), over u0^2/(2 mu g), within 1 %."""
    contact = FRICTIONLESS | {"wall_friction": _FRICTION}
    liggghts = _lay(folder, comm, contact, {})
    throw(liggghts, np.array([[_SPEED, 0.0, 0.0]]))
    start, time = liggghts.positions[0, 0], _SPEED / (_FRICTION * GRAVITY)
    found = _wait(liggghts, find_step(contact), time, lambda: liggghts.velocities[0, 0] < _FINE * _SPEED)
    yield Number("stop time", found, time, 0.01, "s", relative=True)
    yield Number("distance", liggghts.positions[0, 0] - start, _SPEED * time / 2, 0.01, "m", relative=True)


@check("sliding-to-rolling")
def sliding_to_rolling(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A sliding sphere that may rotate rolls after 2 u0/(7 mu g) at 5/7 u0, and then keeps on, within 1 %."""
    contact = FRICTIONLESS | {"wall_friction": _FRICTION}
    liggghts = _lay(folder, comm, contact, _SPIN)
    throw(liggghts, np.array([[_SPEED, 0.0, 0.0]]))
    step, time = find_step(contact), 2 * _SPEED / (7 * _FRICTION * GRAVITY)
    found = _wait(liggghts, step, time, lambda: _slip(liggghts) < _FINE * _SPEED)
    yield Number("time of sliding", found, time, 0.01, "s", relative=True)
    for moment in ("when it rolls", "a while later"):
        yield Number(f"speed/u0 {moment}", liggghts.velocities[0, 0] / _SPEED, 5 / 7, 0.01, relative=True)
        spin = liggghts.angular_velocities[0, 1] * _RADIUS / _SPEED
        yield Number(f"spin R/u0 {moment}", spin, 5 / 7, 0.01, relative=True)
        liggghts.advance(round(time / step))


def _slip(liggghts: Liggghts) -> float:
    return float(liggghts.velocities[0, 0] - _RADIUS * liggghts.angular_velocities[0, 1])


def _descend(
    folder: Path, comm: MPI.Comm, particles: dict[str, Any], friction: float, law: Callable[[float], float]
) -> Iterator[Number]:
    """Acceleration [m/s2] along an incline of 10, 20, 30 degrees against `law(angle)`, within 1 %."""
    contact = FRICTIONLESS | {"wall_friction": friction}
    liggghts = _lay(folder, comm, contact, particles)
    steps, step = 1500, find_step(contact)
    for degrees in (10, 20, 30):
        angle = math.radians(degrees)
        tilt_gravity(liggghts, angle)
        throw(liggghts, np.zeros((1, 3)), positions=rest_on_floor(_sink(contact, angle)))
        liggghts.advance(steps)
        first = look(liggghts).velocities[0, 0]
        liggghts.advance(steps)
        found = (look(liggghts).velocities[0, 0] - first) / (steps * step)
        yield Number(f"acceleration at {degrees} deg", found, law(angle), 0.01, "m s-2", relative=True)


@check("incline-sliding")
def incline_sliding(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Without rotation, steeper than atan(mu): g (sin - mu cos)."""
    return _descend(
        folder, comm, {}, _FRICTION, lambda angle: GRAVITY * (math.sin(angle) - _FRICTION * math.cos(angle))
    )


@check("incline-rolling")
def incline_rolling(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """With rotation and mu above 2/7 tan(angle), so that the contact sticks: 5/7 g sin."""
    return _descend(folder, comm, _SPIN, 0.3, lambda angle: 5 / 7 * GRAVITY * math.sin(angle))


@check("rolling-friction")
def rolling_friction(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """A rolling sphere loses 5/7 mu_r g to the torque mu_r F_n R, within 1 %, and none without it."""
    contact = FRICTIONLESS | {"wall_friction": 0.3, "rolling_friction": 0.01}
    liggghts = _lay(folder, comm, contact, _SPIN)
    throw(liggghts, np.array([[_SPEED, 0.0, 0.0]]), np.array([[0.0, _SPEED / _RADIUS, 0.0]]))
    steps = 3000
    liggghts.advance(steps)
    loss = (_SPEED - liggghts.velocities[0, 0]) / (steps * find_step(contact))
    yield Number("deceleration", loss, 5 / 7 * contact["rolling_friction"] * GRAVITY, 0.01, "m s-2", relative=True)
    yield Number("slip/u0", _slip(liggghts) / _SPEED, 0.0, 0.001)


@check("tangential-spring")
def tangential_spring(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """On an incline flatter than atan(mu) a sphere with tangential history stays, m g sin/k_t from its start."""
    ratio, angle = 0.4, math.radians(10)
    options = {"tangential": "history", "tangential_stiffness": ratio, "tangential_damping": 5.0}
    contact = FRICTIONLESS | {"wall_friction": 0.5} | options
    liggghts = _lay(folder, comm, contact, {})
    tilt_gravity(liggghts, angle)
    start = rest_on_floor(_sink(contact, angle))
    throw(liggghts, np.zeros((1, 3)), positions=start)
    section, particles = parts(contact)
    expected = derived.particle_mass(particles) * GRAVITY * math.sin(angle) / (ratio * section.stiffness)
    for moment in ("once at rest", "a while later"):
        liggghts.advance(3000)
        found = look(liggghts).positions[0, 0] - start[0, 0]
        yield Number(f"displacement {moment}", found, expected, 0.01, "m", relative=True)


@check("creep-without-history")
def creep_without_history(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """On an incline flatter than atan(mu) a sphere without history never stops: g sin over the rate of its viscous
    limit, in proportion to the DEM step (`fbcouple check` tells it for two spheres, as sliding at rest)."""
    angle = math.radians(10)
    contact = FRICTIONLESS | {"wall_friction": 0.5}
    liggghts = _lay(folder, comm, contact, {})
    tilt_gravity(liggghts, angle)
    throw(liggghts, np.zeros((1, 3)), positions=rest_on_floor(_sink(contact, angle)))
    expected = GRAVITY * math.sin(angle) / derived.viscous_limit(*parts(contact))
    for moment in ("at once", "a while later"):
        liggghts.advance(1000)
        yield Number(f"speed {moment}", look(liggghts).velocities[0, 0], expected, 0.01, "m s-1", relative=True)

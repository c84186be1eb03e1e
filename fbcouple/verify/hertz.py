"""Hertz contacts of spheres in LIGGGHTS against Johnson 1985, Contact Mechanics, section 11.4."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed import derived
from fbcouple.verify.harness import FRICTIONLESS, GLASS, open_bench
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

_SPEEDS = (0.1, 1.0, 3.0)
_HERTZ: dict[str, Any] = FRICTIONLESS | {
    "model": "hertz",
    "youngs_modulus": 1e8,
    "poisson_ratio": 0.25,
    "impact_speed": max(_SPEEDS),
    "steps_per_contact": 50,
}
_GAP = 1e-6


def _collide(folder: Path, comm: MPI.Comm, contact: dict[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Largest overlap [m], duration [s] and restitution of contacts, each (2, speeds): with the floor, and of pairs."""
    diameter, count, step = GLASS["diameter"], len(_SPEEDS), find_step(contact)
    x = 3e-3 * (1 + np.arange(count))
    heights = [(2e-3, diameter / 2 + _GAP), (6e-3, 5e-3), (6e-3, 5e-3 + diameter + _GAP)]
    positions = np.concatenate([np.column_stack([x, np.full(count, y), np.full(count, z)]) for y, z in heights])
    sections = {"gravity": 0.0, "contact": contact, "domain": {"size": [0.012, 0.01, 0.01], "cells": [4, 4, 4]}}
    bench = open_bench(folder, comm, sections, positions)
    liggghts = bench.liggghts
    assert liggghts is not None
    velocities, speeds = np.zeros((3 * count, 3)), np.array(_SPEEDS)
    velocities[:, 2] = np.concatenate([-speeds, speeds / 2, -speeds / 2])
    throw(liggghts, velocities)
    overlaps = [np.full((2, count), -_GAP)]
    while len(overlaps) < 4 * contact["steps_per_contact"] + 2 * _GAP / (min(_SPEEDS) * step):
        liggghts.advance(1)
        floor, lower, upper = liggghts.positions[np.argsort(liggghts.numbers), 2].reshape(3, count)
        overlaps.append(np.array([diameter / 2 - floor, diameter - (upper - lower)]))
    overlap = np.array(overlaps)
    floor, lower, upper = liggghts.velocities[np.argsort(liggghts.numbers), 2].reshape(3, count)
    return overlap.max(axis=0), _time_contact(overlap, step), np.array([floor, upper - lower]) / speeds


def _time_contact(overlap: np.ndarray, step: float) -> np.ndarray:
    """Time [s] between the zeros of `overlap` (steps, ...), linear between the steps around each."""
    touches = overlap > 0
    first, last = touches.argmax(axis=0), len(overlap) - 1 - touches[::-1].argmax(axis=0)
    at = np.indices(first.shape)
    before, after = overlap[first - 1, *at], overlap[first, *at]
    inside, outside = overlap[last, *at], overlap[last + 1, *at]
    return step * (last - first + after / (after - before) + inside / (inside - outside))


@check("hertz-elastic")
def hertz_elastic(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """e = 1 at 0.1, 1 and 3 m/s, floor and pair: largest overlap and duration within 1 %, restitution within 0.002."""
    contact = _HERTZ | {"restitution": 1.0, "wall_restitution": 1.0}
    section, particles = parts(contact)
    modulus, mass, radius = derived.hertz_modulus(section), derived.particle_mass(particles), particles.diameter / 2
    peaks, durations, restitutions = _collide(folder, comm, contact)
    for i, (partner, part) in enumerate((("floor", 1.0), ("pair", 0.5))):
        for j, speed in enumerate(_SPEEDS):
            peak = derived.hertz_overlap(modulus, part * mass, part * radius, speed)
            duration = derived.hertz_contact_time(modulus, part * mass, part * radius, speed)
            where = f"{partner}, {speed} m/s"
            yield Number(f"largest overlap, {where}", peaks[i, j], peak, 0.01, "m", relative=True)
            yield Number(f"duration, {where}", durations[i, j], duration, 0.01, "s", relative=True)
            yield Number(f"restitution, {where}", restitutions[i, j], 1.0, 0.002)


@check("hertz-restitution")
def hertz_restitution(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """e_n = 0.97 and e_w = 0.9 whatever the speed, within 0.002."""
    contact = _HERTZ | {"restitution": 0.97, "wall_restitution": 0.9}
    _, _, restitutions = _collide(folder, comm, contact)
    for partner, found, expected in zip(("floor", "pair"), restitutions, (0.9, 0.97), strict=True):
        for speed, value in zip(_SPEEDS, found, strict=True):
            yield Number(f"restitution, {partner}, {speed} m/s", value, expected, 0.002)


@check("hertz-tangential-spring")
def hertz_tangential_spring(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """At rest on an incline of 10 deg: overlap and tangential displacement of Hertz and Mindlin, within 1 %.

    4/3 E* R^(1/2) delta^(3/2) = m g cos and 8 G* (R delta)^(1/2) xi = m g sin, G* = G/(2 (2 - nu)), G = E/(2 (1 + nu)).
    """
    options = {"wall_friction": 0.5, "wall_restitution": 0.2, "tangential": "history", "impact_speed": 0.1}
    contact, angle = _HERTZ | options | {"steps_per_contact": 20}, math.radians(10)
    section, particles = parts(contact)
    radius, weight = particles.diameter / 2, derived.particle_mass(particles) * GRAVITY
    sink = (3 * weight * math.cos(angle) / (4 * derived.hertz_modulus(section) * math.sqrt(radius))) ** (2 / 3)
    liggghts = lay_sphere(folder, comm, contact, {}, sink)
    tilt_gravity(liggghts, angle)
    start = rest_on_floor(0.0)
    throw(liggghts, np.zeros((1, 3)), positions=start)
    liggghts.advance(20000)
    moved = look(liggghts).positions[0] - start[0]
    nu = contact["poisson_ratio"]
    shear = contact["youngs_modulus"] / (4 * (2 - nu) * (1 + nu))
    slip = weight * math.sin(angle) / (8 * shear * math.sqrt(radius * sink))
    yield Number("overlap", -moved[2], sink, 0.01, "m", relative=True)
    yield Number("tangential displacement", moved[0], slip, 0.01, "m", relative=True)

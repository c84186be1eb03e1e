"""Oblique impacts: without rotation against the closed form, with rotation against a measurement."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.verify.harness import FRICTIONLESS, GLASS, open_bench
from fbcouple.verify.impact import Motion, find_step, look, spread_out, throw
from fbcouple.verify.registry import Number, check

_LEAVES = {5: 0.0, 10: 0.0, 20: 9.767, 30: 21.411, 45: 39.619, 60: 57.711}
"""Angle [deg] from the normal of impact -> of rebound, mu = 0.1, e = 0.97: the tangential velocity loses
mu (1 + e) of the normal one, or all of it below atan(mu (1 + e)) = 11.145 deg."""
_AZIMUTH = math.radians(37)

# Kharaz, Gorham & Salman 2001, Powder Technology 120:281: sphere of aluminium oxide, 5 mm, 3.9 m/s, against glass.
# Digitised in the tests of MFIX (DEM05); impact angle [deg] from the normal -> rebound angle [deg], and -> ratio of
# the tangential velocities of the centre.
_SPHERE: dict[str, Any] = {"diameter": 5e-3, "density": 4000.0, "rotation": True}
_IMPACT_SPEED = 3.9
_REBOUND_ANGLE = {
    0.2397: 0.1194,
    2.2945: 1.763,
    4.2922: 2.9577,
    9.9429: 6.6917,
    20.5594: 12.3645,
    30.3767: 21.7809,
    39.6233: 32.5455,
    49.7831: 45.1051,
    60.0571: 57.3652,
}
_TANGENTIAL_RESTITUTION = {
    2.0275: 0.7938,
    3.9282: 0.745,
    9.6304: 0.6728,
    20.0845: 0.5964,
    30.2218: 0.6883,
    39.3031: 0.7719,
    49.5459: 0.8469,
    59.8416: 0.9019,
}
# mu and e as measured by Kharaz; k_t/k_n and the tangential damping are fitted to the measured sticking impacts.
_OXIDE: dict[str, Any] = {
    "stiffness": 1e7,
    "restitution": 0.98,
    "wall_restitution": 0.98,
    "friction": 0.092,
    "wall_friction": 0.092,
    "tangential": "history",
    "tangential_stiffness": 0.75,
    "tangential_damping": 7.0,
    "steps_per_contact": 50,
}


def _strike_floor(
    folder: Path, comm: MPI.Comm, particles: dict[str, Any], contact: dict[str, Any], angles: np.ndarray, speed: float
) -> Motion:
    """Motion after spheres have struck the floor at `angles` [rad] from the normal with `speed` [m/s]."""
    diameter, columns = particles["diameter"], 6
    rows = math.ceil(len(angles) / columns)
    sites = spread_out(columns, rows, 2 * diameter)[: len(angles)]
    positions = np.column_stack([sites, np.full(len(angles), 0.5001 * diameter)])
    size = [2 * diameter * (columns + 1), 2 * diameter * (rows + 1), 4 * diameter]
    sections = {"gravity": 0.0, "contact": contact, "particles": particles}
    bench = open_bench(folder, comm, sections | {"domain": {"size": size, "cells": [4, 4, 4]}}, positions)
    along, down = speed * np.sin(angles), speed * np.cos(angles)
    throw(bench.liggghts, np.column_stack([along * math.cos(_AZIMUTH), along * math.sin(_AZIMUTH), -down]))
    approach = 1e-4 * diameter / down.min() / find_step(contact, particles)
    bench.liggghts.advance(3 * contact["steps_per_contact"] + round(approach))
    return look(bench.liggghts)


def _along(motion: Motion) -> np.ndarray:
    """Velocity [m/s] of each sphere along the azimuth that it came from."""
    return motion.velocities[:, 0] * math.cos(_AZIMUTH) + motion.velocities[:, 1] * math.sin(_AZIMUTH)


@check("oblique-wall")
def oblique_wall(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Floor, mu_w = 0.1, e_w = 0.97, no rotation: rebound angles within 0.2 deg; pairs have another mu and e."""
    contact = FRICTIONLESS | {"wall_friction": 0.1, "friction": 0.3, "restitution": 0.9, "steps_per_contact": 50}
    angles = np.radians(list(_LEAVES))
    motion = _strike_floor(folder, comm, GLASS, contact, angles, 1.0)
    leaves = np.degrees(np.arctan2(_along(motion), motion.velocities[:, 2]))
    for (angle, expected), found in zip(_LEAVES.items(), leaves, strict=True):
        yield Number(f"rebound at {angle} deg", found, expected, 0.2, "deg")


def _strike_pair(
    folder: Path, comm: MPI.Comm, particles: dict[str, Any], contact: dict[str, Any], angles: list[int]
) -> Iterator[Number]:
    """Rebound angles of the relative velocity of pairs that meet at `angles` [deg], mu_p = 0.1 and e_n = 0.97.

    The spring is stiff and the speed low, so that the line of centres does not turn during the contact.
    """
    contact = contact | {"friction": 0.1, "wall_friction": 0.3, "wall_restitution": 0.9, "steps_per_contact": 50}
    count, speed = len(angles), 0.1
    sites = np.column_stack([spread_out(count, 1, 2.5e-3), np.full(count, 5e-3)])
    offset = np.array([0.0, 0.0, 0.5 * GLASS["diameter"]])
    sections = {"gravity": 0.0, "contact": FRICTIONLESS | contact | {"stiffness": 1e6}, "particles": particles}
    bench = open_bench(folder, comm, sections, np.concatenate([sites - offset, sites + offset]))
    half = speed / 2 * np.column_stack([np.sin(np.radians(angles)), np.zeros(count), np.cos(np.radians(angles))])
    throw(bench.liggghts, np.concatenate([half, -half]))
    bench.liggghts.advance(150)
    lower, upper = look(bench.liggghts).velocities.reshape(2, count, 3)
    leaves = np.degrees(np.arctan2((lower - upper)[:, 0], (upper - lower)[:, 2]))
    for angle, found in zip(angles, leaves, strict=True):
        yield Number(f"rebound at {angle} deg", found, _LEAVES[angle], 0.2, "deg")


@check("oblique-pair")
def oblique_pair(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Two spheres, no rotation: the same angles as at the floor, within 0.2 deg; the floor has another mu and e."""
    return _strike_pair(folder, comm, {}, {}, list(_LEAVES))


@check("oblique-pair-history")
def oblique_pair_history(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Two spheres that rotate, with tangential history: where they slide all through, the same angles."""
    options = {"tangential": "history", "tangential_stiffness": 0.75}
    return _strike_pair(folder, comm, {"rotation": True}, options, [45, 60])


@check("oblique-rotation")
def oblique_rotation(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Kharaz: rebound angle within 1 deg and tangential restitution within 0.03, linear spring with history.

    What the centre loses in momentum m u the spin has in angular momentum 2/5 m R^2 omega; the measured spins are up
    to 8 % above what the measured velocities give so, which is why they are no numbers of this check.
    """
    angles = np.radians([*_REBOUND_ANGLE, *_TANGENTIAL_RESTITUTION])
    motion = _strike_floor(folder, comm, _SPHERE, _OXIDE, angles, _IMPACT_SPEED)
    along, count = _along(motion), len(_REBOUND_ANGLE)
    spin = motion.spins[:, 1] * math.cos(_AZIMUTH) - motion.spins[:, 0] * math.sin(_AZIMUTH)
    share = 0.4 * spin * _SPHERE["diameter"] / 2 / (_IMPACT_SPEED * np.sin(angles) - along)
    leaves = np.degrees(np.arctan2(along, motion.velocities[:, 2]))[:count]
    ratios = (along / (_IMPACT_SPEED * np.sin(angles)))[count:]
    for (angle, expected), found in zip(_REBOUND_ANGLE.items(), leaves, strict=True):
        yield Number(f"rebound at {angle:.1f} deg", found, expected, 1.0, "deg")
    for (angle, expected), found in zip(_TANGENTIAL_RESTITUTION.items(), ratios, strict=True):
        yield Number(f"tangential restitution at {angle:.1f} deg", found, expected, 0.03)
    yield Number("least 2/5 R spin over loss of tangential velocity", share.min(), 1.0, 0.01)
    yield Number("largest 2/5 R spin over loss of tangential velocity", share.max(), 1.0, 0.01)

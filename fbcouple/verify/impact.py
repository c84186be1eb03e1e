"""Spheres set going all at once and looked at in the order of their numbers: the means of the contact checks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed import derived
from fbcouple.case.schema.particles import Contact, Particles
from fbcouple.solvers.liggghts import Liggghts
from fbcouple.verify.harness import GLASS, open_bench

GRAVITY = 9.81


@dataclass(frozen=True)
class Motion:
    """Where the spheres are [m] and how they move [m/s, rad/s], each (n, 3), in the order of their numbers."""

    positions: np.ndarray
    velocities: np.ndarray
    spins: np.ndarray


def look(liggghts: Liggghts) -> Motion:
    """Copy the motion of the spheres as it is now (one rank)."""
    order = np.argsort(liggghts.numbers)
    return Motion(liggghts.positions[order], liggghts.velocities[order], liggghts.angular_velocities[order])


def throw(
    liggghts: Liggghts, velocities: np.ndarray, spins: np.ndarray | float = 0.0, positions: np.ndarray | None = None
) -> None:
    """Set the spheres going with `velocities` (n, 3) [m/s] and `spins` [rad/s], from `positions` if they are given."""
    for steps in (0,) if positions is None else (0, 0):
        rows = liggghts.numbers - 1
        liggghts.velocities[:] = velocities[rows]
        liggghts.angular_velocities[:] = np.broadcast_to(spins, velocities.shape)[rows]
        if positions is not None:
            liggghts.positions[:] = positions[rows]
        liggghts.advance(steps, first=True)


def spread_out(columns: int, rows: int, spacing: float) -> np.ndarray:
    """Sites (columns*rows, 2) [m] of a grid whose outermost sites are a spacing off the side walls."""
    x, y = np.meshgrid(spacing * (1.0 + np.arange(columns)), spacing * (1.0 + np.arange(rows)))
    return np.column_stack([x.ravel(), y.ravel()])


def parts(contact: dict[str, Any], particles: dict[str, Any] = GLASS) -> tuple[Contact, Particles]:
    """Make the sections [contact] and [particles] as `fbcouple.case.bed.derived` takes them."""
    return Contact.model_validate(contact), Particles.model_validate(particles | {"count": 1})


def find_step(contact: dict[str, Any], particles: dict[str, Any] = GLASS) -> float:
    """DEM step [s] that a case with these sections will have."""
    return derived.dem_step(*parts(contact, particles))


def rest_on_floor(sink: float) -> np.ndarray:
    """Where [m] a glass sphere lies that overlaps the floor by `sink` [m]."""
    return np.array([[0.005, 0.005, GLASS["diameter"] / 2 - sink]])


def lay_sphere(
    folder: Path, comm: MPI.Comm, contact: dict[str, Any], particles: dict[str, Any], sink: float
) -> Liggghts:
    """Open a long box with one glass sphere that lies on its floor, as deep as its contact carries it."""
    domain = {"size": [0.05, 0.01, 0.01], "cells": [10, 2, 2]}
    sections = {"gravity": GRAVITY, "contact": contact, "particles": particles, "domain": domain}
    liggghts = open_bench(folder, comm, sections, rest_on_floor(sink)).liggghts
    assert liggghts is not None
    return liggghts


def tilt_gravity(liggghts: Liggghts, angle: float) -> None:
    """Turn gravity by `angle` [rad] off the vertical towards x; the next `throw` lets it act."""
    liggghts.command("unfix gravity")
    liggghts.command(f"fix gravity all gravity {GRAVITY} vector {math.sin(angle)!r} 0.0 {-math.cos(angle)!r}")

"""Poured beds: as dense as random packings are, level, and at rest when they are let go."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.schema.sections import Case
from fbcouple.decks.alone import Rest, settle
from fbcouple.decks.pour import pour
from fbcouple.geometry.overlap import add_images, find_max_overlap
from fbcouple.verify.harness import GLASS
from fbcouple.verify.registry import Number, check

_DIAMETER = GLASS["diameter"]
_WIDTH, _COUNT = 10, 1500
"""Diameters along each side of the floor, which repeats itself, and particles: 13 layers."""
_MIDDLE = 3.0, 9.0
"""Heights [diameters] that the solids are counted between: off the floor's layers and the surface."""
_FRICTION = {"smooth": 0.0, "rough": 0.5}
_FRACTIONS = {"smooth": (0.637, 0.01), "rough": (0.595, 0.045)}
"""Solids fraction and tolerance. Smooth spheres: random close packing, 0.6366 (Scott and Kilgour 1969, J. Phys. D
2:863). Rough ones: between random loose, 0.555 (Onoda and Liniger 1990, Phys. Rev. Lett. 64:2727), and that."""
_STEPS = 2000


def make_bed(friction: float) -> Case:
    """A bed that repeats itself along x and y."""
    contact: dict[str, Any] = {"stiffness": 500.0, "restitution": 0.9, "wall_restitution": 0.9}
    contact |= {"friction": friction, "wall_friction": friction}
    contact["tangential"] = "history" if friction else "no-history"
    size = [_WIDTH * _DIAMETER, _WIDTH * _DIAMETER, 60 * _DIAMETER]
    return Case.model_validate(
        {
            "title": "verify",
            "end_time": 1.0,
            "domain": {"size": size, "cells": [5, 5, 30], "periodic": ["x", "y"]},
            "particles": GLASS | {"count": _COUNT, "rotation": friction > 0.0},
            "contact": contact,
            "start": {"method": "pour"},
        }
    )


def poured_bed(folder: Path, comm: MPI.Comm, surface: str) -> Iterator[Number]:
    """Spheres are poured between periodic sides. Solids fraction in the middle of the bed, by the parts of spheres that
    lie there; largest overlap; how level the surface is; and what the bed does when it is let go for 2000 DEM steps."""
    case = make_bed(_FRICTION[surface])
    bed = pour(case, folder).particles
    heights = bed.positions[:, 2] / _DIAMETER
    low, high = _MIDDLE
    fraction = (_find_solids(heights, high) - _find_solids(heights, low)) / (_WIDTH**2 * (high - low))
    yield Number("solids fraction", fraction, *_FRACTIONS[surface])
    images, rows = add_images(bed.positions, np.array([_WIDTH, _WIDTH, 0]) * _DIAMETER, _DIAMETER)
    radii = np.full(len(rows), _DIAMETER / 2)
    yield Number("largest overlap", find_max_overlap(images, radii, _COUNT), 0.0, 0.005, "d")
    yield Number("slope of the surface", _find_slope(bed.positions), 0.0, 5.0, "deg")
    let_go = settle(case, folder, bed, Rest(math.inf, _STEPS, _STEPS))
    fall = let_go.particles.positions[:, 2] - bed.positions[:, 2]
    yield Number("height lost", -float(fall.mean()) / _DIAMETER, 0.0, 0.005, "d")
    energy = float((let_go.particles.motion[:, :3] ** 2).sum(axis=1).mean()) / 2
    yield Number("kinetic energy over m g d", energy / (case.gravity * _DIAMETER), 0.0, 1e-4)


def _find_solids(heights: np.ndarray, level: float) -> float:
    """Volume [d^3] of the parts of spheres at `heights` [d] below `level` [d]."""
    reach = np.clip(level - heights, -0.5, 0.5) + 0.5
    return float((math.pi * reach**2 * (1.5 - reach) / 3.0).sum())


def _find_slope(positions: np.ndarray) -> float:
    """Angle [deg] of the plane through the highest centres over squares of two diameters."""
    squares = _WIDTH // 2
    folder = np.floor(positions[:, :2] / (2 * _DIAMETER)).astype(int) % squares
    tops = np.zeros((squares, squares))
    np.maximum.at(tops, (folder[:, 0], folder[:, 1]), positions[:, 2])
    x, y = np.meshgrid(*[(np.arange(squares) + 0.5) * 2 * _DIAMETER] * 2, indexing="ij")
    plane = np.column_stack([x.ravel(), y.ravel(), np.ones(squares**2)])
    (along, across, _), *_ = np.linalg.lstsq(plane, tops.ravel(), rcond=None)
    return math.degrees(math.atan(math.hypot(along, across)))


for _surface in _FRICTION:
    check(f"poured-bed-{_surface}", fast=False)(partial(poured_bed, surface=_surface))

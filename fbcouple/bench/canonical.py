"""The canonical box of Hamidouche et al. 2019, section 3: a cube full of particles, ten DEM steps in a fluid step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fbcouple.case.bed.derived import dem_step
from fbcouple.case.schema.particles import Contact, Particles
from fbcouple.case.schema.sections import Case
from fbcouple.errors import CaseError
from fbcouple.geometry.block import PER_SQUARE
from fbcouple.geometry.extrusion import PER_PRISM

POROSITY, PER_CELL, SUBSTEPS = 0.54, 11, 10
TETRAHEDRA_PER_CELL = PER_SQUARE * PER_PRISM["tetrahedra"]
_DIAMETER = 1e-3
_WIDEST = 1.06


def make_box(cells: tuple[int, int, int], tetrahedra: bool = False) -> Case:
    """A box of hexahedra, or of them each cut into six `tetrahedra` as the paper's are, with 11 particles a cell on a
    shaken lattice, porosity 0.54.

    The fluid step is held at ten DEM steps, so that one fluid step is repeated however the gas moves.
    """
    volume = math.pi / 6.0 * _DIAMETER**3
    each = PER_CELL * (TETRAHEDRA_PER_CELL if tetrahedra else 1)
    edge = (each * volume / (1.0 - POROSITY)) ** (1.0 / 3.0)
    size = [edge * n for n in cells]
    count = each * math.prod(cells)
    spacing = _fit_lattice(size, count)
    contact: dict[str, Any] = {"restitution": 0.97, "wall_restitution": 0.97, "friction": 0.1, "wall_friction": 0.1}
    contact["tangential"] = "no-history"
    particles: dict[str, Any] = {"diameter": _DIAMETER, "density": 2500.0, "count": count}
    step = SUBSTEPS * dem_step(Contact(**contact), Particles(**particles))
    gas: dict[str, Any] = {
        "density": 1.165,
        "viscosity": 2e-5,
        "inlet_velocity": 0.1,
        "max_courant": 1e3,
        "max_fourier": 1e3,
    }
    return Case.model_validate(
        {
            "title": "canonical box",
            "end_time": 1.0,
            "gravity": 0.0,
            "domain": {"size": size, "cells": list(cells)} | ({"elements": "tetrahedra"} if tetrahedra else {}),
            "gas": gas | {"max_step": step * (1.0 + 1e-6), "max_courant": 1e3, "max_fourier": 1e3},
            "particles": particles,
            "contact": contact,
            "start": {"spacing": spacing, "jitter": 0.95},
            "exchange": {"filter_passes": 1},
        }
    )


def _fit_lattice(size: list[float], count: int) -> float:
    """The widest spacing, in diameters, of a lattice of `count` sites that is not higher than the box [m].

    Raises: CaseError if a box of so few cells has no room for a lattice.
    """
    for spacing in np.arange(_WIDEST, 1.0005, -5e-4).tolist():
        wanted = spacing * _DIAMETER
        columns, rows = (math.floor(edge / wanted) for edge in size[:2])
        if -(-count // (columns * rows)) * wanted <= size[2]:
            return spacing
    raise CaseError([f"bench scaling: {count} particles have no lattice in so small a box; give 10 cells or more."])

"""Suspensions that settle through a liquid at rest: the speed of grains, and of parcels of five of them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.drag_balance import find_balance
from fbcouple.case.bed.particle_types import list_kinds
from fbcouple.simulation.loop import step
from fbcouple.verify.harness import FRICTIONLESS, open_bench
from fbcouple.verify.registry import Number, check

_DIAMETER, _DENSITY = 1e-3, 2000.0
_LIQUID = {"density": 1000.0, "viscosity": 1e-3, "inlet_velocity": 0.0, "pressure_tolerance": 1e-10}
_SOLIDS = ("0.10", "0.15", "0.20")
_WEIGHTS = ("1", "5")
_SITES, _LAYERS, _CELLS_ABOVE = 4, 48, 4
"""Spheres across, one above the other, and cells of clear liquid above them; two spheres a cell along each axis."""
_UPPER, _TOP = 0.6, 0.85
"""Part of the suspension's height, from where to where its speed is measured: bottom and surface are far off."""
_TIME = 0.12


def settle(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """Mean speed of the upper middle of a suspension, after seven response times from rest and before the heap at the
    bottom has come up to it; no liquid passes in all."""
    weight, solids = variant.split(":")
    ratio = float(weight) ** (1.0 / 3.0)
    pitch = ratio * _DIAMETER * (math.pi / 6.0 / float(solids)) ** (1.0 / 3.0)
    cells = [_SITES // 2, _SITES // 2, _LAYERS // 2 + _CELLS_ABOVE]
    across, up = pitch * (np.arange(_SITES) + 0.5), pitch * (np.arange(_LAYERS) + 0.5)
    positions = np.stack(np.meshgrid(across, across, up, indexing="ij"), axis=-1).reshape(-1, 3)
    particles: dict[str, Any] = {"diameter": _DIAMETER, "density": _DENSITY}
    sections: dict[str, Any] = {
        "domain": {"size": [2.0 * pitch * n for n in cells], "cells": cells, "periodic": ["x", "y"]},
        "gas": _LIQUID | {"max_step": 1e-3},
        "particles": particles | ({"coarse_graining": ratio} if weight != "1" else {}),
        "contact": FRICTIONLESS | {"stiffness": 20.0},
        "exchange": {"drag": "wen-yu"},
    }
    bench = open_bench(folder, comm, sections, positions)
    bench.initialise()
    while bench.time < _TIME:
        step(bench)
    own = bench.liggghts
    start = positions[own.numbers - 1, 2] / (pitch * _LAYERS)
    speed = -float(own.velocities[(start > _UPPER) & (start < _TOP), 2].mean())
    assert bench.case.particles is not None
    eps = 1.0 - float(solids)
    expected = eps * find_balance(bench.case, eps, None, list_kinds(bench.case.particles)[0])
    yield Number(variant, speed, expected, 0.0, "m s-1")


def compare(measured: dict[str, list[Number]]) -> Iterator[Number]:
    """Parcels settle as grains do, 1 %; grains by the balance of drag and weight at their solids fraction: eps times
    its slip, as the liquid goes up by what the grains go down."""
    for solids in _SOLIDS:
        (single,), (parcels,) = (measured[f"{weight}:{solids}"] for weight in _WEIGHTS)
        about = f"at a solids fraction of {solids}"
        yield Number(f"settling of grains {about}", single.value, single.expected, 0.02, "m s-1", relative=True)
        yield Number(f"parcels of 5 over grains {about}", parcels.value / single.value, 1.0, 0.01)


check("hindered-settling-parcels", variants=tuple(f"{w}:{s}" for s in _SOLIDS for w in _WEIGHTS), judge=compare)(settle)

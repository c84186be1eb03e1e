"""Beds and heaps at rest: that they come to rest, stay there, and what friction without history does to them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.derived import dem_step
from fbcouple.solvers.liggghts import Liggghts
from fbcouple.verify.harness import GLASS, open_bench
from fbcouple.verify.registry import Number, check

_DIAMETER = GLASS["diameter"]
_SOFT = {"stiffness": 100.0}
"""A spring that lets steps be long: overlaps at rest are below a fifth of a per cent of the diameter."""
_SHAKE = 0.019
"""Largest shift of a start position along each axis, in diameters."""

_ROUGH: dict[str, Any] = {"restitution": 0.3, "wall_restitution": 0.3, "friction": 0.5, "wall_friction": 0.5}
_SETTLED: dict[str, dict[str, Any]] = {
    "hooke": _ROUGH | _SOFT,
    "hertz": _ROUGH | {"model": "hertz", "youngs_modulus": 5e6, "poisson_ratio": 0.45, "impact_speed": 0.2},
}
_HEIGHT = 11.58e-3
"""Twice the height of the centre [m] of the settled bed: mean of three starts with 40 steps a contact, 11.56-11.62."""
_WATCHED, _END = 0.3, 0.4

_GLASSY: dict[str, Any] = {"restitution": 0.9, "wall_restitution": 0.9, "friction": 0.5, "wall_friction": 0.5}
_LAWS: dict[str, tuple[float, float]] = {"history": (0.0, 0.02), "no-history": (-4.0, 2.0)}
"""Friction law -> change [deg] of the slope of a heap from 0.3 to 0.6 s, and tolerance; without history it is what two
starts gave, -3.5 and -4.7."""
_WIDTH, _DEPTH, _TOP = 24, 4, 12
_PACKED = 0.58


def lay_column(layers: int, width: int, pitch: float) -> np.ndarray:
    """Positions (n, 3) [m] of a shaken lattice of `width` x `width` x `layers` sites, `pitch` diameters apart."""
    sites = np.stack(np.meshgrid(*map(np.arange, (width, width, layers)), indexing="ij"), axis=-1).reshape(-1, 3)
    shift = np.random.default_rng(1).uniform(-_SHAKE, _SHAKE, sites.shape)
    return ((sites + 0.5) * pitch + shift) * _DIAMETER


def _advance(liggghts: Liggghts, step: float) -> Callable[[float], None]:
    """A function that takes DEM steps up to a time [s]."""
    taken = 0

    def advance(time: float) -> None:
        nonlocal taken
        steps = round(time / step) - taken
        liggghts.advance(steps, first=not taken)
        taken += steps

    return advance


def _find_speed(liggghts: Liggghts) -> float:
    """Speed [m/s], with that of the rotation, R omega sqrt(2/5), that nine of ten particles are below: a few rattle in
    their cages for long."""
    spin = 0.4 * (liggghts.radii**2)[:, None] * liggghts.angular_velocities**2
    return float(np.quantile(np.sqrt((liggghts.velocities**2 + spin).sum(axis=1)), 0.9))


def settled_bed(folder: Path, comm: MPI.Comm, model: str) -> Iterator[Number]:
    """A dry bed of e = 0.3 and mu = 0.5, with history and the DEM steps a contact that a case gets by itself, comes to
    rest and settles no further; with six steps it creeps for ever."""
    layers, width, pitch = 14, 6, 1.04
    edge = width * pitch * _DIAMETER
    domain = {"size": [edge, edge, 1.3 * layers * _DIAMETER], "cells": [2, 2, 4], "periodic": ("x", "y")}
    sections = {"domain": domain, "particles": GLASS | {"rotation": True}, "contact": _SETTLED[model]}
    bench = open_bench(folder, comm, sections, lay_column(layers, width, pitch))
    assert bench.liggghts is not None and bench.case.contact is not None and bench.case.particles is not None
    advance = _advance(bench.liggghts, dem_step(bench.case.contact, bench.case.particles))
    advance(_WATCHED)
    before = 2.0 * float(bench.liggghts.positions[:, 2].mean())
    advance(_END)
    after = 2.0 * float(bench.liggghts.positions[:, 2].mean())
    yield Number(f"speed of nine of ten particles at {_END} s", _find_speed(bench.liggghts), 0.0, 1e-4, "m s-1")
    yield Number(f"settling from {_WATCHED} to {_END} s", before - after, 0.0, 2e-6, "m")
    yield Number("settled height", after, _HEIGHT, 0.015, "m", relative=True)


for _model in _SETTLED:
    check(f"settled-bed-{_model}")(partial(settled_bed, model=_model))


def _find_slope(positions: np.ndarray) -> float:
    """Slope [deg] of the wedge on the floor whose centre of mass is that of the heap: L/2 - x = L^2 tan/(12 H)."""
    length, depth = 1.02 * _DIAMETER * np.array([_WIDTH, _DEPTH])
    height = len(positions) * math.pi / 6.0 * _DIAMETER**3 / (_PACKED * length * depth)
    return math.degrees(math.atan((length / 2.0 - positions[:, 0].mean()) * 12.0 * height / length**2))


def heap(folder: Path, comm: MPI.Comm, law: str) -> Iterator[Number]:
    """A heap of 1 mm glass against a wall, mu = 0.5, no rotation: with history it stands, without it flows away."""
    sites = np.stack(np.meshgrid(*map(np.arange, (_WIDTH, _DEPTH, _TOP)), indexing="ij"), axis=-1).reshape(-1, 3)
    sites = sites[sites[:, 2] < _TOP * (1.0 - (sites[:, 0] + 0.5) / _WIDTH)]
    shift = np.random.default_rng(1).uniform(-_SHAKE / 2, _SHAKE / 2, sites.shape)
    positions = ((sites + 0.5) * 1.02 + shift) * _DIAMETER
    size = [1.02 * _WIDTH * _DIAMETER, 1.02 * _DEPTH * _DIAMETER, 14 * _DIAMETER]
    sections = {
        "domain": {"size": size, "cells": [4, 2, 4], "periodic": ("y",)},
        "contact": _GLASSY | _SOFT | {"tangential": law, "steps_per_contact": 6},
    }
    bench = open_bench(folder, comm, sections, positions)
    assert bench.liggghts is not None and bench.case.contact is not None and bench.case.particles is not None
    advance = _advance(bench.liggghts, dem_step(bench.case.contact, bench.case.particles))
    advance(0.3)
    before = _find_slope(bench.liggghts.positions)
    advance(0.6)
    expected, tolerance = _LAWS[law]
    yield Number(
        "change of the slope from 0.3 to 0.6 s",
        _find_slope(bench.liggghts.positions) - before,
        expected,
        tolerance,
        "deg",
    )


for _law in _LAWS:
    check(f"heap-{_law}")(partial(heap, law=_law))

"""A fluidized bed costs its weight, whatever its mass; the weight that the DEM steps hold acts as LIGGGHTS' own.

Only a quiet bed does so within 1 %: where it bubbles or slugs, falling particles hit the floor, which then carries the
solids' own stress, of the order of rho_p alpha <w^2> (4 to 9 % of the weight in beds of 1 mm glass from 1.2 U_mf on,
without friction and side walls). A fine light powder stays quiet: 0.1 mm, 1000 kg/m3.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.particle_types import solids_volume
from fbcouple.simulation.loop import step
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, Edit, open_bench, take_steps
from fbcouple.verify.published import PUBLISHED, Bed
from fbcouple.verify.registry import Number, check

_DIAMETER, _DENSITY, _GRAVITY = 1e-4, 1000.0, 9.81
_VELOCITY = 0.00488
"""1.4 times what carries the bed at voidage 0.40 [m/s]."""
_SIDE, _COLUMNS = 8 * _DIAMETER, 3
_SETTLE, _END = 0.2, 0.35
"""The pressure is averaged between these times [s]; the bed comes down from its start lattice in 0.1 s."""
_COUNTS = ("2000", "3000", "4000")


def _lay_out(count: int) -> dict[str, Any]:
    """A bed of `count` particles without side walls; steps are short against their response time, 1 ms when packed."""
    cell = _SIDE / _COLUMNS
    layers = round(count / 80)
    return {
        "domain": {
            "size": [_SIDE, _SIDE, layers * cell],
            "cells": [_COLUMNS, _COLUMNS, layers],
            "periodic": ["x", "y"],
        },
        "gas": GAS | {"inlet_velocity": _VELOCITY, "pressure_tolerance": 1e-8, "max_courant": 0.02},
        "particles": {"diameter": _DIAMETER, "density": _DENSITY, "count": count},
        "contact": FRICTIONLESS | {"restitution": 0.9, "wall_restitution": 0.9, "stiffness": 0.1},
        "start": {"spacing": 1.01},
        "exchange": {"filter_passes": 1},
    }


def _carried_voidage() -> float:
    """Voidage at which the gas carries a homogeneous bed by the law that its paper prints, by bisection."""
    low, high = 0.36, 0.8
    for _ in range(60):
        eps = 0.5 * (low + high)
        loss = PUBLISHED["huilin-gidaspow"](Bed(eps, _VELOCITY, _DIAMETER, GAS["density"], GAS["viscosity"]))
        weight = (1.0 - eps) * (_DENSITY - GAS["density"]) * _GRAVITY
        low, high = (eps, high) if loss > weight else (low, eps)
    return high


def _judge(measured: dict[str, list[Number]]) -> Iterator[Number]:
    for numbers in measured.values():
        yield from numbers


@check("bed-weight", fast=False, variants=_COUNTS, judge=_judge)
def bed_weight(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """Three masses, quietly fluidized: mean pressure drop against weight less buoyancy over the floor, 1 %."""
    bench = open_bench(folder, comm, _lay_out(int(variant)))
    assert bench.liggghts is not None and bench.case.particles is not None
    bench.initialise()
    elapsed = pressure = support = height = 0.0
    while bench.clock.time < _END:
        step(bench)
        if bench.clock.time > _SETTLE and bench.gas_report:
            elapsed += bench.dt
            pressure += bench.dt * bench.gas_report.inlet_pressure
            support += bench.dt * bench.conservation.support
            height += bench.dt * 2.0 * float(bench.liggghts.positions[:, 2].mean())
    volume = solids_volume(bench.case.particles)
    expected = volume * (_DENSITY - GAS["density"]) * _GRAVITY / _SIDE**2
    about = f"{variant} particles"
    yield Number(f"pressure drop, {about}", pressure / elapsed, expected, 0.01, "Pa", relative=True)
    share = support / elapsed / (volume * _DENSITY * _GRAVITY)
    yield Number(f"force of the gas over the weight, {about}", share, 1.0, 0.01)
    voidage = 1.0 - volume / (_SIDE**2 * height / elapsed)
    yield Number(f"mean voidage, {about}", voidage, _carried_voidage(), 0.02)


_HELD, _OWN = "held", "own"
_LINE = f"fix             gravity all gravity {_GRAVITY} vector 0.0 0.0 -1.0\n"
_FALL = [10] * 200
"""DEM steps of each coupled step: 27 ms, in which the lowest two of four layers meet the floor."""


def _add_gravity(deck: str) -> str:
    """Give LIGGGHTS a fix for gravity, beside which none is held."""
    before, line, after = deck.partition("fix             coupling ")
    assert line, "the deck has no coupling"
    return before + _LINE + line + after


def _compare(measured: dict[str, list[Number]]) -> Iterator[Number]:
    for held, own in zip(measured[_HELD], measured[_OWN], strict=True):
        yield Number(held.name, held.value, own.value, 1e-10, held.unit, relative=True)


@check("held-weight", variants=(_HELD, _OWN), judge=_compare)
def held_weight(folder: Path, comm: MPI.Comm, variant: str) -> Iterator[Number]:
    """Spheres that fall on a floor that gas comes through: with their weight in the force that the DEM steps hold, and
    with gravity as a fix of LIGGGHTS', the same to 1e-10."""
    spacing = 3.0 * GLASS["diameter"]
    sites = spacing * np.stack(np.meshgrid(range(5), range(5), range(4), indexing="ij"), axis=-1).reshape(-1, 3)
    edits: dict[str, Edit] = {} if variant == _HELD else {"DEM/in.liggghts": _add_gravity}
    sections = {"gas": GAS | {"inlet_velocity": 0.5}, "exchange": {}}
    bench = open_bench(folder, comm, sections, sites + spacing, edits)
    bench.initialise()
    for _ in take_steps(bench, _FALL):
        pass
    masses, z, speeds = bench.liggghts.masses, bench.liggghts.positions[:, 2], bench.liggghts.velocities
    mass, moment, energy = comm.allreduce(np.array([masses.sum(), masses @ z, 0.5 * masses @ (speeds**2).sum(axis=1)]))
    yield Number("height of the centre of mass", float(moment / mass), 0.0, 0.0, "m")
    yield Number("kinetic energy", float(energy), 0.0, 0.0, "J")
    yield Number("force of the gas", bench.conservation.support, 0.0, 0.0, "N")

"""A small bed that fluidizes: nothing is lost between gas and particles, whatever the number of ranks."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.particle_types import solids_volume
from fbcouple.coupling.box.mapping import VOIDAGE_METHODS
from fbcouple.simulation.loop import step
from fbcouple.simulation.simulation import Simulation
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, open_bench
from fbcouple.verify.registry import Number, check

_BED: dict[str, Any] = {
    "domain": {"size": [0.02, 0.01, 0.06], "cells": [8, 4, 24]},
    "gas": GAS | {"inlet_velocity": 1.2, "pressure_tolerance": 1e-12},
    "particles": GLASS | {"count": 2000},
    "contact": FRICTIONLESS | {"friction": 0.1, "wall_friction": 0.1},
    "start": {},
    "exchange": {"filter_passes": 1},
}
_STEPS = 1000
_DRIFT = 1.0


@check("conservation", ranks=(1, 2, 4), fast=False)
def conservation(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """Largest errors over 1000 coupled steps: momentum 1e-10 of the drag, solids volume 1e-12, gas mass 1e-8."""
    yield from conserve(folder, comm, _BED)


def conservation_of(folder: Path, comm: MPI.Comm, exchange: dict[str, Any]) -> Iterator[Number]:
    """The same in a smaller and livelier bed, with another way to share particles among cells."""
    yield from conserve(folder, comm, _BED | _SMALLER | {"exchange": exchange})


_SMALLER: dict[str, Any] = {
    "domain": {"size": [0.02, 0.01, 0.03], "cells": [8, 4, 12]},
    "gas": _BED["gas"] | {"inlet_velocity": 2.5},
    "particles": GLASS | {"count": 600},
}
_WIDTH = 2.0
"""Of the Gaussian kernel and of the diffusion, in diameters: they reach over the whole depth of the bed."""
_SHARED: dict[str, dict[str, Any]] = {name: {"voidage": name} for name in VOIDAGE_METHODS}
_SHARED["gaussian"]["kernel_width"] = _WIDTH
_SHARED |= {"diffusion": {"voidage": "centre", "diffusion_width": _WIDTH}}

for _name, _exchange in _SHARED.items():
    check(f"conservation-{_name}", ranks=(1, 2), fast=False)(partial(conservation_of, exchange=_exchange))


@check("conservation-periodic", ranks=(1, 2, 4), fast=False)
def conservation_periodic(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """The same without side walls: particles and gas leave on one side and come back on the other."""
    yield from conserve(folder, comm, _BED | {"domain": _BED["domain"] | {"periodic": ["x", "y"]}}, _DRIFT)


_WATER: dict[str, Any] = {"density": 1000.0, "viscosity": 1e-3, "inlet_velocity": 0.06, "pressure_tolerance": 1e-12}
_FORCES: dict[str, Any] = {"viscous_force": True, "lift_force": True, "virtual_mass": True}


@check("conservation-forces", ranks=(1, 2), fast=False)
def conservation_forces(folder: Path, comm: MPI.Comm) -> Iterator[Number]:
    """The same with every force there is, in water, where they matter."""
    yield from conserve(folder, comm, _BED | {"gas": _WATER, "exchange": _BED["exchange"] | _FORCES}, steps=300)


def conserve(
    folder: Path,
    comm: MPI.Comm,
    bed: dict[str, Any],
    drift: float = 0.0,
    steps: int = _STEPS,
    lively: float = 0.05,
    case_folder: Path = Path(),
) -> Iterator[Number]:
    """Run a bed whose particles start with the velocity `drift` [m/s] along x, and look for what is lost.

    lively: speed [m/s] that some particle must have at the end, or the check shows nothing; case_folder: where a mesh
    of the bed lies.
    """
    bench = open_bench(folder, comm, bed, case_folder=case_folder)
    bench.liggghts.velocities[:, 0] = drift
    bench.initialise()
    way = 0.0
    momentum = solids = gas = 0.0
    for _ in range(steps):
        step(bench)
        assert bench.gas_report is not None
        way += float(bench.liggghts.velocities[:, 0].sum()) * bench.dt
        momentum = max(momentum, bench.conservation.momentum_error)
        solids = max(solids, abs(_solids_volume(bench) - 1.0))
        gas = max(gas, bench.gas_report.lost / bench.gas_report.inflow)
    yield Number("momentum, of the drag", momentum, 0.0, 1e-10)
    yield Number("solids volume", solids, 0.0, 1e-12)
    yield Number("gas mass, of the inflow", gas, 0.0, 1e-8)
    yield Number("particles lost", bench.conservation.particles - bed["particles"]["count"], 0.0, 0.0)
    if drift:
        width, particles = bench.grid.size[0], bench.conservation.particles
        yield Number("the mean particle has crossed the box", float(comm.allreduce(way) > particles * width), 1.0, 0.0)
    yield Number("particles move", float(_fastest(bench) > lively), 1.0, 0.0)


def _solids_volume(bench: Simulation) -> float:
    """Solids in the cells over the volume of the particles."""
    assert bench.coupling is not None and bench.case.particles is not None
    own = bench.cells.add_up(1.0 - bench.coupling.voidage)
    particles = solids_volume(bench.case.particles)
    return bench.comm.allreduce(own) / particles


def _fastest(bench: Simulation) -> float:
    speeds = np.linalg.norm(bench.liggghts.velocities, axis=1)
    return bench.comm.allreduce(float(speeds.max(initial=0.0)), MPI.MAX)

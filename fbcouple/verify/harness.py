"""What checks are made of: a case from a few settings, set up in the check's folder, with its solvers open."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.case.bed.adopt_inlets import adopt_inlets
from fbcouple.case.bed.lattice import lattice_kinds, lattice_positions
from fbcouple.case.companions import copy_companions
from fbcouple.case.schema.sections import Case
from fbcouple.decks.render import set_up
from fbcouple.launcher.openfoam_mesh import prepare_mesh
from fbcouple.simulation.simulation import Simulation

GLASS: dict[str, Any] = {"diameter": 1e-3, "density": 2500.0}
GAS: dict[str, Any] = {"density": 1.165, "viscosity": 2e-5, "inlet_velocity": 0.0}
FRICTIONLESS: dict[str, Any] = {"restitution": 0.97, "wall_restitution": 0.97, "friction": 0.0, "wall_friction": 0.0}
FRICTIONLESS["tangential"] = "no-history"
BOX: dict[str, Any] = {"size": [0.02, 0.02, 0.04], "cells": [5, 5, 10]}

Edit = Callable[[str], str]


def open_bench(
    folder: Path,
    comm: MPI.Comm,
    sections: dict[str, Any],
    positions: np.ndarray | None = None,
    edits: dict[str, Edit] | None = None,
    kinds: np.ndarray | None = None,
    case_folder: Path = Path(),
) -> Simulation:
    """Set up a case of `sections` (as a case file has them) in `folder`, open its solvers, set the particles up.

    positions: start positions (n, 3) [m] in place of the lattice; the particles' count follows them, and their ratio
    if they are parcels.
    kinds: of a mixture the kind of each particle, counted from 0, in place of a random order.
    case_folder: where the files lie that the case brings, a mesh.
    edits: deck file -> change of its text, for checks that need what no case asks for (a moving lid).
    """
    case = adopt_inlets(_make_case(sections, positions), case_folder)
    return open_case(folder, comm, case, positions, edits, kinds, case_folder)


def open_case(
    folder: Path,
    comm: MPI.Comm,
    case: Case,
    positions: np.ndarray | None = None,
    edits: dict[str, Edit] | None = None,
    kinds: np.ndarray | None = None,
    case_folder: Path = Path(),
) -> Simulation:
    """The same of a `case` that there is."""
    run = folder / "run"
    if comm.rank == 0:
        set_up(
            case,
            run,
            lambda wanted: lattice_positions(wanted, case_folder) if positions is None else positions,
            lambda wanted: lattice_kinds(wanted) if kinds is None else kinds,
            folder=case_folder,
        )
        copy_companions(case, case_folder, run)
        for deck, edit in (edits or {}).items():
            (run / deck).write_text(edit((run / deck).read_text(encoding="utf-8")), encoding="utf-8")
        if case.gas:
            prepare_mesh(case, run, comm.size)
    comm.Barrier()
    os.chdir(run)
    os.environ["PWD"] = str(run)
    return Simulation(case, Path("."), comm, case.end_time)


def _make_case(sections: dict[str, Any], positions: np.ndarray | None) -> Case:
    data: dict[str, Any] = {"title": "verify", "end_time": 1e9, "domain": BOX} | sections
    if positions is not None:
        particles = GLASS | data.get("particles", {})
        grains = particles.get("coarse_graining", 1.0) ** 3
        data["particles"] = particles | {"count": round(len(positions) * grains)}
        data.setdefault("contact", FRICTIONLESS)
        data.setdefault("start", {})
    return Case.model_validate(data)


def take_same_step(bench: Simulation) -> None:
    """One coupling step; the next is as long (collective)."""
    bench.step_gas()
    bench.apply_gas_force()
    bench.apply_gas_heat()
    bench.move_particles()
    bench.clock.tick()
    bench.map_solids()
    bench.deposit_drag()
    bench.deposit_heat()


def take_steps(bench: Simulation, substeps: Iterable[int]) -> Iterator[None]:
    """Coupling steps of so many DEM steps each, whatever the gas would have; yields after each (collective)."""
    dem_step = bench.clock.dt / bench.clock.substeps
    wanted = iter(substeps)
    _set_step(bench, next(wanted), dem_step)
    for following in itertools.chain(wanted, [1]):
        bench.step_gas()
        bench.apply_gas_force()
        bench.move_particles()
        bench.clock.tick()
        bench.map_solids()
        _set_step(bench, following, dem_step)
        yield


def _set_step(bench: Simulation, substeps: int, dem_step: float) -> None:
    bench.clock.substeps, bench.clock.dt = substeps, substeps * dem_step
    bench.deposit_drag()


def blow(bench: Simulation) -> None:
    """One coupling step in which no particle moves, whatever its velocity is by now (collective)."""
    bench.deposit_drag()
    bench.step_gas()
    bench.apply_gas_force()
    bench.choose_step()

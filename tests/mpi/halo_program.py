"""Run under mpirun by test_halo_ranks.py: `halo_program.py SCATTER EXCHANGE` prints one JSON object of differences.

The exchange on all ranks against the same exchange in one process. SCATTER is `random` (every cell belongs to a random
rank) or `slabs` (cells in slabs along x that differ from the particles' slabs). EXCHANGE is that section as JSON. The
last rank's box holds no particle.
"""

from __future__ import annotations

import json
import sys

import numpy as np
from mpi4py import MPI

from fbcouple.case.schema.sections import Case
from fbcouple.coupling.box.halo import HaloExchange, LocalGrid
from fbcouple.coupling.coupling import Coupling, Particles
from fbcouple.coupling.discretisation import BoxSpace
from fbcouple.errors import FbcoupleError
from fbcouple.geometry.grid import Grid
from fbcouple.simulation.conservation import Conservation

CELLS, SIZE, REACH = (16, 3, 9), (0.04, 0.009, 0.02), 1e-3
DT = 3e-4


def make_case(exchange: dict, periodic: tuple[str, ...] = ()) -> Case:
    return Case.model_validate(
        {
            "title": "a bed on ranks",
            "end_time": 1.0,
            "domain": {"size": SIZE, "cells": CELLS, "periodic": periodic},
            "gas": {"density": 1.165, "viscosity": 2e-5, "inlet_velocity": 1.0},
            "particles": {"diameter": 1e-3, "density": 2500.0, "count": 300},
            "exchange": exchange,
        }
    )


def assign_cells(rng: np.random.Generator, scatter: str, ranks: int) -> np.ndarray:
    """Owner of each cell, (x, y, z); the slabs end a cell and a half off the particles' ones."""
    if scatter == "random":
        return rng.integers(0, ranks, CELLS)
    cuts = (np.arange(1, ranks) * CELLS[0] / ranks + 1.5).astype(int)
    return np.broadcast_to(np.searchsorted(cuts, np.arange(CELLS[0]), side="right")[:, None, None], CELLS)


def run_coupling(case, comm, centres, bounds, particles, gas):
    """One coupling step with a gas (cells, 12): velocity and pressure gradient before and after it."""
    coupling = Coupling(case, BoxSpace(case, comm, centres, bounds, REACH))
    coupling.map(particles)
    coupling.read_gas(np.ascontiguousarray(gas[:, :6]))
    coupling.deposit_drag(particles, DT)
    forces, current = np.zeros((2, len(particles.positions), 3))
    drag = coupling.apply_gas_force(particles, np.ascontiguousarray(gas[:, 6:]), forces, current)
    cells = np.column_stack(coupling.gas_input)
    return coupling, cells, forces, drag


def give_up(coupling: Coupling, gas: np.ndarray, volume: float) -> np.ndarray:
    """The sums (7,) over cells of one `volume` that the gas solver makes of its velocity and gradient (cells, 6)."""
    sums, solids = coupling.drag_sums, (1.0 - coupling.voidage) * volume
    drag = (sums[:, :1] * gas[:, :3] - sums[:, 1:]).sum(axis=0)
    return np.array([*drag, *(solids @ gas[:, 3:]), solids.sum()])


def differ(comm: MPI.Comm, mine: np.ndarray, serial: np.ndarray) -> float:
    """Largest difference on any rank, over the largest value of the column."""
    scale = np.abs(serial).max(axis=0, initial=1e-300)
    scale = comm.allreduce(scale, np.maximum)
    return float(comm.allreduce(np.max(np.abs(mine - serial) / scale, initial=0.0), max))


def get_inside(field: np.ndarray) -> np.ndarray:
    """View (x, y, z, c) of a local field's cells, without the extra upper layers."""
    return field[:-1, :-1, :-1].transpose(2, 1, 0, 3)


def compare_halo(comm: MPI.Comm, grid: Grid, owned: np.ndarray, local: LocalGrid) -> dict[str, float]:
    """Random local fields, sent back and forward again, against sums of all ranks' local cells on the whole grid."""
    written = local.make_field(2)
    written[:] = np.random.default_rng(comm.rank).standard_normal(written.shape)
    everywhere = np.zeros((*grid.cells, 2))
    for low, high, field in comm.allgather((local.low, local.high, get_inside(written))):
        everywhere[tuple(slice(a, b) for a, b in zip(low, high, strict=True))] += field
    halo, cells = HaloExchange(comm, local, owned), np.empty((len(owned), 2))
    halo.reverse(written, cells)
    i, j, k = owned.T
    found = {"reverse": differ(comm, cells, everywhere[i, j, k])}
    forwarded = local.make_field(2)
    halo.forward(cells, forwarded)
    here = tuple(slice(a, b) for a, b in zip(local.low, local.high, strict=True))
    found["forward"] = differ(comm, get_inside(forwarded).reshape(-1, 2), everywhere[here].reshape(-1, 2))
    inner = np.sum(get_inside(forwarded * written))
    left, right = comm.allreduce(float(inner)), comm.allreduce(float(np.sum(cells**2)))
    found["transpose"] = abs(left - right) / right
    return found


def count_messages(comm: MPI.Comm, owned: np.ndarray, local: LocalGrid) -> dict[str, list]:
    """Messages of each rank, and the ranks that it has to share cells with."""

    def overlap(cells: np.ndarray, block: tuple) -> bool:
        return bool(np.all((cells >= block[0]) & (cells < block[1]), axis=1).any())

    everyone = comm.allgather((owned, (local.low, local.high)))
    shared = [
        rank
        for rank, (cells, block) in enumerate(everyone)
        if rank != comm.rank and (overlap(owned, block) or overlap(cells, (local.low, local.high)))
    ]
    halo = HaloExchange(comm, local, owned)
    return {"messages": comm.allgather(halo.messages), "shared": comm.allgather(shared)}


def compare(comm: MPI.Comm, scatter: str, exchange: dict) -> dict:
    """Everything on all ranks, against one process; every rank draws the same random numbers."""
    rng, case, grid = np.random.default_rng(4), make_case(exchange), Grid(CELLS, SIZE)
    all_cells = np.stack(np.meshgrid(*map(np.arange, CELLS), indexing="ij"), axis=-1).reshape(-1, 3)
    all_cells = rng.permutation(all_cells)
    owner = assign_cells(rng, scatter, comm.size)[tuple(all_cells.T)]
    gas = rng.standard_normal((len(all_cells), 12)) * ([1.0, 1.0, 1.0, 1e3, 1e3, 1e3] * 2)
    radii = rng.uniform(3e-4, 5e-4, 300)
    places = rng.uniform(0.0, 1.0, (300, 3)) * SIZE
    if comm.size > 1:
        places[:, 0] *= (comm.size - 1.0) / comm.size
    velocities, masses = rng.standard_normal((300, 3)), 2500.0 * 4 / 3 * np.pi * radii**3

    edges = np.arange(comm.size + 1) * SIZE[0] / comm.size
    bounds = np.array([[edges[comm.rank], 0.0, 0.0], [edges[comm.rank + 1], *SIZE[1:]]])
    # A particle stays with its rank for a while after it left the rank's box.
    holder = np.searchsorted(edges[1:-1], places[:, 0] + rng.uniform(-REACH, REACH, 300))
    holder = np.minimum(holder, max(comm.size - 2, 0))
    my_cells, my_particles = np.flatnonzero(owner == comm.rank), np.flatnonzero(holder == comm.rank)

    def pick(rows):
        return Particles(places[rows], velocities[rows], radii[rows], masses[rows])

    centres = (all_cells + 0.5) * grid.spacing
    whole = np.array([[0.0] * 3, SIZE])
    _, cells, forces, drag = run_coupling(case, MPI.COMM_SELF, centres, whole, pick(np.arange(300)), gas)
    coupling, mine, my_forces, my_drag = run_coupling(
        case, comm, centres[my_cells], bounds, pick(my_particles), gas[my_cells]
    )
    total = comm.allreduce(my_drag)
    conservation = Conservation(comm)
    momentum_loss = give_up(coupling, gas[my_cells][:, 6:], grid.cell_volume)
    conservation.give(coupling.find_gas_loss(momentum_loss), my_drag, DT)
    conservation.receive(my_forces, DT)
    solids = comm.allreduce(float(np.sum(1.0 - coupling.voidage))) * grid.cell_volume
    local = coupling.halo.local
    owned = all_cells[my_cells]
    return {
        "ranks": comm.size,
        "particles": comm.allgather(len(my_particles)),
        "strays": int(comm.allreduce(int(np.sum(np.searchsorted(edges[1:-1], places[my_particles, 0]) != comm.rank)))),
        "cells": comm.allgather(len(my_cells)),
        "voidage and drag": differ(comm, mine, cells[my_cells]),
        "forces": differ(comm, my_forces, forces[my_particles]),
        "drag": abs(total / drag - 1.0),
        "volume": abs(solids / float(np.sum(4 / 3 * np.pi * radii**3)) - 1.0),
        "momentum": conservation.momentum_error,
        **compare_halo(comm, grid, owned, local),
        **count_messages(comm, owned, local),
        "first cell": comm.allgather(local.low == (0, 0, 0)),
        "missing cell": name_missing_cell(comm, owned, local),
    }


def name_missing_cell(comm: MPI.Comm, owned: np.ndarray, local: LocalGrid) -> list[str]:
    """What each rank says if nobody owns the cell (0, 0, 0)."""
    try:
        HaloExchange(comm, local, owned[np.any(owned != 0, axis=1)])
    except FbcoupleError as error:
        words = str(error)
    else:
        words = ""
    return comm.allgather(words)


if __name__ == "__main__":
    results = compare(MPI.COMM_WORLD, sys.argv[1], json.loads(sys.argv[2]))
    if MPI.COMM_WORLD.rank == 0:
        print(json.dumps(results))

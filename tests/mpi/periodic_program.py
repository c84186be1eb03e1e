"""Run under mpirun by test_periodic_ranks.py: `periodic_program.py PASSES` prints one JSON object of differences.

The exchange of a box without side walls, on all ranks with particles that have left it by a side and are not yet back,
against one process with all of them inside. The cells are scattered over the ranks at random.
"""

from __future__ import annotations

import json
import sys

import numpy as np
from halo_program import CELLS, DT, REACH, SIZE, differ, give_up, make_case, run_coupling
from mpi4py import MPI

from fbcouple.coupling.coupling import Particles
from fbcouple.geometry.grid import Grid
from fbcouple.simulation.conservation import Conservation

COUNT = 300
SIDES = np.array([1.0, 1.0, 0.0])


def compare(comm: MPI.Comm, passes: int) -> dict:
    """Every rank draws the same random numbers."""
    rng, case = np.random.default_rng(4), make_case({"filter_passes": passes}, ("x", "y"))
    grid = Grid(CELLS, SIZE, (True, True, False))
    all_cells = np.stack(np.meshgrid(*map(np.arange, CELLS), indexing="ij"), axis=-1).reshape(-1, 3)
    owner = rng.integers(0, comm.size, len(all_cells))
    gas = rng.standard_normal((len(all_cells), 12)) * ([1.0, 1.0, 1.0, 1e3, 1e3, 1e3] * 2)
    radii = rng.uniform(3e-4, 5e-4, COUNT)
    strayed = rng.uniform(-REACH * SIDES, SIZE + REACH * SIDES, (COUNT, 3))
    inside = np.where(SIDES, strayed % SIZE, strayed)
    velocities, masses = rng.standard_normal((COUNT, 3)), 2500.0 * 4 / 3 * np.pi * radii**3

    edges = np.arange(comm.size + 1) * SIZE[0] / comm.size
    bounds = np.array([[edges[comm.rank], 0.0, 0.0], [edges[comm.rank + 1], *SIZE[1:]]])
    holder = np.searchsorted(edges[1:-1], strayed[:, 0])
    my_cells, mine = np.flatnonzero(owner == comm.rank), np.flatnonzero(holder == comm.rank)

    centres = (all_cells + 0.5) * grid.spacing
    whole = np.array([[0.0] * 3, SIZE])
    everyone = Particles(inside, velocities, radii, masses)
    _, cells, forces, drag = run_coupling(case, MPI.COMM_SELF, centres, whole, everyone, gas)
    own = Particles(strayed[mine], velocities[mine], radii[mine], masses[mine])
    coupling, my_fields, my_forces, my_drag = run_coupling(case, comm, centres[my_cells], bounds, own, gas[my_cells])
    conservation = Conservation(comm)
    momentum_loss = give_up(coupling, gas[my_cells][:, 6:], grid.cell_volume)
    conservation.give(coupling.find_gas_loss(momentum_loss), my_drag, DT)
    conservation.receive(my_forces, DT)
    solids = comm.allreduce(float(np.sum(1.0 - coupling.voidage))) * grid.cell_volume
    return {
        "ranks": comm.size,
        "strayed": int((np.abs(strayed - inside) > 0).any(axis=1).sum()),
        "voidage and drag": differ(comm, my_fields, cells[my_cells]),
        "forces": differ(comm, my_forces, forces[mine]),
        "drag": abs(comm.allreduce(my_drag) / drag - 1.0),
        "volume": abs(solids / float(np.sum(4 / 3 * np.pi * radii**3)) - 1.0),
        "momentum": conservation.momentum_error,
    }


if __name__ == "__main__":
    results = compare(MPI.COMM_WORLD, int(sys.argv[1]))
    if MPI.COMM_WORLD.rank == 0:
        print(json.dumps(results))

"""Run under mpirun by test_traffic_ranks.py: `openings_program.py FOLDER`, where vessel.msh lies, leaves found.json.

Particles leave a vessel from a mesh file by patches of its side and its floor, the second of which opens later, while
gas passes and two feeds go on: 20 coupling steps.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.simulation import loop
from fbcouple.verify.harness import FRICTIONLESS, GAS, GLASS, open_bench

SECTIONS = {
    "domain": {"shape": "file", "mesh": "vessel.msh", "size": [0.020, 0.012, 0.03], "cells": [10, 6, 15]},
    "gas": GAS | {"inlet_velocity": 0.5, "pressure_tolerance": 1e-12, "max_courant": 0.5},
    "particles": GLASS
    | {
        "rotation": True,
        "feeds": [
            {"low": [0.008, -0.002, 0.01], "high": [0.0138, 0.002, 0.014], "rate": 4e4, "velocity": [2.5, 0.3, 0.0]},
            {"low": [-0.004, -0.004, 0.006], "high": [0.004, 0.004, 0.008], "rate": 4e4, "velocity": [0.0, 0.5, -3.0]},
        ],
        "outlets": [{"patches": ["sp*"]}, {"patches": ["drain"], "start": 1e-3}],
    },
    "contact": FRICTIONLESS | {"friction": 0.3, "wall_friction": 0.3, "tangential": "history", "stiffness": 200.0},
    "exchange": {"drag": "gidaspow", "filter_passes": 1},
}


def find_start() -> np.ndarray:
    """Places of a bed on the floor, next to each other."""
    axes = (np.arange(10) - 4.5) * 1.05e-3, (np.arange(10) - 4.5) * 1.05e-3, np.arange(4) * 0.99e-3 + 0.5e-3
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def run(place: Path, comm: MPI.Comm, steps: int = 20) -> dict:
    """Identity, place, velocity and gas force of every particle after the steps, and what came and went."""
    sim = open_bench(place, comm, SECTIONS, find_start(), case_folder=place)
    assert sim.traffic is not None
    sim.liggghts.velocities[:, 2] = -0.6
    sim.initialise()
    worst = solids = 0.0
    for _ in range(steps):
        loop.step(sim)
        worst = max(worst, sim.traffic.hold())
        own = comm.allreduce(float((4.0 / 3.0 * np.pi * sim.liggghts.radii**3).sum()))
        solids = max(solids, abs(comm.allreduce(sim.cells.add_up(1.0 - sim.coupling.voidage)) / own - 1.0))
    own = sim.liggghts
    rows = np.hstack([own.identity, own.positions, own.velocities, own.radii[:, None], own.gas_force])
    rows = np.concatenate(comm.allgather(rows))
    return {
        "ranks": comm.size,
        "time": sim.time,
        "rows": rows[np.argsort(rows[:, 0])].tolist(),
        "exits": sim.traffic.exits.tolist(),
        "ledger": sim.traffic.ledger.save(),
        "error": worst,
        "solids": solids,
        "owed": sim.traffic.count_owed(sim.time),
        "momentum": sim.conservation.momentum_error,
    }


if __name__ == "__main__":
    folder = Path(sys.argv[1]).resolve()
    found = run(folder, MPI.COMM_WORLD)
    if MPI.COMM_WORLD.rank == 0:
        (folder / "found.json").write_text(json.dumps(found))

"""Run under mpirun by test_traffic_ranks.py: `traffic_program.py FOLDER` leaves FOLDER/found.json.

A bed of two species that two feeds add to and two outlets take from, blown through: 20 coupling steps.
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
    "domain": {"size": [0.02, 0.01, 0.04], "cells": [5, 3, 10], "periodic": ["y"]},
    "gas": GAS | {"inlet_velocity": 1.5, "pressure_tolerance": 1e-12},
    "particles": GLASS
    | {
        "mixture": [[0.8e-3, 4000.0, 0.3]],
        "rotation": True,
        "feeds": [
            {"low": [0.0, 0.0, 0.012], "high": [0.006, 0.01, 0.014], "rate": 6e4, "velocity": [0.1, 0.0, -0.5]},
            {"low": [0.0, 0.0, 0.012], "high": [0.02, 0.01, 0.02], "mass_flow": 0.1, "species": 2, "seed": 3},
        ],
        "outlets": [
            {"low": [0.0, 0.0, 0.0], "high": [0.004, 0.01, 0.002]},
            {"low": [0.016, 0.002, 0.004], "high": [0.02, 0.006, 0.008]},
        ],
    },
    "contact": FRICTIONLESS | {"friction": 0.3, "wall_friction": 0.3, "tangential": "history", "stiffness": 200.0},
    "exchange": {"drag": "gidaspow", "filter_passes": 1},
}


def find_start() -> np.ndarray:
    """Places of a bed that touches itself."""
    axes = np.arange(20) * 1e-3 + 0.5e-3, np.arange(10) * 1e-3 + 0.5e-3, np.arange(8) * 0.99e-3 + 0.5e-3
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def run(place: Path, comm: MPI.Comm, steps: int = 20) -> dict:
    """Identity, place, velocity, radius and gas force of every particle after the steps, and what came and went."""
    sim = open_bench(place, comm, SECTIONS, find_start())
    sim.initialise()
    for _ in range(steps):
        loop.step(sim)
    assert sim.traffic is not None
    own = sim.liggghts
    rows = np.hstack([own.identity, own.positions, own.velocities, own.radii[:, None], sim.liggghts.gas_force])
    rows = np.concatenate(comm.allgather(rows))
    return {
        "ranks": comm.size,
        "rows": rows[np.argsort(rows[:, 0])].tolist(),
        "exits": sim.traffic.exits.tolist(),
        "ledger": sim.traffic.ledger.save(),
        "error": sim.traffic.hold(),
        "owed": sim.traffic.count_owed(sim.time),
        "momentum": sim.conservation.momentum_error,
    }


if __name__ == "__main__":
    folder = Path(sys.argv[1]).resolve()
    found = run(folder, MPI.COMM_WORLD)
    if MPI.COMM_WORLD.rank == 0:
        (folder / "found.json").write_text(json.dumps(found))

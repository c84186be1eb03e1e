"""Gas over a closed nozzle with a sub-grid model: `mpirun -n RANKS python turbulence_program.py MODEL FOLDER`."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from mpi4py import MPI

from fbcouple.verify.harness import GAS, open_bench

CELLS = (16, 8, 16)
STEPS, DT = 30, 2e-4


def main() -> None:
    """Leave the velocity of every cell in FOLDER/velocity.npy."""
    comm, model, place = MPI.COMM_WORLD, sys.argv[1], Path(sys.argv[2])
    domain = {"size": [0.005 * n for n in CELLS], "cells": list(CELLS)}
    gas = GAS | {"inlet_velocity": 1.2, "closed_nozzle": [4, 4], "turbulence": model, "pressure_tolerance": 1e-11}
    bench = open_bench(place, comm, {"domain": domain, "gas": gas})
    assert bench.gas is not None
    for _ in range(STEPS):
        bench.gas.step(DT, *bench.gas.clean_input)
    own = np.zeros((*CELLS, 3))
    own[tuple(bench.owned.T)] = bench.gas.velocity
    velocity = comm.reduce(own)
    if comm.rank == 0:
        np.save(place / "velocity.npy", velocity)


if __name__ == "__main__":
    main()

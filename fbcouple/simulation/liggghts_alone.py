"""LIGGGHTS alone in one process: `python -m fbcouple.simulation.liggghts_alone FOLDER`.

FOLDER has a deck, DEM/in.liggghts with its files, and task.json; the particles are written to particles.npz in the
order of their numbers. Without `rest` they are written as they were read; with it DEM steps are taken until all of them
are slower than that.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.solvers.liggghts import Liggghts

TASK, PARTICLES = "task.json", "particles.npz"
_LOOKS = 2
"""Times in a row that all particles must be found at rest."""


def main() -> None:
    """Do the task; what goes wrong ends the process with its words on stderr."""
    os.chdir(sys.argv[1])
    task = json.loads(Path(TASK).read_text(encoding="utf-8"))
    restart = Path(task["restart"]) if task["restart"] else None
    liggghts = Liggghts(Path("DEM/in.liggghts"), Path("liggghts.log"), MPI.COMM_WORLD, restart)
    taken, fastest = _settle(liggghts, task) if task["rest"] else (0, _find_speed(liggghts))
    order = np.argsort(liggghts.numbers)
    columns = {
        "positions": liggghts.positions,
        "velocities": liggghts.velocities,
        "spins": liggghts.angular_velocities,
        "types": liggghts.types,
    }
    found: dict[str, Any] = {name: values[order] for name, values in columns.items()}
    np.savez(PARTICLES, steps=taken, fastest=fastest, **found)
    liggghts.close()


def _settle(liggghts: Liggghts, task: dict[str, Any]) -> tuple[int, float]:
    """Take DEM steps until all are at rest, or `most` are taken. Returns: steps taken, speed [m/s] of the fastest."""
    taken, rested, fastest = 0, 0, np.inf
    while rested < _LOOKS and taken < task["most"]:
        liggghts.advance(task["every"], first=not taken)
        taken += task["every"]
        fastest = _find_speed(liggghts)
        rested = rested + 1 if fastest < task["rest"] else 0
    return taken, fastest


def _find_speed(liggghts: Liggghts) -> float:
    """Of the fastest particle [m/s]."""
    return float(np.sqrt((liggghts.velocities**2).sum(axis=1).max(initial=0.0)))


if __name__ == "__main__":
    main()

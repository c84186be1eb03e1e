"""LIGGGHTS alone in one process: `python -m fbcouple.simulation.liggghts_alone FOLDER`.

FOLDER has a deck, DEM/in.liggghts with its files, and task.json; the particles are written to particles.npz in the
order of their numbers. Without `rest` they are written as they were read; with it DEM steps are taken until they are at
rest: the root mean square of their speeds below that, the fastest below ten times that (a few rattle in their cages for
long). What it does is told on stdout, a line every look.
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
"""Times in a row that the particles must be found at rest."""
_FASTEST = 100.0
"""Speed of the fastest over the root mean square that is at rest: with that of 1 % of sqrt(g d), a fall of half a
diameter. Closer would be a matter of chance in a large bed, where single particles slip at any time."""


def main() -> None:
    """Do the task; what goes wrong ends the process with its words on stderr."""
    os.chdir(sys.argv[1])
    task = json.loads(Path(TASK).read_text(encoding="utf-8"))
    restart = Path(task["restart"]) if task["restart"] else None
    liggghts = Liggghts(Path("DEM/in.liggghts"), Path("liggghts.log"), MPI.COMM_WORLD, restart)
    taken, speed = _settle(liggghts, task) if task["rest"] else (0, _find_speeds(liggghts)[1])
    order = np.argsort(liggghts.numbers)
    columns = {
        "positions": liggghts.positions,
        "velocities": liggghts.velocities,
        "spins": liggghts.angular_velocities,
        "types": liggghts.types,
        "radii": liggghts.radii,
        "densities": liggghts.densities,
    }
    if liggghts.has_temperatures():
        columns["temperatures"] = liggghts.temperatures
    found: dict[str, Any] = {name: values[order] for name, values in columns.items()}
    np.savez(PARTICLES, steps=taken, speed=speed, **found)
    liggghts.close()


def _settle(liggghts: Liggghts, task: dict[str, Any]) -> tuple[int, float]:
    """Take DEM steps until all are at rest, or `most` are taken. Returns: steps taken, and the speed [m/s] that is held
    against `rest`."""
    taken, rested, speed = 0, 0, np.inf
    while rested < _LOOKS and taken < task["most"]:
        liggghts.advance(task["every"], first=not taken)
        taken += task["every"]
        mean, fastest = _find_speeds(liggghts)
        speed = max(mean, fastest / _FASTEST)
        rested = rested + 1 if speed < task["rest"] else 0
        print(taken, speed, flush=True)
    return taken, speed


def _find_speeds(liggghts: Liggghts) -> tuple[float, float]:
    """Root mean square, and largest, of the speeds [m/s]."""
    squares = (liggghts.velocities**2).sum(axis=1)
    return float(np.sqrt(squares.mean())), float(np.sqrt(squares.max()))


if __name__ == "__main__":
    main()

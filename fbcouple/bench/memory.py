"""What a rank keeps in memory beside the solvers, per particle and per cell."""

from __future__ import annotations

import gc
import resource
import types
from typing import Any

import numpy as np
from mpi4py import MPI

from fbcouple.bench.measure import open_run
from fbcouple.case.schema.sections import Case
from fbcouple.simulation.loop import step

_ELSEWHERE = (type, types.ModuleType, types.FunctionType, types.BuiltinFunctionType, types.FrameType)
_STEPS = 3


def measure_memory(case: Case, comm: MPI.Comm) -> dict[str, Any]:
    """Bytes in the arrays of simulation and tasks after a few coupled steps, a row a rank, and the whole process
    (collective).

    An array as long as the rank's particles, or up to half again, counts for them; the rest is the cells'. Memory of
    the solvers that an array merely looks at is not counted.
    """
    sim, tasks = open_run(case, comm)
    for _ in range(_STEPS):
        step(sim, tasks)
    particles, cells = sim.liggghts.count if sim.has_particles else 0, len(sim.owned)
    of_particles = of_cells = 0
    for array in find_arrays([sim, *tasks]):
        if particles and particles <= array.size and particles <= len(array) <= 1.5 * particles and particles > cells:
            of_particles += array.nbytes
        else:
            of_cells += array.nbytes
    row = {
        "rank": comm.rank,
        "particles": particles,
        "cells": cells,
        "bytes_per_particle": of_particles / particles if particles else 0.0,
        "bytes_per_cell": of_cells / cells,
        "process_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
    }
    return {"ranks": comm.allgather(row)}


def find_arrays(roots: list[Any]) -> list[np.ndarray]:
    """Every array that holds memory of its own and can be reached from `roots`."""
    seen: set[int] = set()
    arrays: dict[int, np.ndarray] = {}
    waiting = list(roots)
    while waiting:
        thing = waiting.pop()
        if id(thing) in seen or isinstance(thing, _ELSEWHERE):
            continue
        seen.add(id(thing))
        if isinstance(thing, np.ndarray):
            owner = thing
            while isinstance(owner.base, np.ndarray):
                owner = owner.base
            if owner.base is None:
                arrays[id(owner)] = owner
            continue
        waiting.extend(gc.get_referents(thing))
    return list(arrays.values())

"""What a case costs, and what its run holds: a variant of `fbcouple bench parts`."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from mpi4py import MPI

from fbcouple.bench.measure import open_run, time_coupled
from fbcouple.bench.memory import find_arrays
from fbcouple.case.schema.sections import Case
from fbcouple.results.variables import STAGES
from fbcouple.simulation.tasks.averages import Averages

_BLOCKS = 10
_LIBRARIES = ("libliggghts", "libOpenFOAM")


def measure_variant(case: Case, comm: MPI.Comm, warm: float, steps: int) -> dict[str, Any]:
    """Processor seconds of a coupled step after `warm` [s] of simulated time, in the cheapest tenth of `steps`, and
    what the run holds: parts of the scene, solver libraries in memory, arrays, stages that took time (one rank)."""
    sim, tasks = open_run(case, comm, warm)
    blocks: list[tuple[float, float]] = []
    stages = set()
    for _ in range(_BLOCKS):
        begin = time.process_time()
        taken = time_coupled(sim, tasks, max(1, steps // _BLOCKS))
        length = sum(dt for dt, _ in taken.steps)
        blocks.append(((time.process_time() - begin) / length, length / len(taken.steps)))
        stages |= {stage for stage, value in taken.stages.items() if value > 0.0}
    cost, step_length = min(blocks)
    held = {
        "liggghts": sim.has_particles,
        "gas": sim.has_gas,
        "coupling": sim.is_coupled,
        "averaging": any(isinstance(task, Averages) for task in tasks),
        "forces": sim.is_coupled and sim.coupling.forces is not None,
    }
    parts = [name for name, is_there in held.items() if is_there]
    maps = Path("/proc/self/maps").read_text(encoding="utf-8", errors="surrogateescape")
    return {
        "cpu_seconds_per_second": cost,
        "step": step_length,
        "parts": " ".join(parts),
        "libraries": " ".join(name for name in _LIBRARIES if name in maps),
        "arrays_kB": sum(array.nbytes for array in find_arrays([sim, *tasks])) / 1e3,
        "stages": " ".join(stage for stage in STAGES if stage in stages),
    }

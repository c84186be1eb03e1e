"""CFD-DEM of fluidized beds: stock OpenFOAM (gas) and stock LIGGGHTS (particles) in one MPI job.

run = fbcouple.setup("patil/c2", "runs/mine", {"gas.inlet_velocity": 1.5})
run.start(ranks=2)
data = run.results()
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

from fbcouple.version import __version__

if TYPE_CHECKING:
    from fbcouple.api import Run, Status, load_case, plan_case, pool, report, setup
    from fbcouple.batch.sets import run_set, start_replicas
    from fbcouple.live import Simulation
    from fbcouple.simulation.tasks.task import Saved, Task

__all__ = [
    "Run",
    "Saved",
    "Simulation",
    "Status",
    "Task",
    "__version__",
    "load_case",
    "plan_case",
    "pool",
    "report",
    "run_set",
    "setup",
    "start_replicas",
]

_FACE = dict.fromkeys(("Run", "Status", "load_case", "plan_case", "pool", "report", "setup"), "fbcouple.api")
_FACE |= dict.fromkeys(("run_set", "start_replicas"), "fbcouple.batch.sets")
_FACE |= {"Simulation": "fbcouple.live"} | dict.fromkeys(("Saved", "Task"), "fbcouple.simulation.tasks.task")
"""Name -> module that has it, imported when it is first asked for: mpi4py starts MPI as it is imported."""

# Results are written beside their name and renamed, so nobody meets a file that is being written; HDF5's own locks only
# keep them from being read or written on file systems that have none.
os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")


def __getattr__(name: str) -> Any:
    if name not in _FACE:
        raise AttributeError(f"module 'fbcouple' has no attribute {name!r}")
    return getattr(import_module(_FACE[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_FACE])

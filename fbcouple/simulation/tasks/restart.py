"""Everything that a run goes on from, to the files of a checkpoint and back.

Each task saves and loads itself. A field of the gas needs no line here: OpenFOAM writes every registered one that has
AUTO_WRITE, and reads it back if the adapter constructs it with READ_IF_PRESENT.
"""

from __future__ import annotations

import errno
import json
import os
import resource
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.errors import CaseError, SolverError
from fbcouple.run_folder import checkpoint
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.task import Saved, Task, name_task

RESTART = "liggghts.restart"
_CHUNK = 1 << 24
_STATE = "state.json"


def write_checkpoint(sim: Simulation, tasks: Sequence[Task], run: Path, about: dict[str, Any]) -> Path:
    """Write the checkpoint of the step just taken and return its folder (collective).

    about: what `checkpoint.describe` says of the run, on rank 0.
    Raises SolverError if the disk does not take it, or a task saves what it could not be read with again; the
    checkpoints before it stand.
    """
    comm, step = sim.comm, sim.clock.steps
    try:
        folder = comm.bcast(checkpoint.begin(run, step) if comm.rank == 0 else None)
        sums = checkpoint.add_up(folder, _write_parts(sim, tasks, folder))
        gathered = comm.gather(sums)
        path = None
        if gathered is not None:
            moment = {"step": step, "time": sim.clock.time, "ranks": comm.size}
            path = checkpoint.finish(folder, about | moment, {name: s for part in gathered for name, s in part.items()})
        return comm.bcast(path)
    except (OSError, CaseError, SolverError) as error:
        checkpoint.abandon(run)
        stands = checkpoint.format_newest(run)
        raise SolverError(f"the checkpoint of step {step} cannot be written: {error}; {stands}") from error


def _write_parts(sim: Simulation, tasks: Sequence[Task], folder: Path) -> list[Path]:
    """Write this rank's files and name them (collective)."""
    rank = sim.comm.rank
    saved = {name_task(task): task.save(sim, folder) for task in tasks}
    written = [Path(f"cells-{rank:04d}.npz")]
    cells = {f"{name}/{column}": rows for name, part in saved.items() for column, rows in part.cells.items()}
    np.savez(folder / written[0], allow_pickle=False, **(cells | {"owned": sim.owned}))
    if sim.has_gas:
        fields = sim.gas.write()
        relative = Path("CFD") / (f"processor{rank}" if sim.comm.size > 1 else "") / fields.name
        (folder / relative).parent.mkdir(parents=True, exist_ok=True)
        fields.rename(folder / relative)
        written.append(relative)
    if sim.has_particles:
        _write_particles(sim, folder / RESTART)
    if rank == 0:
        written += [Path(RESTART)] if sim.has_particles else []
        written += [Path(name) for part in saved.values() for name in part.files]
        state = {"clock": sim.clock.save(), "tasks": {name: part.numbers for name, part in saved.items()}}
        (folder / _STATE).write_text(json.dumps(state), encoding="utf-8")
        written.append(Path(_STATE))
    return written


def _write_particles(sim: Simulation, path: Path) -> None:
    """LIGGGHTS writes into memory, and what it wrote to the disk: it does not notice a disk that is full."""
    memory = os.memfd_create("restart") if sim.comm.rank == 0 else -1
    sim.liggghts.command(f"write_restart /proc/self/fd/{sim.comm.bcast(memory)}")
    if sim.comm.rank == 0:
        with os.fdopen(memory, "rb") as source, path.open("wb") as target:
            longest = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
            if longest != resource.RLIM_INFINITY and os.fstat(source.fileno()).st_size >= longest:
                raise OSError(errno.EFBIG, f"the particles need more than the {longest} bytes that a file may have")
            source.seek(0)
            while chunk := source.read(_CHUNK):
                target.write(chunk)


def read_checkpoint(sim: Simulation, tasks: Sequence[Task], folder: Path, others: Sequence[Task] = ()) -> None:
    """Put the clock, `tasks`, and those of `others` that it has, into the state of the checkpoint in `folder`; the
    solvers are in it already.

    Raises: CaseError if it holds other things than this run writes, whole as it may be.
    """
    try:
        state = json.loads((folder / _STATE).read_text(encoding="utf-8"))
        sim.clock.load(state["clock"])
        cells = _load_cells(sim, folder)
        known = [task for task in others if name_task(task) in state["tasks"]]
        for task in [*tasks, *known]:
            name = name_task(task)
            own = {key.removeprefix(f"{name}/"): rows for key, rows in cells.items() if key.startswith(f"{name}/")}
            task.load(sim, Saved(state["tasks"][name], own), folder)
    except (LookupError, ValueError, TypeError, AttributeError) as error:
        words = f"{type(error).__name__}: {error}"
        raise CaseError([f"{folder}: does not hold the state of this run ({words}); --fresh starts again"]) from error


def _load_cells(sim: Simulation, folder: Path) -> dict[str, np.ndarray]:
    """Rows of this rank's cells, whichever ranks wrote them."""
    own = folder / f"cells-{sim.comm.rank:04d}.npz"
    files = sorted(folder.glob("cells-*.npz"))
    if len(files) == sim.comm.size:
        found = dict(np.load(own))
        if np.array_equal(found.pop("owned"), sim.owned):
            return found
    indices = np.full(sim.cells.shape, -1)
    indices[tuple(sim.owned.T)] = np.arange(len(sim.owned))
    cells: dict[str, np.ndarray] = {}
    for file in files:
        found = dict(np.load(file))
        index = indices[tuple(found.pop("owned").T)]
        for name, rows in found.items():
            mine = cells.setdefault(name, np.zeros((len(sim.owned), *rows.shape[1:])))
            mine[index[index >= 0]] = rows[index >= 0]
    return cells

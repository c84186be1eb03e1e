"""Everything that a run goes on from, to the files of a checkpoint and back.

A part with numbers of its own that outlive a step gets a `save` and a `load`, and a line in `_list_parts`, or a new
entry in `Recorder.save_state`. A field of the gas needs no line here: OpenFOAM writes every registered one that
has AUTO_WRITE, and reads it back if the adapter constructs it with READ_IF_PRESENT.
"""

from __future__ import annotations

import errno
import json
import os
import resource
from pathlib import Path
from typing import Any

import numpy as np

from fbcouple.errors import CaseError, SolverError
from fbcouple.run_folder import checkpoint
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.averages import Means
from fbcouple.simulation.tasks.history import Recorder

RESTART = "liggghts.restart"
_CHUNK = 1 << 24


def write_checkpoint(sim: Simulation, recorder: Recorder, run: Path, about: dict[str, Any]) -> Path:
    """Write the checkpoint of the step just taken and return its folder (collective).

    about: what `checkpoint.describe` says of the run, on rank 0.
    Raises SolverError if the disk does not take it; the checkpoints before it stand.
    """
    comm, step = sim.comm, sim.clock.steps
    try:
        folder = comm.bcast(checkpoint.begin(run, step) if comm.rank == 0 else None)
        sums = checkpoint.add_up(folder, _write_parts(sim, recorder, folder))
        gathered = comm.gather(sums)
        place = None
        if gathered is not None:
            moment = {"step": step, "time": sim.clock.time, "ranks": comm.size}
            place = checkpoint.finish(
                folder, about | moment, {name: s for part in gathered for name, s in part.items()}
            )
        return comm.bcast(place)
    except (OSError, SolverError) as error:
        checkpoint.abandon(run)
        stands = checkpoint.word_newest(run)
        raise SolverError(f"the checkpoint of step {step} cannot be written: {error}; {stands}") from error


def _write_parts(sim: Simulation, recorder: Recorder, folder: Path) -> list[Path]:
    """Write this rank's files and name them (collective)."""
    rank = sim.comm.rank
    written = [Path(f"cells-{rank:04d}.npz")]
    sums = _save_sums(sim) | {"owned": sim.owned}
    np.savez(folder / written[0], allow_pickle=False, **sums)
    if sim.gas:
        fields = sim.gas.write()
        place = Path("CFD") / (f"processor{rank}" if sim.comm.size > 1 else "") / fields.name
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        fields.rename(folder / place)
        written.append(place)
    if sim.liggghts:
        _write_grains(sim, folder / RESTART)
    if rank == 0:
        written += [Path(RESTART)] if sim.liggghts else []
        written += recorder.save_state(sim, folder)
        (folder / "state.json").write_text(json.dumps(_save_numbers(sim)), encoding="utf-8")
        written.append(Path("state.json"))
    return written


def _write_grains(sim: Simulation, place: Path) -> None:
    """LIGGGHTS writes into memory, and what it wrote to the disk: it does not notice a disk that is full."""
    assert sim.liggghts is not None
    memory = os.memfd_create("restart") if sim.comm.rank == 0 else -1
    sim.liggghts.command(f"write_restart /proc/self/fd/{sim.comm.bcast(memory)}")
    if sim.comm.rank == 0:
        with os.fdopen(memory, "rb") as source, place.open("wb") as target:
            longest = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
            if longest != resource.RLIM_INFINITY and os.fstat(source.fileno()).st_size >= longest:
                raise OSError(errno.EFBIG, f"the particles need more than the {longest} bytes that a file may have")
            source.seek(0)
            while chunk := source.read(_CHUNK):
                target.write(chunk)


def _list_parts(sim: Simulation) -> dict[str, Means]:
    averaging = sim.averaging
    means = {"solids": averaging.solids, "gas": averaging.gas} if averaging else {}
    return {phase: part for phase, part in means.items() if part}


def _save_numbers(sim: Simulation) -> dict[str, Any]:
    numbers: dict[str, Any] = {"clock": sim.clock.save()}
    if sim.averaging:
        numbers["averaging"] = sim.averaging.cadence.next
        numbers["means"] = {phase: means.save()[0] for phase, means in _list_parts(sim).items()}
    return numbers


def _save_sums(sim: Simulation) -> dict[str, np.ndarray]:
    parts = _list_parts(sim).items()
    return {f"{phase}.{name}": sums for phase, means in parts for name, sums in means.save()[1].items()}


def read_checkpoint(sim: Simulation, recorder: Recorder, folder: Path) -> None:
    """Put `scene` and `recorder` into the state of the checkpoint in `folder`; the solvers are in it already.

    Raises: CaseError if it holds other things than this run writes, whole as it may be.
    """
    try:
        _read_state(sim, recorder, folder)
    except (LookupError, ValueError, TypeError, AttributeError) as error:
        words = f"{type(error).__name__}: {error}"
        raise CaseError([f"{folder}: does not hold the state of this run ({words}); --fresh starts again"]) from error


def _read_state(sim: Simulation, recorder: Recorder, folder: Path) -> None:
    numbers = json.loads((folder / "state.json").read_text(encoding="utf-8"))
    sim.clock.load(numbers["clock"])
    sums = _load_sums(sim, folder)
    if sim.averaging:
        sim.averaging.cadence.next = numbers["averaging"]
        for phase, means in _list_parts(sim).items():
            own = {name.partition(".")[2]: rows for name, rows in sums.items() if name.startswith(f"{phase}.")}
            means.load(numbers["means"][phase], own)
    recorder.load_state(folder)


def _load_sums(sim: Simulation, folder: Path) -> dict[str, np.ndarray]:
    """Rows of this rank's cells, whichever ranks wrote them."""
    own = folder / f"cells-{sim.comm.rank:04d}.npz"
    files = sorted(folder.glob("cells-*.npz"))
    if len(files) == sim.comm.size:
        found = dict(np.load(own))
        if np.array_equal(found.pop("owned"), sim.owned):
            return found
    places = np.full(sim.cells.shape, -1)
    places[tuple(sim.owned.T)] = np.arange(len(sim.owned))
    sums: dict[str, np.ndarray] = {}
    for file in files:
        found = dict(np.load(file))
        place = places[tuple(found.pop("owned").T)]
        for name, rows in found.items():
            mine = sums.setdefault(name, np.zeros((len(sim.owned), *rows.shape[1:])))
            mine[place[place >= 0]] = rows[place >= 0]
    return sums

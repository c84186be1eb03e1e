"""Which tasks a run has, in their order."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fbcouple.paths import FRAMES
from fbcouple.run_folder.checkpoint import describe
from fbcouple.run_folder.provenance import list_makers, read_making
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.averages import Averages
from fbcouple.simulation.tasks.checkpoints import Checkpoints, Limits, StopSignal
from fbcouple.simulation.tasks.frames import Frames
from fbcouple.simulation.tasks.history import History
from fbcouple.simulation.tasks.ledger import LedgerKeeper
from fbcouple.simulation.tasks.monitors import Monitors
from fbcouple.simulation.tasks.probes import Probes
from fbcouple.simulation.tasks.restart import read_checkpoint
from fbcouple.simulation.tasks.results_file import ResultsFile
from fbcouple.simulation.tasks.snapshots import Snapshots
from fbcouple.simulation.tasks.task import Task
from fbcouple.simulation.user_tasks import load_tasks, require_names


def open_tasks(
    sim: Simulation, limits: Limits, stop_signal: StopSignal, resume: Path | None, others: Sequence[Task] = ()
) -> list[Task]:
    """The tasks of the run in the current folder, then `others`, the checkpoints last, in the state of the checkpoint
    `resume` if one is given (collective)."""
    here = Path()
    made = read_making(here)
    monitors, tasks = list_tasks(
        sim, here, (here / "case.toml").read_text(encoding="utf-8-sig"), made.list_attributes()
    )
    require_names([*tasks, *others])
    if resume:
        read_checkpoint(sim, tasks, resume, others)
    tasks += others
    about = describe(sim.case, here, list_makers(made.versions), made.updates) if sim.comm.rank == 0 else {}
    return [*tasks, Checkpoints(sim, here, limits, stop_signal, about, monitors, tasks)]


def list_tasks(
    sim: Simulation, run: Path, case_text: str, made_with: dict[str, Any] | None = None
) -> tuple[Monitors, list[Task]]:
    """The monitors, and all tasks that the case asks for, the monitors among them (collective).

    `run`: the run folder; `made_with`: what results.nc says of the programs that the run is made with.
    """
    case, output = sim.case, sim.case.output
    averages = Averages(sim, case.averages) if case.averages else None
    monitors = Monitors(sim, run)
    comm, cells = sim.comm, sim.cells
    snapshots = Snapshots(comm, cells, output.snapshots_every) if output.snapshots_every and sim.is_coupled else None
    frames = Frames(comm, cells, run / FRAMES, output.particles_every) if output.particles_every else None
    history = History(sim, run, monitors, averages)
    ledger = LedgerKeeper(sim.traffic) if sim.traffic else None
    probes = Probes(sim, run) if output.probes else None
    results = ResultsFile(run, case_text, history, averages, snapshots, made_with or {}, ledger, probes)
    own: tuple[Task | None, ...] = averages, monitors, snapshots, frames, probes, history, ledger, results
    tasks = [task for task in own if task]
    if output.task_file:
        tasks += load_tasks(run / output.task_file)
    return monitors, tasks

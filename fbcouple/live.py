"""A simulation in this very process, and under mpirun in every rank of it: live views of both solvers."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import TracebackType
from typing import TypeVar

from mpi4py import MPI

from fbcouple.arguments import in_python
from fbcouple.case.load import load_case
from fbcouple.errors import CaseError, FbcoupleError, SolverError
from fbcouple.launcher.launch import make_ready, note_run
from fbcouple.launcher.openfoam_mesh import Guard
from fbcouple.launcher.resume import Choice, Start
from fbcouple.launcher.stop_signals import Requests
from fbcouple.machine.unexpected import describe as describe_error
from fbcouple.run_folder.lock import hold
from fbcouple.run_folder.manifest import read_manifest
from fbcouple.run_folder.plain_files import require_plain
from fbcouple.simulation import loop
from fbcouple.simulation.simulation import Simulation as RankSimulation
from fbcouple.simulation.task_list import open_tasks
from fbcouple.simulation.tasks.checkpoints import Limits, StopSignal
from fbcouple.simulation.tasks.restart import RESTART
from fbcouple.simulation.tasks.task import Task

Made = TypeVar("Made")


class Simulation(RankSimulation):
    """A run folder as a simulation under your control, once per process.

        with fbcouple.Simulation.open("runs/mine") as sim:
            while sim.proceed:
                sim.step()
                print(sim.time, sim.gas.pressure.max(), sim.particles.velocities[:, 2].mean())

    Arrays are views of this rank's cells and particles, SI units, valid until the next step. History, time means,
    results.nc and checkpoints are written as `fbcouple run` writes them. The current folder is the run folder while it
    is open. An error inside OpenFOAM or LIGGGHTS can end the process: for anything that has to survive one, use `Run`.
    """

    _is_used = False

    @classmethod
    @in_python()
    def open(
        cls,
        run: str | os.PathLike[str],
        *,
        resume: bool = False,
        fresh: bool = False,
        trust: bool = False,
        tasks: Sequence[Task] = (),
        comm: MPI.Comm | None = None,
    ) -> Simulation:
        """Start the solvers of the run folder `run` in this process (collective over `comm`, by default all ranks).

        resume: go on from the newest good checkpoint; fresh: remove what an earlier run left; trust: as on the command
        line; tasks: of your own, which look at every step.

        Raises: CaseError, on every rank, if a simulation was open in this process before, or `run` cannot be started.
        """
        if Simulation._is_used:
            raise CaseError(["a process has one simulation, and this one had it: use Run, or another process."])
        comm = comm or MPI.COMM_WORLD
        path = Path(run).resolve()
        with ExitStack() as stack:
            choice = Choice(fresh=fresh, resume=resume, trusted=trust, say=print)
            start = _on_root(comm, lambda: _make_ready(path, comm.size, choice, stack))
            Simulation._is_used = True
            stack.enter_context(_inside(path))
            case, checkpoint = load_case("case.toml"), start.checkpoint
            folder = Path("checkpoints") / checkpoint.folder.name if checkpoint else None
            sim = cls(case, Path(), comm, case.end_time, folder / RESTART if folder else None)
            sim.tasks = open_tasks(sim, Limits(), StopSignal(), folder, tasks)
            sim.initialise()
            loop.start(sim, sim.tasks)
            sim._stack = stack.pop_all()
        return sim

    tasks: list[Task]
    """What looks at every step: averages, monitors, history, results, frames, your own, checkpoints."""
    _stack: ExitStack
    _is_finished = False

    def step(self) -> None:
        """One coupling step: gas, gas force, DEM steps, choice of the next step, voidage, drag; then the tasks look."""
        loop.step(self, self.tasks)

    def run(self) -> None:
        """Take the simulation to its end."""
        while self.proceed:
            self.step()
        self.finish()

    def finish(self) -> None:
        """Write results.nc and, at the end of the case, the last fields and a checkpoint; no step comes after it."""
        if self._is_finished:
            return
        self._is_finished = True
        if self.proceed:
            self.stop = "Simulation.finish"
        loop.finish(self, self.tasks)

    def close(self) -> None:
        """End LIGGGHTS and give the run folder back."""
        with self._stack:
            super().close()

    def __enter__(self) -> Simulation:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is None:
            self.finish()
        self.close()


@contextmanager
def _inside(folder: Path) -> Iterator[None]:
    """Be in `folder`, for OpenFOAM by its variable, too."""
    before, variable = os.getcwd(), os.environ.get("PWD")
    os.chdir(folder)
    os.environ["PWD"] = str(folder)
    try:
        yield
    finally:
        os.chdir(before)
        os.environ["PWD"] = before if variable is None else variable


def _make_ready(run: Path, ranks: int, choice: Choice, stack: ExitStack) -> Start:
    require_plain(run)
    read_manifest(run)
    lock = stack.enter_context(hold(run, choice.say))
    with Requests() as requests:
        start = make_ready(run, ranks, choice, Guard(lock, requests))
    if start is None:
        raise CaseError([f"{run}: is complete; fresh=True starts again."])
    note_run(run, ranks, ["fbcouple.Simulation.open"], start, choice.say)
    return start


def _on_root(comm: MPI.Comm, make: Callable[[], Made]) -> Made:
    """What `make` gives on rank 0, on all ranks; an error of it is raised on all."""
    made: Made | FbcoupleError | None = None
    if comm.rank == 0:
        try:
            made = make()
        except FbcoupleError as error:
            made = error
        except Exception as error:
            made = SolverError(f"unexpected error in rank 0: {describe_error(error)}")
            made.__cause__ = error
    cause = made.__cause__ if isinstance(made, FbcoupleError) else None
    made = comm.bcast(made)
    if isinstance(made, FbcoupleError):
        raise made from cause
    assert made is not None
    return made

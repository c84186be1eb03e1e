"""A rank of a run: started by the launcher as `mpirun -n RANKS python -m fbcouple.simulation.worker RUN [...]`."""

from __future__ import annotations

import argparse
import math
import os
import signal
import sys
import traceback
from pathlib import Path

from mpi4py import MPI

from fbcouple.case.load import load_case
from fbcouple.errors import FbcoupleError, SolverError, StoppedError
from fbcouple.machine.unexpected import describe as describe_error
from fbcouple.run_folder.checkpoint import find_checkpoint
from fbcouple.run_folder.failure import write_failure
from fbcouple.simulation import loop
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.task_list import open_tasks
from fbcouple.simulation.tasks.checkpoints import Limits, StopSignal
from fbcouple.simulation.tasks.restart import RESTART


def work(run: Path, limits: Limits, resume: Path | None, comm: MPI.Comm, stop_signal: StopSignal) -> None:
    """Run the case in `run` from its start, or from the checkpoint `resume` in it (collective); one that has to stop
    early leaves a note of it."""
    os.chdir(run)
    os.environ["PWD"] = str(run)
    case = load_case("case.toml")
    sim = Simulation(case, Path(), comm, case.end_time, resume / RESTART if resume else None)
    tasks = open_tasks(sim, limits, stop_signal, resume)
    sim.initialise()
    loop.run(sim, tasks)
    sim.close()
    if sim.stopped_early and comm.rank == 0:
        write_failure(Path(), format_stop(sim), StoppedError.exit_code)
    if stop_signal.caught and not sim.stopped_early:
        print(
            f"{signal.Signals(stop_signal.caught).name} came after the last moment to stop: the run went on to its end"
        )


def format_stop(sim: Simulation) -> str:
    """Say why the run stopped early and where it goes on."""
    return f"stopped by {sim.stop} at t = {sim.clock.time:.6g} s; checkpoint: {sim.checkpoint}"


def main() -> None:
    """Work; a failure on one rank writes down why and ends all ranks."""
    stop_signal = StopSignal()
    options = read_options()
    run = options.run.resolve()
    try:
        require_together(MPI.COMM_WORLD, options.ranks)
        work(run, Limits(options.until, options.deadline), options.resume, MPI.COMM_WORLD, stop_signal)
    except FbcoupleError as error:
        end_all(run, str(error), error.exit_code)
    except BaseException as error:
        traceback.print_exc()
        text = f"unexpected error in rank {MPI.COMM_WORLD.rank}: {describe_error(error)}; traceback: logs/launcher.log"
        end_all(run, text, SolverError.exit_code)


def end_all(run: Path, text: str, exit_code: int) -> None:
    """End every rank; the reason is written down first, if the disk takes it, and told to the launcher."""
    try:
        print(text, file=sys.stderr, flush=True)
        write_failure(run, text, exit_code)
    finally:
        MPI.COMM_WORLD.Abort(exit_code)


def require_together(comm: MPI.Comm, ranks: int) -> None:
    """Raise SolverError unless the launcher has made one job of `ranks` ranks."""
    if comm.size != ranks:
        raise SolverError(
            f"mpirun was asked for {ranks} ranks and this process finds {comm.size}: the launcher is not of mpi4py's "
            f"MPI, {MPI.Get_library_version().split(',')[0].strip()}; fix: fbcouple doctor"
        )


def read_options() -> argparse.Namespace:
    """What `fbcouple.launcher.launch` said on the command line."""
    parser = argparse.ArgumentParser()
    parser.add_argument("run", type=Path)
    parser.add_argument("--ranks", type=int, required=True)
    parser.add_argument("--until", type=float, default=math.inf)
    parser.add_argument("--deadline", type=float, default=math.inf)
    parser.add_argument("--resume", type=find_checkpoint)
    return parser.parse_args()


if __name__ == "__main__":
    main()

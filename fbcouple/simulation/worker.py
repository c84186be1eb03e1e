"""The run, in every MPI rank: `simulate` is the time loop.

Started by `fbcouple.launcher.launch` as `mpirun -n RANKS python -m fbcouple.simulation.worker RUN --ranks RANKS [...]`.
"""

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
from fbcouple.run_folder.checkpoint import describe, find_checkpoint
from fbcouple.run_folder.failure import write_failure
from fbcouple.run_folder.provenance import list_makers, read_making
from fbcouple.simulation.simulation import Simulation, open_simulation
from fbcouple.simulation.tasks.averages import sample_gas
from fbcouple.simulation.tasks.checkpoints import UNTIL, Checkpoints, Limits, StopSignal
from fbcouple.simulation.tasks.history import Recorder
from fbcouple.simulation.tasks.monitors import require_finite_gas, require_sound_exchange
from fbcouple.simulation.tasks.restart import RESTART, read_checkpoint


def simulate(sim: Simulation, recorder: Recorder, checkpoints: Checkpoints) -> None:
    """THE time loop: one pass is one coupling step, a fluid step of whole DEM steps."""
    start(sim)
    recorder.observe(sim)
    while sim.running:
        step(sim, recorder)
        if checkpoints.keep(sim, recorder):
            start(sim)
    recorder.save(sim)
    checkpoints.close(sim, recorder)


def step(sim: Simulation, recorder: Recorder) -> None:
    """One coupling step, looked at by the recorder."""
    take_step(sim)
    average(sim)
    recorder.observe(sim)


def take_step(sim: Simulation) -> None:
    """One coupling step; the next is as long as the Courant and Fourier numbers allow (collective)."""
    step_gas(sim)
    react(sim)
    move(sim)
    choose_step(sim)
    map_solids(sim)
    exert_drag(sim)


def start(sim: Simulation) -> None:
    """Set LIGGGHTS up and see the particles from the gas: at the start of a run, and at each moment for a checkpoint,
    because a run that goes on from one starts by this."""
    if sim.liggghts:
        with sim.timers("dem"):
            sim.liggghts.advance(0, first=True)
        sim.look_at_particles()
        sim.conservation.count(sim.liggghts.count)
    map_solids(sim)
    if sim.coupling and sim.gas:
        if sim.clock.steps == 0:
            sim.gas.start(sim.coupling.voidage)
            sim.remember_velocities()
        sim.coupling.read_gas(sim.gas.state)
        derive_fields(sim)
    exert_drag(sim)


def step_gas(sim: Simulation) -> None:
    """The step that the clock has chosen begins: one PISO step of the gas, under voidage and drag as they are."""
    sim.dt, sim.substeps = sim.clock.dt, sim.clock.substeps
    sim.moved = sim.clock.last_dt or sim.dt
    if sim.gas is None:
        return
    with sim.timers("wait"):
        sim.comm.Barrier()
    with sim.timers("cfd"):
        sim.gas.step(
            sim.dt,
            *(sim.coupling.gas_input if sim.coupling else sim.gas.clean_input),
            moved=sim.moved,
        )
        sim.gas_report = sim.gas.measure()
    require_finite_gas(sim)


def react(sim: Simulation) -> None:
    """What the gas gave up by drag and pressure gradient is the particles' impulse over the same step."""
    if sim.coupling and sim.gas and sim.liggghts:
        with sim.timers("react"):
            gas, liggghts = sim.gas, sim.liggghts
            drag = sim.coupling.react(sim.particles, gas.state, liggghts.gas_force, liggghts.forces)
            sim.conservation.give(sim.coupling.find_gas_loss(gas.given_up), drag, sim.dt)
            derive_fields(sim)


def move(sim: Simulation) -> None:
    """The particles take the sub-steps of the step under the force of the gas."""
    if sim.liggghts is None:
        return
    with sim.timers("dem"):
        sim.liggghts.advance(sim.substeps)
    sim.look_at_particles()
    with sim.timers("wait"):
        sim.comm.Barrier()
    with sim.timers("react"):
        if sim.coupling:
            sim.conservation.receive(sim.liggghts.gas_force, sim.dt, sim.find_momentum)
        else:
            sim.conservation.count(sim.liggghts.count)


def choose_step(sim: Simulation) -> None:
    """The step is done; the Courant and Fourier numbers of the gas choose the next."""
    sim.clock.tick()
    if sim.gas_report and sim.case.gas:
        gas, state = sim.case.gas, sim.gas_report
        sim.clock.choose(state.courant, state.fourier, gas.max_courant, gas.max_fourier)


def map_solids(sim: Simulation) -> None:
    """Solids to the cells: the voidage of the next gas step."""
    if sim.coupling:
        with sim.timers("map"):
            sim.coupling.map(sim.particles)


def exert_drag(sim: Simulation) -> None:
    """The drag of every particle, averaged over the next step, to the cells."""
    if sim.coupling:
        with sim.timers("drag"):
            sim.coupling.drag(sim.particles, sim.clock.dt, sim.clock.last_dt)
            require_sound_exchange(sim)


def derive_fields(sim: Simulation) -> None:
    """What lift, viscous force and virtual mass of the next step want to know of the gas."""
    if sim.coupling and sim.coupling.forces and sim.gas:
        sim.coupling.forces.read(sim.gas.derive(sim.coupling.forces.fields))


def average(sim: Simulation) -> None:
    """A sample for the time means, when one is due."""
    averaging, time = sim.averaging, sim.clock.time
    if averaging is None or not averaging.cadence.due(time):
        return
    with sim.timers("average"):
        if averaging.solids and averaging.sampler:
            p = sim.particles
            averaging.solids.add(averaging.sampler.sample(p.positions, p.velocities, p.radii, p.masses), time)
        if averaging.gas and sim.gas:
            averaging.gas.add(sample_gas(sim.gas.voidage, sim.gas.velocity, sim.gas.pressure), time)


def work(run: Path, limits: Limits, resume: Path | None, comm: MPI.Comm, stop_signal: StopSignal) -> None:
    """Run the case in `run` from its start, or from the checkpoint `resume` in it (collective); one that has to stop
    early leaves a note of it."""
    os.chdir(run)
    os.environ["PWD"] = str(run)
    here = Path(".")
    case = load_case("case.toml")
    made = read_making(here)
    about = describe(case, here, list_makers(made.versions), made.updates) if comm.rank == 0 else {}
    sim = open_simulation(case, here, comm, case.end_time, resume / RESTART if resume else None)
    recorder = Recorder(sim, here, Path("case.toml").read_text(encoding="utf-8-sig"), made.list_attributes())
    if resume:
        read_checkpoint(sim, recorder, resume)
    simulate(sim, recorder, Checkpoints(sim, here, limits, stop_signal, about))
    stopped_early = sim.stop not in ("", UNTIL)
    if sim.gas and not stopped_early:
        sim.gas.write()
    if sim.liggghts:
        sim.liggghts.close()
    if stopped_early and comm.rank == 0:
        write_failure(here, word_stop(sim), StoppedError.exit_code)
    if stop_signal.caught and not stopped_early:
        print(
            f"{signal.Signals(stop_signal.caught).name} came after the last moment to stop: the run went on to its end"
        )


def word_stop(sim: Simulation) -> str:
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
            f"MPI, {MPI.Get_library_version().split(',')[0].strip()}; mend: fbcouple doctor"
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

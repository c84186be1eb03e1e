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
from fbcouple.simulation.simulation import Scene, open_scene
from fbcouple.simulation.tasks.averages import sample_gas
from fbcouple.simulation.tasks.checkpoints import UNTIL, Keeper, Limits, Summons
from fbcouple.simulation.tasks.history import Recorder
from fbcouple.simulation.tasks.monitors import require_finite_gas, require_sound_exchange
from fbcouple.simulation.tasks.restart import RESTART, read_checkpoint


def simulate(scene: Scene, recorder: Recorder, keeper: Keeper) -> None:
    """THE time loop: one pass is one coupling step, a fluid step of whole DEM steps."""
    start(scene)
    recorder.observe(scene)
    while scene.running:
        step(scene, recorder)
        if keeper.keep(scene, recorder):
            start(scene)
    recorder.save(scene)
    keeper.close(scene, recorder)


def step(scene: Scene, recorder: Recorder) -> None:
    """One coupling step, looked at by the recorder."""
    take_step(scene)
    average(scene)
    recorder.observe(scene)


def take_step(scene: Scene) -> None:
    """One coupling step; the next is as long as the Courant and Fourier numbers allow (collective)."""
    step_gas(scene)
    react(scene)
    move(scene)
    choose_step(scene)
    map_solids(scene)
    exert_drag(scene)


def start(scene: Scene) -> None:
    """Set LIGGGHTS up and see the particles from the gas: at the start of a run, and at each moment for a checkpoint,
    because a run that goes on from one starts by this."""
    if scene.grains:
        with scene.watch("grains"):
            scene.grains.advance(0, first=True)
        scene.look_at_particles()
        scene.balance.count(scene.grains.count)
    map_solids(scene)
    if scene.coupling and scene.gas:
        if scene.clock.steps == 0:
            scene.gas.start(scene.coupling.voidage)
            scene.remember_velocities()
        scene.coupling.read_gas(scene.gas.state)
        derive_fields(scene)
    exert_drag(scene)


def step_gas(scene: Scene) -> None:
    """The step that the clock has chosen begins: one PISO step of the gas, under voidage and drag as they are."""
    scene.dt, scene.substeps = scene.clock.dt, scene.clock.substeps
    scene.moved = scene.clock.last_dt or scene.dt
    if scene.gas is None:
        return
    with scene.watch("wait"):
        scene.comm.Barrier()
    with scene.watch("gas"):
        scene.gas.step(
            scene.dt,
            *(scene.coupling.gas_input if scene.coupling else scene.gas.clean_input),
            moved=scene.moved,
        )
        scene.gas_state = scene.gas.measure()
    require_finite_gas(scene)


def react(scene: Scene) -> None:
    """What the gas gave up by drag and pressure gradient is the particles' impulse over the same step."""
    if scene.coupling and scene.gas and scene.grains:
        with scene.watch("react"):
            gas, grains = scene.gas, scene.grains
            drag = scene.coupling.react(scene.particles, gas.state, grains.gas_force, grains.forces)
            scene.balance.give(scene.coupling.find_gas_loss(gas.given_up), drag, scene.dt)
            derive_fields(scene)


def move(scene: Scene) -> None:
    """The particles take the sub-steps of the step under the force of the gas."""
    if scene.grains is None:
        return
    with scene.watch("grains"):
        scene.grains.advance(scene.substeps)
    scene.look_at_particles()
    with scene.watch("wait"):
        scene.comm.Barrier()
    with scene.watch("react"):
        if scene.coupling:
            scene.balance.receive(scene.grains.gas_force, scene.dt, scene.find_momentum)
        else:
            scene.balance.count(scene.grains.count)


def choose_step(scene: Scene) -> None:
    """The step is done; the Courant and Fourier numbers of the gas choose the next."""
    scene.clock.tick()
    if scene.gas_state and scene.case.gas:
        gas, state = scene.case.gas, scene.gas_state
        scene.clock.choose(state.courant, state.fourier, gas.max_courant, gas.max_fourier)


def map_solids(scene: Scene) -> None:
    """Solids to the cells: the voidage of the next gas step."""
    if scene.coupling:
        with scene.watch("map"):
            scene.coupling.map(scene.particles)


def exert_drag(scene: Scene) -> None:
    """The drag of every particle, averaged over the next step, to the cells."""
    if scene.coupling:
        with scene.watch("drag"):
            scene.coupling.drag(scene.particles, scene.clock.dt, scene.clock.last_dt)
            require_sound_exchange(scene)


def derive_fields(scene: Scene) -> None:
    """What lift, viscous force and virtual mass of the next step want to know of the gas."""
    if scene.coupling and scene.coupling.forces and scene.gas:
        scene.coupling.forces.read(scene.gas.derive(scene.coupling.forces.fields))


def average(scene: Scene) -> None:
    """A sample for the time means, when one is due."""
    averaging, time = scene.averaging, scene.clock.time
    if averaging is None or not averaging.cadence.due(time):
        return
    with scene.watch("average"):
        if averaging.solids and averaging.sampler:
            p = scene.particles
            averaging.solids.add(averaging.sampler.sample(p.positions, p.velocities, p.radii, p.masses), time)
        if averaging.gas and scene.gas:
            averaging.gas.add(sample_gas(scene.gas.voidage, scene.gas.velocity, scene.gas.pressure), time)


def work(run: Path, limits: Limits, resume: Path | None, comm: MPI.Comm, summons: Summons) -> None:
    """Run the case in `run` from its start, or from the checkpoint `resume` in it (collective); one that has to stop
    early leaves a note of it."""
    os.chdir(run)
    os.environ["PWD"] = str(run)
    here = Path(".")
    case = load_case("case.toml")
    made = read_making(here)
    about = describe(case, here, list_makers(made.versions), made.updates) if comm.rank == 0 else {}
    scene = open_scene(case, here, comm, case.end_time, resume / RESTART if resume else None)
    recorder = Recorder(scene, here, Path("case.toml").read_text(encoding="utf-8-sig"), made.list_attributes())
    if resume:
        read_checkpoint(scene, recorder, resume)
    simulate(scene, recorder, Keeper(scene, here, limits, summons, about))
    stopped_early = scene.stop not in ("", UNTIL)
    if scene.gas and not stopped_early:
        scene.gas.write()
    if scene.grains:
        scene.grains.close()
    if stopped_early and comm.rank == 0:
        write_failure(here, word_stop(scene), StoppedError.exit_code)
    if summons.caught and not stopped_early:
        print(f"{signal.Signals(summons.caught).name} came after the last moment to stop: the run went on to its end")


def word_stop(scene: Scene) -> str:
    """Say why the run stopped early and where it goes on."""
    return f"stopped by {scene.stop} at t = {scene.clock.time:.6g} s; checkpoint: {scene.checkpoint}"


def main() -> None:
    """Work; a failure on one rank writes down why and ends all ranks."""
    summons = Summons()
    options = read_options()
    run = options.run.resolve()
    try:
        require_together(MPI.COMM_WORLD, options.ranks)
        work(run, Limits(options.until, options.deadline), options.resume, MPI.COMM_WORLD, summons)
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

"""THE time loop: one pass is one coupling step, a gas step of whole DEM steps."""

from __future__ import annotations

from collections.abc import Sequence

from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.task import Task


def run(sim: Simulation, tasks: Sequence[Task]) -> None:
    """Take `sim`, initialised, to its end; every task looks at every step (collective)."""
    start(sim, tasks)
    while sim.proceed:
        step(sim, tasks)
    finish(sim, tasks)


def start(sim: Simulation, tasks: Sequence[Task]) -> None:
    """Show the tasks the simulation as it is before its first step."""
    for task in tasks:
        task.start(sim)


def step(sim: Simulation, tasks: Sequence[Task] = ()) -> None:
    """One coupling step, and the tasks look at it."""
    sim.step_gas()  # one PISO step, under voidage and drag as the last step left them
    sim.apply_gas_force()  # what the gas lost is the particles' impulse
    sim.apply_gas_heat()  # what heat the gas lost is theirs at once, where the case has heat
    sim.move_particles()  # the DEM steps of this step
    sim.choose_step()  # how long the next one is
    sim.exchange_particles()  # who leaves and who comes in, where the case has feeds or outlets of particles
    sim.map_solids()  # its voidage
    sim.deposit_drag()  # its drag
    sim.deposit_heat()  # its heat
    for task in tasks:
        task.after_step(sim)


def finish(sim: Simulation, tasks: Sequence[Task]) -> None:
    """Show the tasks the simulation after its last step, and leave its last fields in CFD/."""
    for task in tasks:
        task.finish(sim)
    sim.write_fields()

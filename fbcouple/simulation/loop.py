"""THE time loop: one pass is one coupling step, a gas step of whole DEM steps."""

from __future__ import annotations

from collections.abc import Sequence

from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.task import Task


def run(sim: Simulation, tasks: Sequence[Task]) -> None:
    """Take `sim` to its end; every task looks at every step (collective)."""
    start(sim, tasks)
    while sim.proceed:
        step(sim, tasks)
    for task in tasks:
        task.finish(sim)


def start(sim: Simulation, tasks: Sequence[Task]) -> None:
    """Set the solvers up, and show the tasks where they stand."""
    sim.initialise()
    for task in tasks:
        task.start(sim)


def step(sim: Simulation, tasks: Sequence[Task]) -> None:
    """Gas, gas force on the particles, DEM steps, choice of the next step, voidage, drag; then the tasks."""
    sim.step()
    for task in tasks:
        task.after_step(sim)

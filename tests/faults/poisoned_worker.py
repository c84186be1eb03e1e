"""The worker of a run with something put wrong behind a step: `python poisoned_worker.py POISON STEP RUN [...]`.

The solvers, the loop and the monitors are the real ones; only what a defect or a full disk would do is done by hand.
"""

from __future__ import annotations

import os
import resource
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np

from fbcouple.simulation import worker
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.monitors import Monitors

CELL, PARTICLE = 7, 17


def find_row(sim: Simulation) -> np.ndarray:
    """Row of the particle on the rank that has it."""
    return np.flatnonzero(sim.liggghts.numbers == PARTICLE)


def spoil_voidage(sim: Simulation, value: float) -> None:
    """From here on the voidage of a cell is `value` after every map."""
    mapped = sim.coupling.map

    def map_wrongly(particles) -> None:
        mapped(particles)
        sim.coupling.voidage[CELL] = value

    sim.coupling.map = map_wrongly


def nan_velocity(sim: Simulation) -> None:
    sim.gas.state[CELL, 2] = np.nan


def nan_drag(sim: Simulation) -> None:
    deposit = sim.coupling.deposit_drag

    def deposit_wrongly(*given) -> None:
        deposit(*given)
        sim.coupling.drag_sums[CELL, 0] = np.nan

    sim.coupling.deposit_drag = deposit_wrongly


def nan_particle(sim: Simulation) -> None:
    sim.liggghts.velocities[find_row(sim), 0] = np.nan


def outside(sim: Simulation) -> None:
    sim.liggghts.positions[find_row(sim), 0] = -1e-4


def far_outside(sim: Simulation) -> None:
    sim.liggghts.positions[find_row(sim), 2] = 1e3


def shot(sim: Simulation) -> None:
    """So fast that it is behind the wall before a contact can stop it."""
    sim.liggghts.velocities[find_row(sim), 1] = -500.0


def overlap(sim: Simulation) -> None:
    """Half a diameter over another particle, at rest against it."""
    row = find_row(sim)
    sim.liggghts.positions[row] = sim.liggghts.positions[row - 1] + np.array([0.0, 0.0, 0.5e-3])
    sim.liggghts.velocities[row] = sim.liggghts.velocities[row - 1]


def packed_voidage(sim: Simulation) -> None:
    spoil_voidage(sim, 0.05)


def negative_voidage(sim: Simulation) -> None:
    spoil_voidage(sim, -0.2)


def voidage_over_one(sim: Simulation) -> None:
    spoil_voidage(sim, 1.001)


def lost_momentum(sim: Simulation) -> None:
    """A particle gets more of the gas's impulse than its share."""
    apply = sim.coupling.apply_gas_force

    def apply_wrongly(particles, gas, coupling_force, total_force) -> float:
        drag = apply(particles, gas, coupling_force, total_force)
        coupling_force[find_row(sim), 0] += 1e-6
        return drag

    sim.coupling.apply_gas_force = apply_wrongly


def solids_volume(sim: Simulation) -> None:
    """A particle grows behind the gas's back, after the map of the step."""
    sim.liggghts.radii[find_row(sim)] *= 1.01


def gas_flux(sim: Simulation) -> None:
    sim.gas.velocity[:, 2] += 0.3


def courant(sim: Simulation) -> None:
    """A step that is far too long: the clock is told that the gas stands still."""
    choose = sim.clock.choose
    sim.clock.choose = lambda c, f, max_c, max_f: choose(c, f, 1e3 * max_c, 1e3 * max_f)


def substeps(sim: Simulation) -> None:
    courant(sim)


def fill(left: int) -> None:
    """Fill the disk of the run folder but for `left` bytes."""
    with Path("filler").open("wb", buffering=0) as file:
        with suppress(OSError):
            while True:
                file.write(bytes(4096))
        file.truncate(os.fstat(file.fileno()).st_size // 4096 * 4096 - left)


def forbid_long_files(longest: int) -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (longest, resource.RLIM_INFINITY))


LITTLE = 16384
DISKS: dict[str, Callable[[Simulation], None]] = {
    "full": lambda sim: fill(0),
    "nearly_full": lambda sim: fill(LITTLE),
    "no_longer_log": lambda sim: forbid_long_files(Path("logs/run.jsonl").stat().st_size + 1),
    # The history in the log grows on; what is to meet the limit is longer than it.
    "no_long_files": lambda sim: forbid_long_files(Path("logs/run.jsonl").stat().st_size + LITTLE // 2),
}

POISONS: dict[str, Callable[[Simulation], None]] = {
    function.__name__: function
    for function in (
        nan_velocity,
        nan_drag,
        nan_particle,
        outside,
        far_outside,
        shot,
        overlap,
        packed_voidage,
        negative_voidage,
        voidage_over_one,
        lost_momentum,
        solids_volume,
        gas_flux,
        courant,
        substeps,
    )
}


def poison_run(name: str, step: int) -> None:
    """Let the poison work once, behind the averages and before the monitors."""
    after_step = Monitors.after_step

    def after_step_poisoned(monitors: Monitors, sim: Simulation) -> None:
        if sim.clock.steps == step:
            (POISONS | DISKS)[name](sim)
        after_step(monitors, sim)

    Monitors.after_step = after_step_poisoned


if __name__ == "__main__":
    poison_run(sys.argv[1], int(sys.argv[2]))
    del sys.argv[1:3]
    worker.main()

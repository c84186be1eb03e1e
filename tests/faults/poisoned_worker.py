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
from fbcouple.simulation.simulation import Scene
from fbcouple.simulation.tasks.history import Recorder

CELL, PARTICLE = 7, 17


def find_row(scene: Scene) -> np.ndarray:
    """Row of the particle on the rank that has it."""
    return np.flatnonzero(scene.liggghts.numbers == PARTICLE)


def spoil_voidage(scene: Scene, value: float) -> None:
    """From here on the voidage of a cell is `value` after every map."""
    mapped = scene.coupling.map

    def map_wrongly(particles) -> None:
        mapped(particles)
        scene.coupling.voidage[CELL] = value

    scene.coupling.map = map_wrongly


def nan_velocity(scene: Scene) -> None:
    scene.gas.state[CELL, 2] = np.nan


def nan_drag(scene: Scene) -> None:
    exert = scene.coupling.drag

    def exert_wrongly(particles, dt, last_dt) -> None:
        exert(particles, dt, last_dt)
        scene.coupling.drag_sums[CELL, 0] = np.nan

    scene.coupling.drag = exert_wrongly


def nan_particle(scene: Scene) -> None:
    scene.liggghts.velocities[find_row(scene), 0] = np.nan


def outside(scene: Scene) -> None:
    scene.liggghts.positions[find_row(scene), 0] = -1e-4


def far_outside(scene: Scene) -> None:
    scene.liggghts.positions[find_row(scene), 2] = 1e3


def shot(scene: Scene) -> None:
    """So fast that it is behind the wall before a contact can stop it."""
    scene.liggghts.velocities[find_row(scene), 1] = -500.0


def overlap(scene: Scene) -> None:
    """Half a diameter over another particle, at rest against it."""
    row = find_row(scene)
    scene.liggghts.positions[row] = scene.liggghts.positions[row - 1] + np.array([0.0, 0.0, 0.5e-3])
    scene.liggghts.velocities[row] = scene.liggghts.velocities[row - 1]


def packed_voidage(scene: Scene) -> None:
    spoil_voidage(scene, 0.05)


def negative_voidage(scene: Scene) -> None:
    spoil_voidage(scene, -0.2)


def voidage_over_one(scene: Scene) -> None:
    spoil_voidage(scene, 1.001)


def lost_momentum(scene: Scene) -> None:
    """A particle gets more of the gas's impulse than its share."""
    react = scene.coupling.react

    def react_wrongly(particles, gas, held, current) -> float:
        drag = react(particles, gas, held, current)
        held[find_row(scene), 0] += 1e-6
        return drag

    scene.coupling.react = react_wrongly


def solids_volume(scene: Scene) -> None:
    """A particle grows behind the gas's back, after the map of the step."""
    scene.liggghts.radii[find_row(scene)] *= 1.01


def gas_flux(scene: Scene) -> None:
    scene.gas.velocity[:, 2] += 0.3


def courant(scene: Scene) -> None:
    """A step that is far too long: the clock is told that the gas stands still."""
    choose = scene.clock.choose
    scene.clock.choose = lambda c, f, max_c, max_f: choose(c, f, 1e3 * max_c, 1e3 * max_f)


def substeps(scene: Scene) -> None:
    courant(scene)


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
DISKS: dict[str, Callable[[Scene], None]] = {
    "full": lambda scene: fill(0),
    "nearly_full": lambda scene: fill(LITTLE),
    "no_longer_log": lambda scene: forbid_long_files(Path("logs/run.jsonl").stat().st_size + 1),
    # The history in the log grows on; what is to meet the limit is longer than it.
    "no_long_files": lambda scene: forbid_long_files(Path("logs/run.jsonl").stat().st_size + LITTLE // 2),
}

POISONS: dict[str, Callable[[Scene], None]] = {
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
    """Let the poison work once, behind average and before the look of the recorder."""
    observe = Recorder.observe

    def observe_poisoned(recorder: Recorder, scene: Scene) -> None:
        if scene.clock.steps == step:
            (POISONS | DISKS)[name](scene)
        observe(recorder, scene)

    Recorder.observe = observe_poisoned


if __name__ == "__main__":
    poison_run(sys.argv[1], int(sys.argv[2]))
    del sys.argv[1:3]
    worker.main()

"""The worker of a run that waits somewhere until a signal comes: `python held_worker.py WHERE NUMBER RUN [...]`.

A run that is held does not end by itself, however long whoever is to stop or kill it takes. The solvers, the loop and
the files are the real ones.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fbcouple.run_folder import checkpoint
from fbcouple.simulation import worker
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.checkpoints import StopSignal
from fbcouple.simulation.tasks.monitors import Monitors

LONGEST = 900.0
"""Wall time [s] after which nobody will come any more."""
heard: list[StopSignal] = []


def hold(number: str) -> None:
    """Leave a mark and wait for a signal to this rank."""
    Path(f"held-{number}").touch()
    limit = time.monotonic() + LONGEST
    while not heard[0].caught:
        assert time.monotonic() < limit, "nobody stopped the run"
        time.sleep(0.005)


def hold_at_step(step: int) -> None:
    """Every rank waits behind the step, before its row is written."""
    after_step = Monitors.after_step

    def after_step_held(monitors: Monitors, sim: Simulation) -> None:
        if sim.clock.steps == step:
            hold(str(sim.comm.rank))
        after_step(monitors, sim)

    Monitors.after_step = after_step_held


def hold_in_checkpoint(name: str) -> Callable[[int], None]:
    """A rank waits in the checkpoint of a number, before `checkpoint.NAME` does its part of it."""

    def hold_in(number: int) -> None:
        part = getattr(checkpoint, name)
        calls: list[None] = []

        def part_held(*arguments: Any) -> Any:
            calls.append(None)
            if len(calls) == number:
                hold(str(worker.MPI.COMM_WORLD.rank))
            return part(*arguments)

        setattr(checkpoint, name, part_held)

    return hold_in


WHERE: dict[str, Callable[[int], None]] = {
    "step": hold_at_step,
    "checkpoint": hold_in_checkpoint("add_up"),
    "finish": hold_in_checkpoint("finish"),
}


def listen(work: Callable[..., None]) -> Callable[..., None]:
    """`work` that lets the hold know of the signals."""

    def work_heard(*arguments: Any) -> None:
        heard.append(arguments[-1])
        work(*arguments)

    return work_heard


if __name__ == "__main__":
    worker.work = listen(worker.work)
    WHERE[sys.argv[1]](int(sys.argv[2]))
    del sys.argv[1:3]
    worker.main()

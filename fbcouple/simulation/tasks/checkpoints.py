"""Writes checkpoints, and says when the run has to stop early.

A checkpoint may be written every `checkpoint.moment_steps` coupling steps. There LIGGGHTS is set up anew, whether a
checkpoint is written or not, because a run that goes on from a checkpoint starts by that; so a checkpoint changes
nothing in the run, and a resumed run equals the uninterrupted one to the last bit. Whatever asks for a checkpoint, a
cadence, a signal, the wall limit or `--until`, gets it at the next such step, and a run that stops stops there.
"""

from __future__ import annotations

import math
import signal
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

from mpi4py import MPI

from fbcouple.machine.stop_signals import LONGEST_WAIT, SIGNALS, WALL_LIMIT
from fbcouple.paths import HEARTBEAT
from fbcouple.simulation.clock import Cadence
from fbcouple.simulation.simulation import UNTIL, Simulation
from fbcouple.simulation.tasks.monitors import Monitors
from fbcouple.simulation.tasks.restart import write_checkpoint
from fbcouple.simulation.tasks.task import Task

# Room before the wall limit: this many times the longest stretch between two such steps and the longest checkpoint.
_ROOM = 2.0
_BEAT_EVERY = 1.0
_ALMOST = 1.0 - 1e-9


@dataclass(frozen=True)
class Limits:
    """What a run is given beside its case."""

    until: float = math.inf
    """Simulated time [s] at or after which to stop."""
    deadline: float = math.inf
    """Before which it has to be over: on the clock of this machine that runs on evenly (time.monotonic) [s]."""


class StopSignal:
    """The last of the signals that ask this rank to stop; it listens from its making on."""

    def __init__(self) -> None:
        self.caught = 0
        self.listen()

    def listen(self) -> None:
        """Take the signals, again where a solver has set handlers of its own."""
        for number in SIGNALS:
            signal.signal(number, self._catch)

    def _catch(self, number: int, frame: FrameType | None) -> None:
        self.caught = number


class Checkpoints(Task):
    """The last of the tasks: it saves the others."""

    def __init__(
        self,
        sim: Simulation,
        run: Path,
        limits: Limits,
        stop_signal: StopSignal,
        about: dict[str, Any],
        monitors: Monitors,
        tasks: Sequence[Task],
    ) -> None:
        """`about`: what `checkpoint.describe` says of the run, on rank 0; `tasks`: what is saved beside the solvers."""
        options = sim.case.checkpoint
        self._run, self._limits, self._monitors, self._tasks = run, limits, monitors, tasks
        self._about = about
        self._steps, self._wall = options.moment_steps, options.wall_every
        self._cadence = Cadence(options.every, options.every) if options.every else None
        self._stop_signal = stop_signal
        stop_signal.listen()
        self._written = self._last = self._stepped = time.monotonic()
        self._stretch = self._step = self._writing = self._beaten = 0.0
        self._heard: float | None = None

    def after_step(self, sim: Simulation) -> None:
        """Where a checkpoint may be written: write it if one is due or the run has to stop, and set LIGGGHTS up anew
        if the run goes on (collective)."""
        self._beat(sim.comm)
        clock = sim.clock
        if not clock.running:
            return
        is_moment = clock.steps % self._steps == 0
        due, why = self._agree(sim.comm, clock.time, is_moment)
        sim.stop = sim.stop or why
        if due or sim.stop:
            with sim.timers("record"):
                self._write(sim, is_moment)
        if is_moment and sim.has_particles and not sim.stop:
            sim.initialise()

    def finish(self, sim: Simulation) -> None:
        """At the end of the case: a checkpoint, for a run that is to be made longer (collective)."""
        if not sim.stop:
            self._write(sim, True)

    def _beat(self, comm: MPI.Comm) -> None:
        now = time.monotonic()
        if comm.rank == 0 and now - self._beaten > _BEAT_EVERY:
            self._beaten = now
            (self._run / HEARTBEAT).touch()

    def _agree(self, comm: MPI.Comm, now: float, is_moment: bool) -> tuple[bool, str]:
        """Is a checkpoint due, and why has the run to stop, if it has: the same on every rank.

        Between two moments a run stops only where it cannot wait for the next one: a signal came `LONGEST_WAIT` ago, or
        the wall limit leaves no room for another step.
        """
        clock = time.monotonic()
        caught, due = self._stop_signal.caught, False
        self._heard = self._heard or (clock if caught else None)
        self._step, self._stepped = max(self._step, clock - self._stepped), clock
        longest = self._step
        if is_moment:
            self._stretch, self._last = max(self._stretch, clock - self._last), clock
            longest, due = self._stretch, clock - self._written > self._wall
        elif self._heard is None or clock - self._heard < LONGEST_WAIT:
            caught = 0
        late = comm.rank == 0 and clock + _ROOM * (longest + self._writing) > self._limits.deadline  # the launcher's
        caught, late, due = comm.allreduce((caught, late, due), _merge)
        if is_moment and self._cadence and self._cadence.due(now):
            due = True
        if is_moment and now >= self._limits.until * _ALMOST:
            return due, UNTIL
        return due, signal.Signals(caught).name if caught else WALL_LIMIT if late else ""

    def _write(self, sim: Simulation, is_moment: bool) -> None:
        begin = time.monotonic()
        self._monitors.inspect(sim)
        about = self._about
        if not is_moment and about:
            text = f"from t = {sim.time:.6g} s on: stopped between two moments for a checkpoint ({sim.stop})"
            about = about | {"updates": [*about["updates"], f"{text}, equal to an uninterrupted run up to rounding"]}
        sim.checkpoint = write_checkpoint(sim, self._tasks, self._run, about)
        self._written = time.monotonic()
        self._writing = max(self._writing, self._written - begin)


def _merge(one: tuple[int, bool, bool], other: tuple[int, bool, bool]) -> tuple[int, bool, bool]:
    return max(one[0], other[0]), one[1] or other[1], one[2] or other[2]

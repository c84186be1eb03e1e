"""Keeps a run: writes checkpoints at its moments, and says when it has to stop early.

A moment comes every `checkpoint.moment_steps` coupling steps. There LIGGGHTS is set up anew, whether a checkpoint is
written or not, because a run that goes on from a checkpoint starts by that; so a checkpoint changes nothing in the
run, and a resumed run equals the uninterrupted one to the last bit. Whatever asks for a checkpoint, a cadence, a
signal, the wall limit or `--until`, gets it at the next moment, and a run that stops stops there.
"""

from __future__ import annotations

import math
import signal
import time
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

from mpi4py import MPI

from fbcouple.paths import PULSE
from fbcouple.simulation.clock import Cadence
from fbcouple.simulation.simulation import Simulation
from fbcouple.simulation.tasks.history import Recorder
from fbcouple.simulation.tasks.restart import write_checkpoint

SIGNALS = (signal.SIGTERM, signal.SIGUSR1, signal.SIGINT)
# Room before the wall limit: this many times the longest stretch between two moments and the longest checkpoint.
_ROOM = 2.0
_PULSE_EVERY = 1.0
_ALMOST = 1.0 - 1e-9
UNTIL = "--until"
"""Why a run stops that has come as far as it was asked to."""


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


class Checkpoints:
    """Asked after every coupling step; collective at moments only."""

    def __init__(
        self, sim: Simulation, run: Path, limits: Limits, stop_signal: StopSignal, about: dict[str, Any]
    ) -> None:
        """`about`: what `checkpoint.describe` says of the run, on rank 0."""
        options = sim.case.checkpoint
        self._run, self._limits = run, limits
        self._about = about
        self._steps, self._wall = options.moment_steps, options.wall_every
        self._cadence = Cadence(options.every, options.every) if options.every else None
        self._summons = stop_signal
        stop_signal.listen()
        self._began = self._written = self._last = time.monotonic()
        self._stretch = self._writing = self._beaten = 0.0

    def keep(self, sim: Simulation, recorder: Recorder) -> bool:
        """At a moment: a checkpoint if one is due or the run has to stop; must LIGGGHTS be set up anew (collective)?"""
        self._beat(sim.comm)
        clock = sim.clock
        if clock.steps % self._steps or not clock.running:
            return False
        due, sim.stop = self._agree(sim.comm, clock.time)
        with sim.timers("record"):
            if due or sim.stop:
                self._write(sim, recorder)
        return not sim.stop and sim.liggghts is not None

    def close(self, sim: Simulation, recorder: Recorder) -> None:
        """At the end of the case: a checkpoint, for a run that is to be made longer (collective)."""
        if not sim.stop:
            self._write(sim, recorder)

    def _beat(self, comm: MPI.Comm) -> None:
        now = time.monotonic()
        if comm.rank == 0 and now - self._beaten > _PULSE_EVERY:
            self._beaten = now
            (self._run / PULSE).touch()

    def _agree(self, comm: MPI.Comm, now: float) -> tuple[bool, str]:
        """Is a checkpoint due, and why has the run to stop, if it has: the same on every rank."""
        moment = time.monotonic()
        self._stretch = max(self._stretch, moment - self._last)
        self._last = moment
        room = _ROOM * (self._stretch + self._writing)
        late = comm.rank == 0 and moment + room > self._limits.deadline  # on the host of the launcher
        due = moment - self._written > self._wall
        caught, late, due = comm.allreduce((self._summons.caught, late, due), _merge)
        if self._cadence and self._cadence.due(now):
            due = True
        if now >= self._limits.until * _ALMOST:
            return due, UNTIL
        return due, signal.Signals(caught).name if caught else "the wall limit" if late else ""

    def _write(self, sim: Simulation, recorder: Recorder) -> None:
        begin = time.monotonic()
        recorder.inspect(sim)
        sim.checkpoint = write_checkpoint(sim, recorder, self._run, self._about)
        self._written = time.monotonic()
        self._writing = max(self._writing, self._written - begin)


def _merge(one: tuple[int, bool, bool], other: tuple[int, bool, bool]) -> tuple[int, bool, bool]:
    return max(one[0], other[0]), one[1] or other[1], one[2] or other[2]

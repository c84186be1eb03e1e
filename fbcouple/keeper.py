"""Keeps a run: writes checkpoints at its moments, and says when it has to stop early.

A moment comes every `checkpoint.moment_steps` coupling steps. There LIGGGHTS is set up anew, whether a checkpoint is
written or not, because a run that goes on from a checkpoint starts by that; so a checkpoint changes nothing in the
run, and a resumed run equals the uninterrupted one to the last bit. Whatever asks for a checkpoint, a cadence, a
signal or the wall limit, gets it at the next moment.
"""

from __future__ import annotations

import math
import signal
import time
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from mpi4py import MPI

from fbcouple.checkpoint import fingerprint
from fbcouple.clock import Cadence
from fbcouple.places import PULSE
from fbcouple.recorder import Recorder
from fbcouple.scene import Scene
from fbcouple.state import write_checkpoint

SIGNALS = (signal.SIGTERM, signal.SIGUSR1, signal.SIGINT)
# Room before the wall limit: this many times the longest stretch between two moments and the longest checkpoint.
_ROOM = 2.0
_PULSE_EVERY = 1.0


@dataclass(frozen=True)
class Limits:
    """What a run is given beside its case."""

    end: float
    """Simulated time [s] to run to."""
    deadline: float = math.inf
    """Wall time (seconds since the epoch) before which it has to be over."""


class Keeper:
    """Asked after every coupling step; collective at moments only."""

    def __init__(self, scene: Scene, run: Path, limits: Limits) -> None:
        """Signals are this object's from here on (the solvers have set their own handlers before)."""
        options = scene.case.checkpoint
        self._run, self._limits = run, limits
        self._fingerprint = fingerprint(scene.case)
        self._steps, self._wall = options.moment_steps, options.wall_every
        self._cadence = Cadence(options.every, options.every) if options.every else None
        self._caught = 0
        self._began = self._written = self._last = time.monotonic()
        self._stretch = self._writing = self._beaten = 0.0
        for number in SIGNALS:
            signal.signal(number, self._catch)

    def keep(self, scene: Scene, recorder: Recorder) -> None:
        """At a moment, and where the run ends before its case does: a checkpoint if one is due (collective)."""
        self._beat(scene.comm)
        clock = scene.clock
        ends_early = not clock.running and clock.time < scene.case.end_time * (1 - 1e-9)
        if not ends_early and (clock.steps % self._steps or not clock.running):
            return
        due, scene.stop = self._agree(scene.comm, clock.time)
        with scene.watch("record"):
            if due or scene.stop or ends_early:
                self._write(scene, recorder)
            if clock.running and not scene.stop and scene.grains:
                scene.grains.advance(0, first=True)
                scene.look_at_particles()

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
        late = time.time() + room > self._limits.deadline
        due = moment - self._written > self._wall
        caught, late, due = comm.allreduce((self._caught, late, due), _merge)
        if self._cadence and self._cadence.due(now):
            due = True
        return due, signal.Signals(caught).name if caught else "the wall limit" if late else ""

    def _write(self, scene: Scene, recorder: Recorder) -> None:
        begin = time.monotonic()
        scene.checkpoint = write_checkpoint(scene, recorder, self._run, self._fingerprint)
        self._written = time.monotonic()
        self._writing = max(self._writing, self._written - begin)

    def _catch(self, number: int, frame: FrameType | None) -> None:
        self._caught = number


def _merge(one: tuple[int, bool, bool], other: tuple[int, bool, bool]) -> tuple[int, bool, bool]:
    return max(one[0], other[0]), one[1] or other[1], one[2] or other[2]

"""Time: a constant DEM step, fluid steps that are whole numbers of it, and what is due when."""

from __future__ import annotations

import math
from typing import Any

_GROWTH = 1.2
ALMOST = 1.0 - 1e-9
_TINY = 1e-300
_SHARED = 10
"""Steps up to the end of a run that share out the time left, in place of a stub for the last."""


class Clock:
    """Chooses each coupling step from the Courant and Fourier limits and the DEM step.

    With particles a step is `substeps` DEM steps. A limit that asks for less than one DEM step gets one: the step
    then exceeds the limit, which `max_courant` in the results shows.
    """

    _STATE = ("time", "steps", "substeps", "dt", "last_dt", "_substeps_done")

    def __init__(self, end: float, dem_step: float | None, first_step: float, longest: float = math.inf) -> None:
        """`first_step` [s] stands until `choose` is called; with particles it is rounded down to whole DEM steps.

        No chosen step is longer than `longest` [s].
        """
        self.time = 0.0
        self.steps = 0
        self.last_dt = 0.0
        """Length of the step taken last [s]; 0 before the first."""
        self._end = end
        self._longest = longest
        self._dem_step = dem_step
        self._substeps_done = 0
        self.substeps = max(1, int(first_step / dem_step * (2.0 - ALMOST))) if dem_step else 0
        self.dt = first_step
        self._end_in_time()

    @property
    def running(self) -> bool:
        """Is there time left?"""
        return self.time < self._end * ALMOST

    def end_here(self) -> None:
        """Let the run end with the step just taken."""
        self._end = self.time

    def tick(self) -> None:
        """The step `dt` was taken."""
        self.steps += 1
        self.last_dt = self.dt
        if self._dem_step is None:
            self.time += self.dt
        else:
            self._substeps_done += self.substeps
            self.time = self._substeps_done * self._dem_step
        self._end_in_time()

    def choose(
        self, courant: float, fourier: float, max_courant: float, max_fourier: float, longest: float = math.inf
    ) -> None:
        """Choose the next step from the numbers of the last one and their limits; it grows by a fifth at most and is no
        longer than `longest` [s]."""
        longest = min(longest, self._longest)
        room = min(max_courant / max(courant, _TINY), max_fourier / max(fourier, _TINY))
        if self._dem_step is None:
            self.dt = min(self.dt * min(room, _GROWTH), longest)
        else:
            # One more sub-step is always a growth allowed, or a few sub-steps could never grow by a fifth.
            growth = max(int(_GROWTH * self.substeps), self.substeps + 1)
            self.substeps = max(1, min(int(min(room * self.dt, longest) / self._dem_step), growth))
        self._end_in_time()

    def save(self) -> dict[str, Any]:
        """What `load` needs to go on from here."""
        return {name: getattr(self, name) for name in self._STATE}

    def load(self, state: dict[str, Any]) -> None:
        """Go on from `state`, to this clock's own end; no step is longer than it allows, whatever `state` chose."""
        for name in self._STATE:
            setattr(self, name, state[name])
        if self._dem_step is None:
            self.dt = min(self.dt, self._longest)
        elif self._longest < math.inf:
            self.substeps = max(1, min(self.substeps, int(self._longest / self._dem_step)))
        self._end_in_time()

    def _end_in_time(self) -> None:
        """Share out what is left up to the end among the last steps, none longer than the one chosen, all as long or a
        DEM step shorter. At the end the step stands as it is, for a run that is made longer."""
        left = self._end - self.time
        if self._dem_step is None:
            steps = math.ceil(left / self.dt * ALMOST)
            if 0 < steps <= _SHARED:
                self.dt = left / steps
            return
        substeps_left = math.ceil(left / self._dem_step - 1e-6)
        steps = math.ceil(substeps_left / self.substeps)
        if 0 < steps <= _SHARED:
            self.substeps = math.ceil(substeps_left / steps)
        self.dt = self.substeps * self._dem_step


class Cadence:
    """Says when something is due: at the first step at or after each multiple of `every` [s], from `start` on."""

    def __init__(self, every: float, start: float = 0.0) -> None:
        self._every = every
        self.next = start
        """When it is due next [s]."""

    def is_due(self, time: float) -> bool:
        """Would it be due at `time`? Asking changes nothing."""
        return time >= self.next * ALMOST

    def due(self, time: float) -> bool:
        """Is it due at `time`? Asking moves on to the next multiple."""
        if not self.is_due(time):
            return False
        self.next = (math.floor(time / self._every * (2.0 - ALMOST)) + 1) * self._every
        return True

"""Wall time by stage, or processor time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager


class Timers:
    """Adds up the seconds of named stages on a clock, by default that of the wall."""

    def __init__(self, stages: Sequence[str], clock: Callable[[], float] = time.perf_counter) -> None:
        self.seconds = dict.fromkeys(stages, 0.0)
        self._clock = clock

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Count the time of the block under `stage`."""
        begin = self._clock()
        yield
        self.seconds[stage] += self._clock() - begin

    def restart(self) -> dict[str, float]:
        """The seconds so far; counting starts again from zero."""
        seconds = dict(self.seconds)
        self.seconds = dict.fromkeys(seconds, 0.0)
        return seconds

"""Wall time by stage."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager


class Timers:
    """Adds up the wall seconds of named stages."""

    def __init__(self, stages: Sequence[str]) -> None:
        self.seconds = dict.fromkeys(stages, 0.0)

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Count the time of the block under `stage`."""
        begin = time.perf_counter()
        yield
        self.seconds[stage] += time.perf_counter() - begin

    def restart(self) -> dict[str, float]:
        """The seconds so far; counting starts again from zero."""
        seconds = dict(self.seconds)
        self.seconds = dict.fromkeys(seconds, 0.0)
        return seconds
